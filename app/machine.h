// What a measurement was made on.
#pragma once

#include <string>

namespace skybody {

/// The host's name.
std::string machine_name();
/// The processor's model, as the system calls it.
std::string processor_name();
/// Logical processors.
int processor_count();

}  // namespace skybody
