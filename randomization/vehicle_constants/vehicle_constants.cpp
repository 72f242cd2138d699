// Scales masses, inertias and rotor constants around their nominal values.
#include <algorithm>
#include <deque>
#include <vector>

#include "randomization/common/schedule.h"

namespace skybody {
namespace {

class VehicleConstants : public Randomizer {
 public:
  VehicleConstants() {
    for (const RotorRow& row : kRotorRows) {
      rotor_.emplace_back(this, scale(row.name, "scale range, each rotor separately"));
    }
  }

  template <class Real>
  using State = randomization::Schedule<Real>;

  void configure(const Setup& setup) override {
    mass_range_ = range_of(mass_, "mass");
    inertia_range_ = range_of(inertia_, "inertia");
    for (std::size_t k = 0; k < rotor_.size(); ++k) {
      rotor_range_[kRotorRows[k].constant] = range_of(rotor_[k], kRotorRows[k].name);
    }
    choose_bodies(setup);
    choose_rotors(setup);
    if (bodies_.empty() && rotors_.empty()) {
      refuse(
          "every range is [1, 1], so that nothing would be drawn: give at least one, such as "
          "`mass: [0.9, 1.1]`");
    }
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    const auto due = randomization::is_due(state, start.requested);
    Random<Real> draw = random(env, start.requested ? 1 : 0);
    for (const Target& body : bodies_) scale_body(draw, body, due, start);
    for (const Target& rotor : rotors_) {
      for (int k = 0; k < kRotorConstants; ++k) {
        if (rotor_range_[k].idle()) continue;
        const Real scale = draw.uniform(Real(rotor_range_[k].low), Real(rotor_range_[k].high));
        randomization::put(start, rotor.first + k, due,
                           scale * rotor.nominal[static_cast<std::size_t>(k)]);
      }
    }
    randomization::count_reset(state, start.requested, every_.value());
  }

 private:
  static constexpr int kRotorConstants = SKYBODY_ROTOR_TAU_DOWN + 1;  // excludes the hub's position
  static constexpr int kBodyConstants = SKYBODY_BODY_CONSTANT_COUNT;
  /// The constants of rotors that are scaled, by the names of their parameters.
  struct RotorRow {
    const char* name;
    int constant;  ///< SkybodyRotorConstant
  };
  static constexpr RotorRow kRotorRows[] = {
      {"thrust_constant", SKYBODY_ROTOR_THRUST_CONSTANT},
      {"moment_constant", SKYBODY_ROTOR_MOMENT_CONSTANT},
      {"drag", SKYBODY_ROTOR_DRAG_CONSTANT},
      {"rolling_moment", SKYBODY_ROTOR_ROLLING_MOMENT_CONSTANT},
      {"rotor_inertia", SKYBODY_ROTOR_INERTIA},
      {"tau_up", SKYBODY_ROTOR_TAU_UP},
      {"tau_down", SKYBODY_ROTOR_TAU_DOWN}};

  struct Range {
    double low = 1.0, high = 1.0;
    bool idle() const { return low == 1.0 && high == 1.0; }
  };
  struct Target {
    int first;                    ///< EnvParam
    std::vector<double> nominal;  ///< values in that order
  };

  static Range range_of(const RealsParameter& p, const std::string& name) {
    if (p.value(0) > p.value(1)) {
      refuse("`", name, "` [", p.value(0), ", ", p.value(1), "] runs backwards: write [low, high]");
    }
    return {p.value(0), p.value(1)};
  }

  static Target target(const Setup& setup, int first, int count) {
    Target t{first, {}};
    for (int k = 0; k < count; ++k) t.nominal.push_back(setup.params()[first + k].nominal);
    return t;
  }

  bool serves(const Setup& setup, int robot) const {
    return robot_.value().empty() || setup.robot(robot_.value()) == robot;
  }

