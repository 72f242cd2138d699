#include "app/report/machine.h"

#include <unistd.h>

#include <fstream>

#include "core/base/system/processors.h"

namespace skybody {

std::string machine_name() {
  char name[256] = {};
  if (gethostname(name, sizeof name - 1) != 0) return "unknown";
  return name;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

int processor_count() { return static_cast<int>(allowed_processors().size()); }

}  // namespace skybody
