// Draws any randomizable values, named by path.
#include <skybody/plugin.h>

#include <algorithm>
#include <vector>

namespace skybody {
namespace {

class Uniform : public Randomizer {
 public:
  template <class Real>
  struct State {
    Word<Real> waited;  ///< resets since the last draw, 0: draw at the next one
  };

  void configure(const Setup& setup) override {
    if (paths_.values().empty()) {
      throw std::runtime_error(
          "`paths` names nothing to draw: give at least one path, such as "
          "`controllers.rate_pd.kp`");
    }
    const bool scales = scale_.count() > 0;
    if (scales == (range_.count() > 0)) {
      throw std::runtime_error(scales
                                   ? "both `scale` and `range` are given: leave one out"
                                   : "neither `scale` nor `range` is given: give one, [low, high]");
    }
    const RealsParameter& given = scales ? scale_ : range_;
    const std::string name = scales ? "scale" : "range";
    if (given.count() != 2) {
      throw std::runtime_error("`" + name + "` has " + std::to_string(given.count()) +
                               " values: write [low, high]");
    }
    low_ = given.value(0);
    high_ = given.value(1);
    if (low_ > high_) {
      throw std::runtime_error("`" + name + "` [" + std::to_string(low_) + ", " +
                               std::to_string(high_) + "] runs backwards: write [low, high]");
    }
    for (const std::string& path : paths_.values()) {
      for (const int param : setup.find_params(path)) add(setup, param, path, scales);
    }
  }

  template <class Real>
  void randomize(const Lanes<Real>& env, State<Real>& state, Start<Real>& start) const {
    const auto due = logical_or(MaskOf<Real>(start.requested), state.waited == Word<Real>(0));
    Random<Real> draw = random(env, start.requested ? 1 : 0);
    Real value = draw.uniform(Real(low_), Real(high_));
    for (const Target& t : targets_) {
      start.params.set(t.param, select(due, value * t.factor, start.params[t.param]));
      if (!shared_.value()) value = draw.uniform(Real(low_), Real(high_));
    }
    if (!start.requested) {
      const Word<Real> next = state.waited + Word<Real>(1);
      const Word<Real> every(static_cast<std::uint64_t>(every_.value()));
      state.waited = select(next == every, Word<Real>(0), next);
    }
  }

 private:
  struct Target {
    int param;
    double factor;  ///< the nominal value, or 1 for a range
  };

  void add(const Setup& setup, int param, const std::string& path, bool scales) {
    for (const Target& t : targets_) {
      if (t.param == param) {
        throw std::runtime_error("`" + path + "` names " + setup.params()[param].path +
                                 " a second time: name each value once");
      }
    }
    const EnvParamInfo& info = setup.params()[param];
    const double factor = scales ? info.nominal : 1.0;
    const double least = std::min(low_ * factor, high_ * factor);
    const double most = std::max(low_ * factor, high_ * factor);
    if (least < info.min || most > info.max) {
      throw std::runtime_error("drawing " + std::string(info.path) + " from [" +
                               std::to_string(least) + ", " + std::to_string(most) +
                               "] leaves what it may be, [" + std::to_string(info.min) + ", " +
                               std::to_string(info.max) + "]: narrow the range");
    }
    targets_.push_back({param, factor});
    setup.writes(param);
  }

  TextsParameter paths_{
      this, {.name = "paths", .doc = "what is drawn; `[*]` means all elements", .required = true}};
  RealsParameter scale_{
      this,
      {.name = "scale", .count = -1, .doc = "[low, high] as multiples of each nominal value"}};
  RealsParameter range_{
      this, {.name = "range", .count = -1, .doc = "[low, high] in the value's own unit"}};
  BooleanParameter shared_{this,
                           {.name = "shared", .doc = "one draw for all of them, not one for each"}};
  IntegerParameter every_{this,
                          {.name = "every",
                           .value = 1,
                           .min = 1,
                           .doc = "draw at every n-th reset, the first included"}};

  std::vector<Target> targets_;
  double low_ = 0.0, high_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Uniform, "uniform", "1.0.0",
               "Draws any randomizable values, named by path.");
