// Draws any randomizable values, named by path.
#include <algorithm>
#include <vector>

#include "randomization/common/schedule.h"

namespace skybody {
namespace {

class Uniform : public Randomizer {
 public:
  template <class Real>
  using State = randomization::Schedule<Real>;

  void configure(const Setup& setup) override {
    if (paths_.values().empty()) {
      throw std::runtime_error(
          "`paths` names nothing to draw: give at least one path, such as "
          "`controllers.rate_pd.kp`");
    }
    read_bounds();
    for (const std::string& path : paths_.values()) {
      for (const int param : setup.find_params(path)) add(setup, param, path);
    }
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    const auto due = randomization::is_due(state, start.requested);
    Random<Real> draw = random(env, start.requested ? 1 : 0);
    Real value = draw.uniform(Real(low_), Real(high_));
    for (const Target& t : targets_) {
      start.params.set(t.param, select(due, value * t.factor + t.offset, start.params[t.param]));
      if (!shared_.value()) value = draw.uniform(Real(low_), Real(high_));
    }
    randomization::count_reset(state, start.requested, every_.value());
  }

 private:
  struct Target {
    int param;
    double factor;  ///< the nominal value for `scale`, else 1
    double offset;  ///< the nominal value for `shift`, else 0
  };

  void read_bounds() {
    const RealsParameter* given = nullptr;
    std::string name;
    const auto look_at = [&](const RealsParameter& form, const std::string& its_name) {
      if (form.count() == 0) return;
      if (given != nullptr) {
        throw std::runtime_error("both `" + name + "` and `" + its_name +
                                 "` are given: leave one out");
      }
      given = &form;
      name = its_name;
    };
    look_at(scale_, "scale");
    look_at(range_, "range");
    look_at(shift_, "shift");
    if (given == nullptr) {
      throw std::runtime_error(
          "none of `scale`, `range` and `shift` is given: give one, [low, high]");
    }
    if (given->count() != 2) {
      throw std::runtime_error("`" + name + "` has " + std::to_string(given->count()) +
                               " values: write [low, high]");
    }
    low_ = given->value(0);
    high_ = given->value(1);
    if (low_ > high_) {
      throw std::runtime_error("`" + name + "` [" + to_text(low_) + ", " + to_text(high_) +
                               "] runs backwards: write [low, high]");
    }
  }

  void add(const Setup& setup, int param, const std::string& path) {
    for (const Target& t : targets_) {
      if (t.param == param) {
        throw std::runtime_error("`" + path + "` names " + setup.params()[param].path +
                                 " a second time: name each value once");
      }
    }
    const EnvParamInfo& info = setup.params()[param];
    const double factor = scale_.count() > 0 ? info.nominal : 1.0;
    const double offset = shift_.count() > 0 ? info.nominal : 0.0;
    const double least = std::min(low_ * factor, high_ * factor) + offset;
    const double most = std::max(low_ * factor, high_ * factor) + offset;
    if (least < info.min || most > info.max) {
      throw std::runtime_error("drawing " + std::string(info.path) + " from [" + to_text(least) +
                               ", " + to_text(most) + "] leaves what it may be, [" +
                               to_text(info.min) + ", " + to_text(info.max) +
                               "]: narrow the range");
    }
    targets_.push_back({param, factor, offset});
    setup.writes(param);
  }

  TextsParameter paths_{
      this,
      {.name = "paths",
       .doc = "what is drawn; `[*]` means all elements, `*` any part of a name or nothing",
       .required = true}};
  RealsParameter scale_{
      this,
      {.name = "scale", .count = -1, .doc = "[low, high] as multiples of each nominal value"}};
  RealsParameter range_{
      this, {.name = "range", .count = -1, .doc = "[low, high] in the value's own unit"}};
  RealsParameter shift_{
      this, {.name = "shift", .count = -1, .doc = "[low, high], added to each nominal value"}};
  BooleanParameter shared_{this,
                           {.name = "shared", .doc = "one draw for all of them, not one for each"}};
  IntegerParameter every_{this, randomization::every_spec()};

  std::vector<Target> targets_;
  double low_ = 0.0, high_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Uniform, "uniform", "1.0.0",
               "Draws any randomizable values, named by path.");
