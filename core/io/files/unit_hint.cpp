#include "core/io/files/unit_hint.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "core/io/files/text.h"

namespace skybody {
namespace {

/// A unit that users write, in terms of a unit of Skybody.
struct UnitRow {
  std::string_view written, unit;
  double factor;
};

constexpr UnitRow kUnits[] = {
    {"ms", "s", 1e-3},
    {"us", "s", 1e-6},
    {"min", "s", 60.0},
    {"mm", "m", 1e-3},
    {"cm", "m", 1e-2},
    {"km", "m", 1e3},
    {"km/h", "m/s", 1.0 / 3.6},
    {"g", "kg", 1e-3},
    {"deg", "rad", std::numbers::pi / 180.0},
    {"rpm", "rad/s", std::numbers::pi / 30.0},
    {"deg/s", "rad/s", std::numbers::pi / 180.0},
    {"kN", "N", 1e3},
    {"Nm", "N m", 1.0},
};

/// The longest number at the start of `text`, and the rest without blanks before it.
std::optional<double> split_unit(std::string_view text, std::string_view& rest) {
  for (std::size_t size = text.size(); size-- > 1;) {
    const std::optional<double> number = parse_number(text.substr(0, size));
    if (!number || !std::isfinite(*number)) continue;
    rest = text.substr(size);
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    return number;
  }
  return std::nullopt;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

}  // namespace

std::string unit_hint(std::string_view text, std::string_view unit) {
  constexpr std::size_t kLongest = 40;  // [bytes]; longer texts are no numbers
  std::string_view written;
  if (text.size() > kLongest) return "";
  const std::optional<double> number = split_unit(text, written);
  if (!number || written.empty() || !(is_letter(written[0]) || written[0] == '%')) return "";
  double factor = written == unit ? 1.0 : 0.0;
  for (const UnitRow& row : kUnits) {
    if (row.written == written && row.unit == unit) factor = row.factor;
  }
  if (factor == 0.0) return "; write the number without a unit";
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", *number * factor);
  return "; do you mean " + std::string(digits) + "?";
}

}  // namespace skybody
