// Advice about numbers that are written with their unit.
#pragma once

#include <string>
#include <string_view>

namespace skybody {

/// Advice about a text in place of a number, to follow "allowed: a number ...":
/// - "; do you mean 0.001?" for a number with a unit of `unit`'s kind, such as `1ms` for s
/// - "; write the number without a unit" for one with another word
/// - empty for other texts
std::string unit_hint(std::string_view text, std::string_view unit);

}  // namespace skybody
