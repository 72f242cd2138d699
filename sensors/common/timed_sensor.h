// Times of samples and of their delivery, and lost samples: the base of every sensor.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <numeric>
#include <string>

namespace skybody::sensor {

/// Default of `period`: a number of physics steps, or a rate.
struct DefaultPeriod {
  int steps = 1;      ///< physics steps; 0: by the rate
  double rate = 0.0;  ///< [Hz]; rounded to physics steps
  const char* doc = "interval of samples";
};

/// A sensor that samples at a period and delivers each sample after a latency.
///
/// sense() asks due() for the lanes that take a sample, writes the sample of these to room(), and
/// calls deliver(), which writes the whole output. Samples are taken at physics steps phase + k
/// period, and one at the reset, which the output shows until the first one is delivered.
class TimedSensor : public Sensor {
 protected:
  /// Arguments of configure_timing().
  struct Use {
    int size = 0;                ///< values of a sample
    int own_words = 0;           ///< buffer words of the sensor itself, from 0 on
    bool has_stamp = false;      ///< the output ends with the time of the sample [s]
    bool may_leave_out = false;  ///< a sample does not depend on the calls before it
  };

  explicit TimedSensor(const DefaultPeriod& standard = {})
      : rate_(standard.rate),
        period_parameter_(this,
                          integer("period", "physics steps", standard.steps,
                                  between(standard.rate > 0.0 ? 0 : 1, 1000000), standard.doc)) {}

  /// Declares calls and buffer. Call once in configure(), before anything that uses period().
  /// @throws std::runtime_error if a phase reaches the period
  void configure_timing(const Setup& setup, const Use& use) {
    use_ = use;
    dt_ = setup.dt();
    period_ = period_parameter_.value();
    if (period_ == 0) period_ = std::max<std::int64_t>(1, nearest(1.0 / (rate_ * dt_)));
    check_phase();
    const std::int64_t latest = latency_.value() + latency_spread_.value();
    places_ = latest == 0 ? 0 : static_cast<int>(latest / period_) + 1;
    const bool is_drawn = latency_spread_.value() + phase_spread_.value() > 0;
    const std::int64_t call =
        is_drawn ? 1 : std::gcd(std::gcd(period_, phase_.value()), latency_.value());
    is_always_due_ = call == period_;
    has_dropout_ = dropout_.is_given();
    is_direct_ = is_always_due_ && places_ == 0 && !has_dropout_;
    const int spreads = is_drawn ? 2 : 0, slot = use.size + 1;
    drawn_ = is_drawn ? use.own_words : -1;
    held_ = use.own_words + spreads;
    ring_ = held_ + (is_direct_ ? 0 : slot);
    const int words = ring_ + places_ * slot;
    setup.period(static_cast<int>(call));
    if (words > 0) setup.buffer(words);
    if (!is_direct_) setup.scratch(use.size);
    if (is_direct_ && use.may_leave_out) setup.only_when_read();
  }

  std::int64_t period() const { return period_; }                         ///< physics steps
  double interval() const { return static_cast<double>(period_) * dt_; }  ///< of samples [s]

  /// Lanes that take a sample in this call; at a reset all. Draws the episode's delays.
  template <class Real>
  SKYBODY_INLINE MaskOf<Real> due(const EnvView<Real>& env, const Values<Real>& buffer) const {
    const auto fresh = is_first(env);
    if (drawn_ >= 0 && any(fresh)) draw_delays(env, fresh, buffer);
    if (is_always_due_) return env.served();
    const Real since = to_real(env.physics_step()) - phase(buffer);
    const double period = static_cast<double>(period_);
    const auto is_sample = logical_and(since >= 0.0, since - floor(since / period) * period == 0.0);
    return logical_and(env.served(), logical_or(is_sample, fresh));
  }

  /// Physics steps from the reset to the first regular sample, in each environment.
  template <class Real>
  SKYBODY_INLINE Real phase(const Values<Real>& buffer) const {
    const Real fixed(static_cast<double>(phase_.value()));
    return drawn_ >= 0 && phase_spread_.value() > 0 ? fixed + buffer[drawn_] : fixed;
  }

  /// Where sense() writes the values of a sample.
  template <class Real>
  SKYBODY_INLINE Values<Real> room(const EnvView<Real>& env, const Values<Real>& output) const {
    return is_direct_ ? output : env.scratch();
  }

  /// Writes the output: the latest delivered sample.
  /// @param due     from due()
  /// @param sample  room(), with the sample taken now where due
  template <class Real>
  SKYBODY_INLINE void deliver(const EnvView<Real>& env, const MaskOf<Real>& due,
                              const Values<Real>& sample, const Values<Real>& output,
                              const Values<Real>& buffer) const {
    const Real now = to_real(env.physics_step());
    if (is_direct_) {
      if (use_.has_stamp) output.set(use_.size, now * dt_);
      return;
    }
    auto shown = is_first(env);
    const auto is_lost = lost(env, due);
    if (places_ > 0) {
      push(now, due, is_lost, sample, buffer);
      arrive(now, buffer);
    } else {
      shown = logical_or(shown, logical_and(due, logical_not(is_lost)));
    }
    if (any(shown)) store(held_, shown, now, sample, buffer);
    for (int i = 0; i < use_.size; ++i) output.set(i, buffer[held_ + i]);
    if (use_.has_stamp) output.set(use_.size, buffer[held_ + use_.size] * dt_);
  }

