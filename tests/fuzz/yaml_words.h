// Words of scenarios: keys, plugins and YAML syntax.
#pragma once

#include <string>
#include <vector>

namespace skybody::fuzz {

std::vector<std::string> yaml_words();

}  // namespace skybody::fuzz
