#include "core/env/param_access.h"

#include <sstream>

#include "core/base/error.h"

namespace skybody {
namespace {

int index_of(const CompiledScenario& compiled, const std::string& path) {
  const int index = compiled.layout().find_param(path);
  if (index < 0) {
    throw Error("nothing randomizable is called `" + path +
                "`; `skybody check --parameters` lists what is");
  }
  return index;
}

}  // namespace

double get_param(const CompiledScenario& compiled, const StateGroup& group, int lane,
                 const std::string& path) {
  const int index = index_of(compiled, path);
  return group.reals(compiled.layout().params.offset + index)[lane];
}

void set_param(const CompiledScenario& compiled, StateGroup& group, int lane,
               const std::string& path, double value) {
  const int index = index_of(compiled, path);
  const EnvParam& info = compiled.layout().param_info[static_cast<std::size_t>(index)];
  if (!(value >= info.min && value <= info.max)) {
    std::ostringstream message;
    message << path << " = " << value << " is outside [" << info.min << ", " << info.max << "] "
            << info.unit;
    throw Error(message.str());
  }
  group.writable({compiled.layout().params.offset + index, 1}, 1u << lane)[lane] = value;
}

}  // namespace skybody
