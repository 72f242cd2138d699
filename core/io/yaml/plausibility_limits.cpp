#include "core/io/yaml/plausibility_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

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
  std::array<Slip, 3> slips;  ///< how: null where unused
};

constexpr double kDegree = kPi / 180.0;
constexpr double kTurnAMinute = kPi / 30.0;
constexpr Slip kNoSlip{"", 1.0, 1.0, nullptr};

// In the order of PlausibilityLimit. Vehicles range from a Crazyflie to passenger aircraft, with a
// margin on either side (randomization/vehicle/README.md has figures). Angles: trajectories count
// full turns.
constexpr UsualRow kRows[] = {
    {"rad", -12.6, 12.6, {{{"", kDegree, 1, "degrees written for radians"}, kNoSlip, kNoSlip}}},
    {"m", -11e3, 9e3, {{{"", 1e-3, 1, "mm written for m"}, kNoSlip, kNoSlip}}},
    {"m/s^2", -30, 0, {{{"", -1, 1, "z of the world points up"}, kNoSlip, kNoSlip}}},
    {"",
     1.1,
     20,
     {{{"max_speed", kTurnAMinute, 2, "rpm written for rad/s"},
       {"mass", 1e-3, -1, "g written for kg"},
       {"max_speed", 1 / kTurnAMinute, 2, "the constants are for rpm, too"}}}},
    {"m",
     1e-3,
     1,
     {{{"moment_constant", 1, 1, "RotorS and PX4 write drag torque by thrust, a length"},
       kNoSlip,
       kNoSlip}}},
    {"s", 0, 0.5, {{{"", 1e-3, 1, "ms written for s"}, kNoSlip, kNoSlip}}},
    {"",
     0.1,
     3,
     {{{"inertia", 1e-7, 0.5, "g cm^2 written for kg m^2"},
       {"inertia", 1e-6, 0.5, "kg mm^2 written for kg m^2"},
       {"inertia", 1e-4, 0.5, "kg cm^2 written for kg m^2"}}}},
    {"m", 0, 20, {{{"", 1e-3, 1, "mm written for m"}, kNoSlip, kNoSlip}}},
    {"m", 0, 15, {{{"position", 1e-3, 1, "mm written for m"}, kNoSlip, kNoSlip}}},
};

const UsualRow& row_of(PlausibilityLimit what) { return kRows[static_cast<std::size_t>(what)]; }

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
};

/// Searches a row's mistakes with the key of `given`. If several explain the value, the one whose
/// result is nearest to the middle of the range is chosen.
Meant meant(const UsualRow& row, double value, const GivenValue& given) {
  const double middle = sqrt(row.low * row.high);
  double least = kInfinity;
  Meant found;
  for (const Slip& slip : row.slips) {
    if (slip.how == nullptr || std::string_view(slip.key) != given.key) continue;
    const double factor = slip.factor * given.factor;
    const double looked_at = value * std::pow(factor, slip.power);
    if (!is_in(row, looked_at)) continue;
    const double distance = middle > 0.0 ? std::fabs(std::log(looked_at / middle)) : 0.0;
    if (distance < least) found = {&slip, given.value * factor};
    least = std::min(least, distance);
  }
  return found;
}

/// "; do you mean `max_speed: 2094` (rpm written for rad/s)?", or an empty text.
std::string explanation(const UsualRow& row, double value,
                        std::initializer_list<GivenValue> given) {
  const GivenValue itself{"", value};
  Meant found = meant(row, value, itself);
  for (const GivenValue& g : given) {
    if (found.slip == nullptr) found = meant(row, value, g);
  }
  if (found.slip == nullptr) return "";
  const std::string key = found.slip->key, number = four_digits(found.value);
  return "; do you mean " + (key.empty() ? number : "`" + key + ": " + number + "`") + " (" +
         found.slip->how + ")?";
}

}  // namespace

bool is_plausible(PlausibilityLimit what, double value) { return is_in(row_of(what), value); }

void warn_if_implausible(PlausibilityLimit what, double value, const std::string& name,
                         std::initializer_list<GivenValue> given, const SourceLocation& mark,
                         Diagnostics& diagnostics) {
  const UsualRow& row = row_of(what);
  if (is_in(row, value)) return;
  diagnostics.warning(mark, name + " is " + with_unit_of(row, value) + "; usual is " +
                                four_digits(row.low) + " to " + with_unit_of(row, row.high) +
                                explanation(row, value, given));
}

}  // namespace skybody
