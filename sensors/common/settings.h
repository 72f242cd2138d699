// Declarations of parameters that several sensors have.
#pragma once

#include <skybody/plugin.h>

namespace skybody::sensor {

/// A magnitude of an error: 0 or more, 0 by default, and drawn per episode if asked for. It has a
/// value per environment only where the scenario sets it.
inline RealSpec error_size(const char* name, const char* unit, const char* doc) {
  return when_given(real(name, unit, 0.0, at_least(0.0), doc));
}

}  // namespace skybody::sensor