 private:
  static constexpr std::uint64_t kDropoutDraws = 0x7d01, kDelayDraws = 0x7d02;

  static std::int64_t nearest(double x) { return static_cast<std::int64_t>(x + 0.5); }
  template <class Real>
  static SKYBODY_INLINE MaskOf<Real> is_first(const EnvView<Real>& env) {
    return env.physics_step() == Word<Real>(0);
  }

  void check_phase() const {
    const std::int64_t latest = phase_.value() + phase_spread_.value();
    if (latest < period_) return;
    const std::string name = phase_.value() >= period_ ? "phase" : "phase_spread";
    refuse("`", name, "` lets the first sample be ", latest,
           " physics steps late, and `period` is ", period_, ": allowed is less than a period");
  }

  template <class Real>
  SKYBODY_INLINE void draw_delays(const EnvView<Real>& env, const MaskOf<Real>& fresh,
                                  const Values<Real>& buffer) const {
    Random<Real> draw = random(env, kDelayDraws);
    const IntegerParameter* const spreads[] = {&phase_spread_, &latency_spread_};
    for (int k = 0; k < 2; ++k) {
      const auto choices = static_cast<std::uint64_t>(spreads[k]->value()) + 1;
      const Real late = to_real(draw.integer(choices));
      buffer.set(drawn_ + k, select(fresh, late, buffer[drawn_ + k]));
    }
  }

  template <class Real>
  SKYBODY_INLINE MaskOf<Real> lost(const EnvView<Real>& env, const MaskOf<Real>& due) const {
    if (!has_dropout_ || none(due)) return MaskOf<Real>(false);
    return logical_and(due, random(env, kDropoutDraws).uniform() < dropout_(env));
  }

  /// Slot of the ring for the sample that is `since` physics steps after the first one.
  template <class Real>
  SKYBODY_INLINE Real slot_of(const Real& since) const {
    const Real number = floor(since / static_cast<double>(period_));
    const double places = places_;
    return number - floor(number / places) * places;
  }

  /// Moves samples from the ring to the held one when their latency has passed. The ring has a
  /// place for each sample under way.
  template <class Real>
  SKYBODY_INLINE void arrive(const Real& now, const Values<Real>& buffer) const {
    Real latency(static_cast<double>(latency_.value()));
    if (drawn_ >= 0) latency += buffer[drawn_ + 1];
    const Real taken = now - latency, since = taken - phase(buffer);
    const auto is_taken = since >= 0.0;
    const Real slot = slot_of(since);
    for (int s = 0; s < places_; ++s) {
      const int from = ring_ + s * (use_.size + 1);
      const auto arrives = logical_and(logical_and(is_taken, slot == static_cast<double>(s)),
                                       buffer[from + use_.size] == taken);
      if (none(arrives)) continue;
      for (int i = 0; i <= use_.size; ++i) {
        buffer.set(held_ + i, select(arrives, buffer[from + i], buffer[held_ + i]));
      }
    }
  }

  /// Puts a sample into the ring; a lost one has no time and never arrives.
  template <class Real>
  SKYBODY_INLINE void push(const Real& now, const MaskOf<Real>& due, const MaskOf<Real>& is_lost,
                           const Values<Real>& sample, const Values<Real>& buffer) const {
    if (none(due)) return;
    const Real since = now - phase(buffer);
    const Real slot = slot_of(since), time = select(is_lost, Real(-1.0), now);
    const auto is_regular = logical_and(due, since >= 0.0);
    for (int s = 0; s < places_; ++s) {
      const auto here = logical_and(is_regular, slot == static_cast<double>(s));
      if (any(here)) store(ring_ + s * (use_.size + 1), here, time, sample, buffer);
    }
  }

  template <class Real>
  SKYBODY_INLINE void store(int first, const MaskOf<Real>& where, const Real& time,
                            const Values<Real>& sample, const Values<Real>& buffer) const {
    for (int i = 0; i < use_.size; ++i) {
      buffer.set(first + i, select(where, sample[i], buffer[first + i]));
    }
    const int last = first + use_.size;
    buffer.set(last, select(where, time, buffer[last]));
  }

  double rate_;
  IntegerParameter period_parameter_;
  IntegerParameter phase_{this, integer("phase", "physics steps", 0, between(0, 1000000),
                                        "first sample after a reset; less than `period`")};
  IntegerParameter latency_{this, integer("latency", "physics steps", 0, between(0, 1000),
                                          "delay from a sample to the output")};
  IntegerParameter phase_spread_{this,
                                 integer("phase_spread", "physics steps", 0, between(0, 1000000),
                                         "each episode adds 0 to this many to `phase`")};
  IntegerParameter latency_spread_{this,
                                   integer("latency_spread", "physics steps", 0, between(0, 1000),
                                           "each episode adds 0 to this many to `latency`")};
  RealParameter dropout_{
      this, when_given(real("dropout", "", 0.0, between(0.0, 1.0),
                            "probability that a sample is lost; the output then keeps the "
                            "one before"))};

  Use use_{};
  double dt_ = 0.0;
  std::int64_t period_ = 1;  ///< physics steps
  int places_ = 0;           ///< of the ring: samples under way
  int drawn_ = -1;           ///< buffer word of this episode's delays; -1: none are drawn
  int held_ = 0;             ///< buffer words of the delivered sample, its physics step last
  int ring_ = 0;             ///< buffer words of the samples under way
  bool is_always_due_ = true;
  bool is_direct_ = true;
  bool has_dropout_ = false;
};

}  // namespace skybody::sensor
