// The machine of a measurement.
#pragma once

#include <string>

namespace skybody {

/// The host's name.
std::string machine_name();
/// The processor's model, as the system reports it.
std::string processor_name();
/// Logical processors.
int processor_count();

}  // namespace skybody
