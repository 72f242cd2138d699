// Missions for the program onboard.
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "onboard/export_mission.h"
#include "python/native/bindings.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {
namespace {

nb::bytes mission_bytes(const LoadedScenario& compiled, const std::string& policy, int agent,
                        const std::map<std::string, std::vector<double>>& limits) {
  onboard::Limits wanted;
  for (const auto& [name, values] : limits) onboard::set_limit(wanted, name, values);
  std::string bytes;
  {
    const nb::gil_scoped_release release;
    auto mission = onboard::make_mission(compiled.options(), read_policy(policy), agent, wanted);
    bytes = onboard::to_bytes(mission);
  }
  return nb::bytes(bytes.data(), bytes.size());
}

}  // namespace

void bind_mission(nb::module_& m) {
  m.def("mission_bytes", &mission_bytes, nb::arg("compiled"), nb::arg("policy"),
        nb::arg("agent") = 0, nb::arg("limits") = std::map<std::string, std::vector<double>>{},
        "The content of a mission for the program onboard (docs/onboard.md).\n\n"
        "policy: policy.h5\n"
        "agent: place among the robots that share the policy\n"
        "limits: stale, lateness, safe_time [s], tilt [rad], safe (0 stop, 1 descend), "
        "safe_thrust, one value each; fence: x, y, z, x, y, z [m], W\n\n"
        "Raises Error if the policy does not fit, sees images, or flies several robots at once, "
        "and for another limit.");
}

}  // namespace skybody::python
