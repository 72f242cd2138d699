// Draws any randomizable values, selected by path: distribution, frequency and times.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "randomization/common/schedule.h"

namespace skybody {
namespace {

class Draw : public Randomizer {
 public:
  template <class Real>
  struct State {
    randomization::Schedule<Real> schedule;
    Word<Real> due;  ///< physics step before which it draws, for draws at a time; 0: never
  };

  void configure(const Setup& setup) override {
    distribution_ = read_distribution();
    dt_ = setup.dt();
    read_time(setup);
    find_values(setup);
    stream_ = correlated_.value().empty() ? 0 : derive_stream(correlated_.value().c_str());
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    if (start.in_time) {
      draw_in_time(env, state, start);
      return;
    }
    const auto is_due = logical_and(randomization::is_due(state.schedule, start.requested),
                                    MaskOf<Real>(start.requested || when_.value() != kRequest));
    if (is_timed_ && !start.requested) {
      begin_episode(env, is_due, state, start);
    } else {
      draw(env, is_due, start.requested ? 1 : 0, start);
    }
    randomization::count_reset(state.schedule, start.requested, every_.value());
  }

 private:
  static constexpr const char *kRequest = "request", *kTime = "time";

  struct Target {
    int param;
    double nominal;
    double factor;  ///< nominal value for `scale`, else 1
    double offset;  ///< nominal value for `shift`, else 0
    bool draws;     ///< false: uses the previous value's random number
  };

  /// ---- per episode

  /// Random numbers of this instance, or those shared by all draws of one `correlated` name.
  template <class Real>
  SKYBODY_INLINE Random<Real> numbers(const EnvView<Real>& env, std::uint64_t occasion) const {
    if (stream_ == 0) return random(env, occasion);
    return Random<Real>(env.seed(), env.stream_env(), env.episode(), env.physics_step(),
                        stream_ + occasion);
  }

  template <class Real>
  SKYBODY_INLINE void draw(const EnvView<Real>& env, const MaskOf<Real>& is_due,
                           std::uint64_t occasion, Start<Real>& start) const {
    if (none(is_due)) return;
    Random<Real> random = numbers(env, occasion);
    Real value(0.0);
    for (const Target& t : targets_) {
      if (t.draws) value = distribution_.at(random.uniform());
      randomization::put(start, t.param, is_due, value * t.factor + t.offset);
    }
  }

  /// Values are nominal until a time, which is drawn now.
  template <class Real>
  SKYBODY_INLINE void begin_episode(const EnvView<Real>& env, const MaskOf<Real>& is_due,
                                    State<Real>& state, Start<Real>& start) const {
    Random<Real> random = this->random(env, 2);
    const Real span = static_cast<double>(latest_ - earliest_ + 1);
    const Real step = static_cast<double>(earliest_) + floor(random.uniform() * span);
    state.due = select(is_due, to_word(step), Word<Real>(0));
    for (const Target& t : targets_) {
      randomization::put(start, t.param, is_due, Real(t.nominal));
    }
  }

  template <class Real>
  SKYBODY_INLINE void draw_in_time(const EnvView<Real>& env, State<Real>& state,
                                   Start<Real>& start) const {
    const auto is_now = logical_and(state.due == env.physics_step(), state.due != Word<Real>(0));
    if (none(is_now)) return;
    draw(env, is_now, 3, start);
    state.due = select(is_now, Word<Real>(0), state.due);
  }

  /// ---- configuration

  Distribution read_distribution() const {
    const std::string& kind = distribution_name_.value();
    check_given("range", range_.count(), kind != "choice", kind);
    check_given("values", values_.count(), kind == "choice", kind);
    check_absent("mean", kind != "normal" && mean_.is_given(), kind);
    check_absent("deviation", kind != "normal" && deviation_.is_given(), kind);
    if (kind == "choice") {
      return blaming(weights_.count() > 0 ? "weights" : "values",
                     [&] { return make_choice(values_of(values_), values_of(weights_)); });
    }
    check_absent("weights", weights_.count() > 0, kind);
    if (range_.count() != 2) {
      refuse("`range` has ", range_.count(), " values: write [low, high]");
    }
    const double low = range_.value(0), high = range_.value(1);
    const bool is_flat = !(deviation_.value() > 0.0);  // of a normal distribution: rejected first
    return blaming(kind == "normal" && is_flat && low <= high ? "deviation" : "range", [&] {
      if (kind == "uniform") return make_uniform(low, high);
      if (kind == "log_uniform") return make_log_uniform(low, high);
      return make_normal(mean_.value(), deviation_.value(), low, high);
    });
  }

  /// Result of `make`; its error names the parameter.
  template <class Make>
  static Distribution blaming(const std::string& parameter, const Make& make) {
    try {
      return make();
    } catch (const std::runtime_error& error) {
      refuse("`", parameter, "`: ", error.what());
    }
  }

  static std::vector<double> values_of(const RealsParameter& parameter) {
    std::vector<double> values;
    for (int k = 0; k < parameter.count(); ++k) values.push_back(parameter.value(k));
    return values;
  }

  static void check_given(const std::string& name, int count, bool is_wanted,
                          const std::string& kind) {
    if (!is_wanted) return check_absent(name, count > 0, kind);
    if (count == 0) {
      refuse("`distribution: ", kind, "` needs `", name, "`: give it");
    }
  }
  static void check_absent(const std::string& name, bool is_given, const std::string& kind) {
    if (!is_given) return;
    refuse("`distribution: ", kind, "` does not know `", name, "`: leave it out");
  }

