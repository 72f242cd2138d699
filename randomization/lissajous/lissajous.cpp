// The paper's family of Lissajous figures: what a controller `reference` of that kind flies is
// drawn together.
#include <skybody/plugin.h>

#include <stdexcept>
#include <vector>

#include "randomization/common/schedule.h"

namespace skybody {
namespace {

using randomization::Schedule;

class LissajousFamily : public Randomizer {
 public:
  template <class Real>
  struct State {
    Schedule<Real> schedule;
  };

  void configure(const Setup& setup) override {
    amplitude_ = announce(setup, "amplitude");
    centre_ = announce(setup, "centre[2]");
    cycles_ = announce(setup, "cycles");
    phase_ = announce(setup, "phase[0]");
    speed_ = announce(setup, "peak_speed");
    along_ = announce(setup, "along");
    require_order(side_, "amplitude_side");
    require_order(height_swing_, "amplitude_height");
    require_order(height_, "height");
    require_order(phases_, "phase");
    require_order(speeds_, "peak_speed");
    if (ratios_.count() % 3 != 0 || ratios_.count() == 0) {
      throw std::runtime_error("`ratios` has " + std::to_string(ratios_.count()) +
                               " values; allowed: three for each ratio, such as 2, 1, 1");
    }
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    const auto due = randomization::is_due(state.schedule, start.requested);
    Random<Real> draw = random(env);
    const auto within = [&](const RealsParameter& range) {
      return draw.uniform(Real(range.value(0)), Real(range.value(1)));
    };
    const auto put = [&](int param, const Real& value) {
      randomization::put(start, param, due, value);
    };
    put(amplitude_, within(side_));
    put(amplitude_ + 1, within(side_));
    put(amplitude_ + 2, within(height_swing_));
    put(centre_, within(height_));
    put(phase_, within(phases_));
    put(speed_, within(speeds_));
    const int count = ratios_.count() / 3;
    const Real picked = draw.uniform(Real(0.0), Real(static_cast<double>(count)));
    for (int axis = 0; axis < 3; ++axis) {
      Real cycles(ratios_.value(axis));
      for (int k = 1; k < count; ++k) {
        cycles =
            select(picked >= static_cast<double>(k), Real(ratios_.value(3 * k + axis)), cycles);
      }
      put(cycles_ + axis, cycles);
    }
    const auto looks_ahead = draw.uniform(Real(0.0), Real(1.0)) < along_share_.value();
    put(along_, select(looks_ahead, Real(1.0), Real(0.0)));
    randomization::count_reset(state.schedule, start.requested, every_.value());
  }

 private:
  /// The first of a parameter's EnvParams.
  int announce(const Setup& setup, const std::string& name) const {
    const std::vector<int> params = setup.find_params(reference_.value() + "." + name);
    for (const int param : params) setup.writes(param);
    return params[0];
  }

  static void require_order(const RealsParameter& range, const std::string& name) {
    if (range.value(0) <= range.value(1)) return;
    throw std::runtime_error("`" + name + "` is " + to_text(range.value(0)) + " to " +
                             to_text(range.value(1)) + ": swap them");
  }

  TextParameter reference_{this,
                           {.name = "reference",
                            .value = "robot.controllers.reference",
                            .doc = "path of the controller `reference`, of kind lissajous with "
                                   "`yaw: drawn`"}};
  RealsParameter side_{this,
                       {.name = "amplitude_side",
                        .unit = "m",
                        .values = {1.35, 1.75},
                        .count = 2,
                        .min = 0.0,
                        .doc = "least and greatest swing along x, and along y"}};
  RealsParameter height_swing_{this,
                               {.name = "amplitude_height",
                                .unit = "m",
                                .values = {0.3, 0.4},
                                .count = 2,
                                .min = 0.0,
                                .doc = "the same along z"}};
  RealsParameter height_{this,
                         {.name = "height",
                          .unit = "m",
                          .values = {0.7, 1.0},
                          .count = 2,
                          .doc = "of the figure's middle"}};
  RealsParameter phases_{this,
                         {.name = "phase",
                          .unit = "rad",
                          .values = {70.0 * kPi / 180.0, 110.0 * kPi / 180.0},
                          .count = 2,
                          .min = -1e3,
                          .max = 1e3,
                          .doc = "of x before y"}};
  RealsParameter speeds_{this,
                         {.name = "peak_speed",
                          .unit = "m/s",
                          .values = {1.0, 1.5},
                          .count = 2,
                          .min = 1e-3,
                          .max = 1e3,
                          .doc = "greatest speed on the figure"}};
  RealsParameter ratios_{this,
                         {.name = "ratios",
                          .values = {1, 1, 1, 2, 2, 1, 1, 1, 2, 2, 1, 1, 1, 2, 1},
                          .count = -1,
                          .min = 0.0,
                          .max = 16.0,
                          .doc = "cycles of x, y, z, three for each figure; all are as likely"}};
  RealParameter along_share_{this,
                             {.name = "along",
                              .value = 0.5,
                              .min = 0.0,
                              .max = 1.0,
                              .doc = "share of the episodes in which the vehicle looks along the "
                                     "path; else its heading is fixed"}};
  IntegerParameter every_{this, randomization::every_spec()};

  int amplitude_ = 0, centre_ = 0, cycles_ = 0, phase_ = 0, speed_ = 0, along_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::LissajousFamily, "lissajous", "1.0.0",
               "The paper's family of Lissajous references: size, form, speed and heading.");
