#include "core/model/layout.h"

namespace skybody {

int Layout::find_param(const std::string& path) const {
  for (std::size_t i = 0; i < param_info.size(); ++i) {
    if (param_info[i].path == path) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace skybody
