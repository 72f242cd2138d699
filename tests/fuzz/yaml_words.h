// Words of scenarios: keys, plugins and what YAML gives a meaning to.
#pragma once

#include <string>
#include <vector>

namespace skybody::fuzz {

std::vector<std::string> yaml_words();

}  // namespace skybody::fuzz
