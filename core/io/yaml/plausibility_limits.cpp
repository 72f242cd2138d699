#include "core/io/yaml/plausibility_limits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include "core/base/math/math.h"

namespace skybody {
namespace {

/// A mistake. The intended value is the written one times `factor`; the checked value is
/// proportional to the `power` of the written one.
struct Slip {
  const char* key;  ///< of GivenValue; empty: the value itself
  double factor;
  double power;
  const char* how;
};

struct UsualRow {
  const char* unit;
  double low, high;
  double typical;  ///< in size; of several mistakes, the one whose result is nearest explains best
  std::vector<Slip> slips;
};

constexpr double kDegree = kPi / 180.0;
constexpr double kTurnAMinute = kPi / 30.0;

// In the order of PlausibilityLimit. Vehicles range from a Crazyflie to passenger aircraft, with a
// margin on either side (randomization/vehicle/README.md has figures). Angles: trajectories count
// full turns.
const std::vector<UsualRow>& rows() {
  static const std::vector<UsualRow> all = {
      {"rad", -12.6, 12.6, 1, {{"", kDegree, 1, "degrees written for radians"}}},
      {"m", -11e3, 9e3, 10, {{"", 1e-3, 1, "mm written for m"}, {"", 1e-2, 1, "cm written for m"}}},
      {"m/s^2", -30, 0, 10, {{"", -1, 1, "z of the world points up"}}},
      {"",
       1.1,
       20,
       5,
       {{"max_speed", kTurnAMinute, 2, "rpm written for rad/s"},
        {"mass", 1e-3, -1, "g written for kg"},
        {"max_speed", 1 / kTurnAMinute, 2, "the constants are for rpm, too"}}},
      {"", 0.05, 1, 1, {}},
      {"m",
       1e-3,
       1,
       0.03,
       {{"moment_constant", 1, 1, "RotorS and PX4 write drag torque by thrust, a length"}}},
      {"s", 0, 0.5, 0.03, {{"", 1e-3, 1, "ms written for s"}}},
      {"",
       0.1,
       3,
       0.55,
       {{"inertia", 1e-7, 0.5, "g cm^2 written for kg m^2"},
        {"inertia", 1e-6, 0.5, "kg mm^2 written for kg m^2"},
        {"inertia", 1e-4, 0.5, "kg cm^2 written for kg m^2"},
        {"position", 1e-3, -1, "mm written for m"},
        {"position", 1e-2, -1, "cm written for m"}}},
      {"m", 0, 20, 0.5, {{"", 1e-3, 1, "mm written for m"}, {"", 1e-2, 1, "cm written for m"}}},
      {"m",
       0,
       15,
       0.2,
       {{"position", 1e-3, 1, "mm written for m"}, {"position", 1e-2, 1, "cm written for m"}}},
      {"m/kg^(1/3)",
       0.05,
       0.6,
       0.16,
       {{"--mass", 1e-3, -1.0 / 3.0, "g written for kg"},
        {"--arm", 1e-3, 1, "mm written for m"},
        {"--arm", 1e-2, 1, "cm written for m"}}},
  };
  return all;
}

const UsualRow& row_of(PlausibilityLimit what) { return rows()[static_cast<std::size_t>(what)]; }

bool is_in(const UsualRow& row, double value) { return value >= row.low && value <= row.high; }

/// Formats with four digits: derived values have more digits than readers need.
std::string four_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string with_unit_of(const UsualRow& row, double value) {
  return four_digits(value) + (row.unit[0] == '\0' ? "" : " ") + row.unit;
}

/// A mistake that explains a value, and the intended value.
struct Meant {
  const Slip* slip = nullptr;
  double value = 0.0;
  SourceLocation mark = {};

  /// "; do you mean `max_speed: 2094` (rpm written for rad/s)?", or an empty text.
  std::string text() const {
    if (slip == nullptr) return "";
    const std::string key = slip->key, number = four_digits(value);
    const std::string between = key.rfind("--", 0) == 0 ? " " : ": ";
    return "; do you mean " + (key.empty() ? number : "`" + key + between + number + "`") + " (" +
           slip->how + ")?";
  }
};

/// Searches a row's mistakes with the key of `given`. If several explain the value, the one whose
/// result is nearest to the typical size is chosen.
Meant meant(const UsualRow& row, double value, const GivenValue& given) {
  double least = kInfinity;
  Meant found;
  for (const Slip& slip : row.slips) {
    if (std::string_view(slip.key) != given.key) continue;
    const double factor = slip.factor * given.factor;
    const double looked_at = value * std::pow(factor, slip.power);
    if (!is_in(row, looked_at)) continue;
    const double distance = std::fabs(std::log(std::fabs(looked_at) / row.typical));
    if (distance < least) found = {&slip, given.value * factor, given.mark};
    least = std::min(least, distance);
  }
  return found;
}

/// The mistake of the value itself, else of the first given value that has one.
Meant explanation(const UsualRow& row, double value, std::initializer_list<GivenValue> given) {
  Meant found = meant(row, value, {"", value});
  SourceLocation first;
  for (const GivenValue& g : given) {
    if (found.slip == nullptr) found = meant(row, value, g);
    if (first.file.empty()) first = g.mark;
  }
  if (found.mark.file.empty()) found.mark = first;
  return found;
}

}  // namespace

bool is_plausible(PlausibilityLimit what, double value) { return is_in(row_of(what), value); }

void warn_if_implausible(PlausibilityLimit what, double value, const std::string& name,
                         std::initializer_list<GivenValue> given, const SourceLocation& mark,
                         Diagnostics& diagnostics) {
  const UsualRow& row = row_of(what);
  if (is_in(row, value)) return;
  const Meant found = explanation(row, value, given);
  diagnostics.warning(found.mark.file.empty() ? mark : found.mark,
                      name + " is " + with_unit_of(row, value) + "; usual is " +
                          four_digits(row.low) + " to " + with_unit_of(row, row.high) +
                          found.text());
}

}  // namespace skybody
