#include "core/model/state_layout.h"

namespace skybody {

int StateLayout::find_param(const std::string& path) const {
  if (path.empty()) return -1;
  for (std::size_t i = 0; i < param_info.size(); ++i) {
    const EnvParam& param = param_info[i];
    if (param.path == path || param.alias == path) return static_cast<int>(i);
  }
  return -1;
}

std::vector<double> StateLayout::nominal_params() const {
  std::vector<double> values;
  for (const EnvParam& param : param_info) values.push_back(param.nominal);
  return values;
}

}  // namespace skybody
