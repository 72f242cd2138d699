// Wind from a CSV file of air velocities over time, linear between its rows.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/robots.h"
#include "plugins/reference/timed_table.h"

namespace skybody {
namespace {

class WindTable : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    dt_ = setup.dt();
    bodies_ = effect::bodies_of(setup, effect::robots_called(setup, robots_.values()));
    table_ = reference::read_timed_table(file_.value(),
                                         {{"t", "x", "y", "z"}, kColumns, kFastest, " m/s"});
    begin_ = table_.time(0);
    length_ = table_.time(table_.rows() - 1) - begin_;
    const auto intervals = static_cast<double>(table_.rows() - 1);
    steps_per_second_ = has_equal_steps() ? intervals / length_ : 0.0;
    setup.holds(HeldInput::kWind);
    setup.period(static_cast<int>(period_.value()));
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Real elapsed = to_real(env.physics_step()) * dt_;
    const Real time = within((start_(env) + elapsed) - begin_);
    const Vec3<Real> wind = at(time);
    for (const int body : bodies_) held.add_wind(body, wind);
  }

 private:
  static constexpr int kColumns = 4;         ///< t [s], x, y, z [m/s]
  static constexpr double kFastest = 100.0;  ///< largest magnitude of each component [m/s]

  /// Whether each time is within a billionth of a step of its place on a uniform grid.
  bool has_equal_steps() const {
    const double step = length_ / static_cast<double>(table_.rows() - 1);
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const double place = begin_ + static_cast<double>(row) * step;
      if (!(abs(table_.time(row) - place) <= 1e-9 * step)) return false;
    }
    return true;
  }

  /// Maps a time since the first row into the table.
  template <class Real>
  SKYBODY_INLINE Real within(const Real& time) const {
    const Real wrapped = loop_.value() ? time - length_ * floor(time / length_) : time;
    return clamp(wrapped, 0.0, length_);
  }

  /// The velocity at a time since the first row.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> at(const Real& time) const {
    ValueOf<Real> before[kColumns] = {}, after[kColumns] = {};
    const Word<Real> rows = row_before(time);
    for (int i = 0; i < kLanesOf<Real>; ++i) {
      const double* const row = table_.values.data() + kColumns * lane(rows, i);
      for (int c = 0; c < kColumns; ++c) {
        set_lane(before[c], i, row[c]);
        set_lane(after[c], i, row[kColumns + c]);
      }
    }
    const Real share = (time - (before[0] - begin_)) / (after[0] - before[0]);
    const auto between = [&](int c) { return before[c] + share * (after[c] - before[c]); };
    return {between(1), between(2), between(3)};
  }

  /// The row whose interval contains a time. With equal steps it is computed; rounding may then
  /// select the neighbouring interval at a row, where both give the same value. Otherwise it is
  /// found by bisection in each lane.
  template <class Real>
  SKYBODY_INLINE Word<Real> row_before(const Real& time) const {
    const auto last = static_cast<double>(table_.rows() - 2);
    if (steps_per_second_ > 0.0) {
      // A NaN, such as a `start` from a loaded state, gives row 0, as in bisect().
      return to_word(min(max(floor(time * steps_per_second_), Real(0.0)), Real(last)));
    }
    const ValueOf<Real> plain = value_of(time);
    Word<Real> rows(0);
    for (int i = 0; i < kLanesOf<Real>; ++i) set_lane(rows, i, bisect(lane(plain, i)));
    return rows;
  }
  template <class R>
  static SKYBODY_INLINE R value_of(const R& x) {
    return x;
  }
  template <class R>
  static SKYBODY_INLINE R value_of(const Dual<R>& x) {
    return x.value;
  }

  std::uint64_t bisect(double time) const {
    std::size_t low = 0, high = table_.rows() - 1;
    while (high - low > 1) {
      const std::size_t middle = low + (high - low) / 2;
      (table_.time(middle) - begin_ <= time ? low : high) = middle;
    }
    return low;
  }

  TextParameter file_{this,
                      {.name = "file",
                       .doc = "CSV with the columns t [s] and x, y, z [m/s], W axes",
                       .required = true,
                       .is_file = true}};
  TextsParameter robots_{this, words("robots", "affected robots; empty: all")};
  BooleanParameter loop_{this,
                         boolean("loop", false, "repeat the table; false: the last row holds")};
  RealParameter start_{this, randomizable(real("start", "s", 0.0, between(-1e6, 1e6),
                                               "table time at the beginning of an episode"))};
  IntegerParameter period_{this, integer("period", "physics steps", 1, between(1, 1000000),
                                         "interval of new wind values")};

  double dt_ = 0.0, begin_ = 0.0, length_ = 0.0;
  double steps_per_second_ = 0.0;  ///< 0: unequal steps
  reference::TimedTable table_;
  std::vector<int> bodies_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::WindTable, "wind_table", "1.0.0", "Wind over time from a CSV file [m/s].");
