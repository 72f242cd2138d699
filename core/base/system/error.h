// The two kinds of failure: the user's errors, and bugs of Skybody.
#pragma once

#include <stdexcept>
#include <string>

namespace skybody {

/// An error that the user can correct. Its message has the value, the allowed range and the remedy:
/// "`action_repeat` is 0; allowed: 1 .. 100000; set stepping.action_repeat".
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

namespace detail {
/// @throws std::logic_error always.
[[noreturn]] inline void fail_demand(const char* file, int line, const char* condition,
                                     const std::string& message) {
  throw std::logic_error(std::string(file) + ":" + std::to_string(line) + ": " + message +
                         " (demanded: " + condition +
                         "); this is a bug in Skybody, please report it");
}
}  // namespace detail

}  // namespace skybody

/// Asserts an invariant of Skybody; false means a bug in Skybody. Enabled in every build.
/// @throws std::logic_error with file, line and message if the condition is false.
#define SKYBODY_DEMAND(condition, message) \
  (static_cast<bool>(condition)            \
       ? static_cast<void>(0)              \
       : ::skybody::detail::fail_demand(__FILE__, __LINE__, #condition, (message)))
