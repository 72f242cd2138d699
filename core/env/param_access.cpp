#include "core/env/param_access.h"

#include <sstream>

#include "core/base/error.h"

namespace skybody {
namespace {

int index_of(const Environment& environment, const std::string& path) {
  const int index = environment.layout().find_param(path);
  if (index < 0) {
    throw Error("nothing randomizable is called `" + path +
                "`; `skybody check --parameters` lists what is");
  }
  return index;
}

}  // namespace

double get_param(const Environment& environment, const StateGroup& group, int lane,
                 const std::string& path) {
  const int index = index_of(environment, path);
  return group.reals(environment.layout().params.offset + index)[lane];
}

void set_param(const Environment& environment, StateGroup& group, int lane, const std::string& path,
               double value) {
  const int index = index_of(environment, path);
  const EnvParam& info = environment.layout().param_info[static_cast<std::size_t>(index)];
  if (!(value >= info.min && value <= info.max)) {
    std::ostringstream message;
    message << path << " = " << value << " is outside [" << info.min << ", " << info.max << "] "
            << info.unit;
    throw Error(message.str());
  }
  group.writable({environment.layout().params.offset + index, 1}, 1u << lane)[lane] = value;
}

}  // namespace skybody