  void read_time(const Setup& setup) {
    is_timed_ = when_.value() == kTime;
    if (when_.value() == kRequest && every_.is_given()) {
      refuse("`every` counts resets, which `when: request` does not draw at: leave it out");
    }
    if (is_timed_ != (time_.count() > 0)) {
      throw std::runtime_error(is_timed_ ? "`when: time` needs `time`: give [earliest, latest] in s"
                                         : "`time` is for `when: time` alone: leave it out");
    }
    if (!is_timed_) return;
    if (time_.count() != 2 || !(time_.value(0) <= time_.value(1))) {
      std::string given;
      for (const double t : values_of(time_)) given += (given.empty() ? "" : ", ") + to_text(t);
      refuse("`time` is [", given, "] s: write [earliest, latest], the earlier one first");
    }
    const double last = time_.value(1);
    const double end = setup.horizon() * setup.action_repeat() * dt_;
    if (setup.horizon() > 0 && last >= end) {
      refuse("`time` goes up to ", last, " s, but an episode ends after ", end,
             " s: let it end before");
    }
    earliest_ = std::max<std::int64_t>(1, std::llround(time_.value(0) / dt_));
    latest_ = std::max<std::int64_t>(earliest_, std::llround(last / dt_));
    setup.draws_in_time();
  }

  void find_values(const Setup& setup) {
    if (what_.values().empty()) {
      refuse(
          "`what` names nothing to draw: give at least one path, such as `controllers.rate_pd.kp`");
    }
    for (const std::string& path : what_.values()) {
      const auto found = setup.find_params(path);
      if (form_.value() == "scale") refuse_zeros(setup, found, path);
      for (const int param : found) add(setup, param, path);
    }
  }

  /// A scale has no effect on values of 0.
  static void refuse_zeros(const Setup& setup, const std::vector<int>& params,
                           const std::string& path) {
    const bool all_zero = std::all_of(params.begin(), params.end(), [&](int param) {
      return setup.params()[param].nominal == 0.0;
    });
    if (!all_zero) return;
    refuse("`form: scale` has no effect on `", path,
           "`, which is 0: take `form: shift` or `form: value`");
  }

  void add(const Setup& setup, int param, const std::string& path) {
    const EnvParamInfo& info = setup.params()[param];
    for (const Target& t : targets_) {
      if (t.param != param) continue;
      refuse("`", path, "` names ", info.path, " a second time: name each value once");
    }
    const double factor = form_.value() == "scale" ? info.nominal : 1.0;
    const double offset = form_.value() == "shift" ? info.nominal : 0.0;
    const double a = distribution_.low * factor + offset, b = distribution_.high * factor + offset;
    if (std::min(a, b) < info.min || std::max(a, b) > info.max) {
      refuse("drawing ", info.path, " from [", std::min(a, b), ", ", std::max(a, b),
             "] leaves what it may be, [", info.min, ", ", info.max, "]: narrow `",
             (values_.count() > 0 ? "values`" : "range`"));
    }
    targets_.push_back({param, info.nominal, factor, offset, targets_.empty() || !shared_.value()});
    setup.writes(param);
  }

  TextsParameter what_{this, required(words("what",
                                            "paths of the drawn values; `[*]` means all elements, "
                                            "`*` any part of a name or nothing"))};
  TextParameter distribution_name_{
      this, choice("distribution", "uniform", {"uniform", "log_uniform", "normal", "choice"},
                   "distribution of the values")};
  RealsParameter range_{
      this, list("range", "", {}, kAny, "[low, high]; truncation of a normal distribution")};
  RealParameter mean_{this, real("mean", "", 0.0, kAny, "mean of a normal distribution")};
  RealParameter deviation_{this,
                           real("deviation", "", 1.0, kAny,
                                "standard deviation of a normal distribution, before truncation")};
  RealsParameter values_{this, list("values", "", {}, kAny, "candidates of a choice")};
  RealsParameter weights_{this,
                          list("weights", "", {}, kAny,
                               "probabilities of the candidates, adding up to 1; empty: equal")};
  TextParameter form_{this, choice("form", "value", {"value", "scale", "shift"},
                                   "the drawn number is the value itself, a factor on the nominal "
                                   "value, or is added to it")};
  BooleanParameter shared_{
      this, boolean("shared", false, "one draw for all values, instead of one each")};
  TextParameter correlated_{
      this,
      word("correlated", "",
           "draws with the same name use the same random numbers, so they rise and fall together")};
  TextParameter when_{this, choice("when", "reset", {"reset", "request", "time"},
                                   "at every n-th reset; only on request; or during the episode")};
  IntegerParameter every_{this, randomization::every_spec()};
  RealsParameter time_{
      this, list("time", "s", {}, at_least(0.0),
                 "[earliest, latest] time, drawn in each episode; values are nominal until then")};

  Distribution distribution_;
  std::vector<Target> targets_;
  std::uint64_t stream_ = 0;  ///< of the name in `correlated`; 0: none
  double dt_ = 0.0;
  bool is_timed_ = false;
  std::int64_t earliest_ = 0, latest_ = 0;  ///< physics steps
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(
    skybody::Draw, "draw", "1.0.0",
    "Draws any randomizable values, selected by path, with a choice of distribution and time.");
