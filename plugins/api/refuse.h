// Errors of plugins: messages for the user.
#pragma once

#include <stdexcept>
#include <string>
#include <type_traits>

#include "core/plugin_abi/text.h"  // IWYU pragma: export

namespace skybody {
namespace plugin_detail {

template <class T>
std::string text_of(const T& part) {
  if constexpr (std::is_floating_point_v<T>) {
    return to_text(part);
  } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, char>) {
    return std::to_string(part);
  } else {
    return std::string() + part;
  }
}

}  // namespace plugin_detail

/// Refuses the scenario: its parts, texts and numbers, become the message.
/// @throws std::runtime_error always
template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw std::runtime_error((std::string() + ... + plugin_detail::text_of(parts)));
}

}  // namespace skybody