  void choose_bodies(const Setup& setup) {
    if (!robot_.value().empty()) setup.robot(robot_.value());  // throws on an unknown name
    const std::vector<int> named = named_bodies(setup);
    if (mass_range_.idle() && inertia_range_.idle()) return;
    const bool writes_inertia = !inertia_range_.idle() || couple_.value();
    for (int i = 0; i < setup.bodies().size(); ++i) {
      const BodyInfo& body = setup.bodies()[i];
      const bool wanted = links_.values().empty()
                              ? serves(setup, body.robot)
                              : std::find(named.begin(), named.end(), i) != named.end();
      if (!wanted) continue;
      bodies_.push_back(target(setup, body.first_param, kBodyConstants));
      if (!mass_range_.idle()) setup.writes(body.first_param + SKYBODY_BODY_MASS);
      for (int k = SKYBODY_BODY_INERTIA; writes_inertia && k < kBodyConstants; ++k)
        setup.writes(body.first_param + k);
    }
  }

  /// Bodies of `links`, which every chosen robot must have.
  std::vector<int> named_bodies(const Setup& setup) const {
    std::vector<int> named;
    for (const std::string& link : links_.values()) {
      for (int r = 0; r < setup.robots().size(); ++r) {
        if (serves(setup, r)) named.push_back(setup.link(r, link).body);
      }
    }
    return named;
  }

  void choose_rotors(const Setup& setup) {
    bool any_range = false;
    for (const Range& r : rotor_range_) any_range = any_range || !r.idle();
    if (!any_range) return;
    for (const RotorInfo& rotor : setup.rotors()) {
      if (!serves(setup, rotor.robot)) continue;
      rotors_.push_back(target(setup, rotor.first_param, kRotorConstants));
      for (int k = 0; k < kRotorConstants; ++k) {
        if (!rotor_range_[k].idle()) setup.writes(rotor.first_param + k);
      }
    }
  }

  /// One scale for the mass, one for all six values of the inertia, which keeps it physical.
  template <class Real>
  SKYBODY_INLINE void scale_body(Random<Real>& draw, const Target& body, MaskOf<Real> due,
                                 Start<Real>& start) const {
    const Real mass = draw.uniform(Real(mass_range_.low), Real(mass_range_.high));
    const Real own = draw.uniform(Real(inertia_range_.low), Real(inertia_range_.high));
    const bool coupled = couple_.value();
    if (!mass_range_.idle())
      randomization::put(start, body.first + SKYBODY_BODY_MASS, due,
                         mass * body.nominal[SKYBODY_BODY_MASS]);
    if (!coupled && inertia_range_.idle()) return;
    const Real inertia = coupled ? mass * own : own;
    for (int k = SKYBODY_BODY_INERTIA; k < kBodyConstants; ++k) {
      randomization::put(start, body.first + k, due,
                         inertia * body.nominal[static_cast<std::size_t>(k)]);
    }
  }

  static RealsSpec scale(const char* name, const char* doc) {
    return reals(name, "", {1.0, 1.0}, between(0.01, 100.0), doc);
  }

  TextParameter robot_{this, word("robot", "", "name of the robot; empty: every robot")};
  TextsParameter links_{this, words("links", "links of the scaled bodies; none: all of the robot")};
  IntegerParameter every_{this, randomization::every_spec()};
  RealsParameter mass_{this, scale("mass", "range of the scale of each body's mass")};
  RealsParameter inertia_{this, scale("inertia", "range of the scale of each body's inertia")};
  BooleanParameter couple_{
      this, boolean("couple_inertia", true, "also scale a body's inertia with its mass")};
  std::deque<RealsParameter> rotor_;  ///< in the order of kRotorRows

  Range mass_range_, inertia_range_;
  Range rotor_range_[kRotorConstants] = {};
  std::vector<Target> bodies_, rotors_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::VehicleConstants, "vehicle_constants", "1.0.0",
               "Scales masses, inertias and rotor constants around the nominal.");
