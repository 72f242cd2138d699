#include "core/env/fault_reasons.h"

#include <array>

#include "core/env/fault_cause.h"
#include "core/model/fault_reason.h"
#include "core/physics/bodies/checked_mass.h"

namespace skybody {

std::uint64_t FaultReasons::bad_state_bits(const StateGroup& group, int lane) const {
  std::array<double, kBodyParamCount> values;
  for (std::size_t b = 0; b < model_.world->bodies.size(); ++b) {
    const int first = model_.layout().params.offset + model_.layout().body_params[b];
    for (int k = 0; k < kBodyParamCount; ++k) {
      values[static_cast<std::size_t>(k)] = group.reals(first + k)[lane];
    }
    if (is_possible(mass_properties(values.data()))) continue;
    return kBadState | (static_cast<std::uint64_t>(b) + 1) << kBadStartPlace;
  }
  return kBadState | cause_bits(*model_.world, group, lane);
}

/// The message about a body whose inertia is not physical. @param status  that contains its index
std::string FaultReasons::impossible_body_text(std::uint64_t status) const {
  const int number = impossible_body(status);
  const WorldBody& body = model_.world->bodies[static_cast<std::size_t>(number)];
  const std::string path = "robots." +
                           model_.scenario().robots[static_cast<std::size_t>(body.robot)].name +
                           ".links." + body.model->name;
  return "no rigid body has the mass, centre and inertia of `" + path +
         "`: a mass is above 0, and no principal moment above the sum of the other two; narrow "
         "what randomizers draw or callers set: its `.mass`, `.com[0]` and `.inertia[0]` to `[5]` "
         "are what state() reads until the next reset, and what a flight log has under `params`";
}

std::string FaultReasons::text(std::uint64_t status) const {
  std::uint64_t told = 0;  // bits explained by a longer text
  std::string full;
  if (impossible_body(status) >= 0) {
    told = kBadState;
    full = impossible_body_text(status);
  } else if ((status & kBadStart) != 0 && overlaps_ != nullptr) {
    told = kBadStart;
    full = overlaps_->reason(status);
  } else if (const std::string cause = cause_text(*model_.world, status); !cause.empty()) {
    told = kBadState;
    full = fault_reason(kFault | kBadState) + ": " + cause;
  }
  const std::string others = fault_reason(status & ~told);
  return others + (others.empty() || full.empty() ? "" : "; ") + full;
}

}  // namespace skybody
