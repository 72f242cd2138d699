#include "core/assemble/check_plausibility.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/io/yaml/fold_warnings.h"
#include "core/io/yaml/plausibility_limits.h"
#include "core/model/model_marks.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/forces/rotor_allocation.h"

namespace skybody {
namespace {

constexpr double kRoundOff = 1e-9;  // [N], of a thrust in check_hover()

/// The value farthest outside its usual range, with its rotor.
struct Worst {
  double value = 1.0;
  double distance = 0.0;
  int rotor = -1;
};

/// The distance of a positive value from its usual range, on a logarithmic scale; 0 inside.
double distance_from(PlausibilityLimit what, double value) {
  return is_plausible(what, value) ? 0.0 : 1.0 + std::fabs(std::log(value));
}

/// The checks of one robot.
class RobotCheck {
 public:
  RobotCheck(const CompiledScenario& compiled, int robot, const LaneState& start,
             Diagnostics& diagnostics)
      : world_(compiled.world()),
        robot_(robot),
        scenario_(compiled.scenario()),
        use_(scenario_.robots[static_cast<std::size_t>(robot)]),
        first_body_(compiled.layout().robots[static_cast<std::size_t>(robot)].first_body),
        start_(start),
        diagnostics_(diagnostics) {}

  void run() {
    check_thrust();
    check_hover();
    check_moment_arms();
    check_lags();
    if (check_arms()) {
      for (std::size_t b = 0; b < use_.model.bodies.size(); ++b) {
        check_gyration(static_cast<int>(b));
      }
    }
    check_sizes();
  }

 private:
  const RobotModel& model() const { return use_.model; }
  const Rotor& rotor(int index) const { return model().rotors[static_cast<std::size_t>(index)]; }

  /// Locations of a rotor's or a body's values; without files they are empty.
  RotorMarks rotor_marks(int index) const {
    const auto place = static_cast<std::size_t>(index);
    return model().marks ? model().marks->rotors.at(place) : RotorMarks{};
  }
  BodyMarks body_marks(int index) const {
    const auto place = static_cast<std::size_t>(index);
    return model().marks ? model().marks->bodies.at(place) : BodyMarks{};
  }

  SourceLocation collision_mark(int body, std::size_t shape) const {
    const BodyMarks marks = body_marks(body);
    return shape < marks.collisions.size() ? marks.collisions[shape] : SourceLocation{};
  }

  void warn(PlausibilityLimit what, double value, const std::string& name,
            std::initializer_list<GivenValue> given) {
    warn_if_implausible(what, value, name + " of the robot `" + use_.name + "`", given, use_.mark,
                        diagnostics_);
  }

  Vec3<double> in_base(int body, const Vec3<double>& direction) const {
    const auto rotation = [&](int b) {
      return start_.bodies[static_cast<std::size_t>(first_body_ + b)].rotation;
    };
    return rotate(conjugate(rotation(0)), rotate(rotation(body), direction));
  }

  void check_thrust() {
    const double weight = model().total_mass() * norm(scenario_.gravity());
    if (model().rotors.empty() || model().fixed_base || !(weight > 0.0)) return;
    Vec3<double> sum{0.0, 0.0, 0.0};
    double up = 0.0;
    const auto lifts_backwards = [&](const Rotor& rotor) {
      return rotor.is_reversible() && in_base(rotor.body, rotor.axis).z < -1e-6;
    };
    const auto lifting_speed = [&](const Rotor& rotor) {
      return lifts_backwards(rotor) ? rotor.min_speed : rotor.constants[kMaxSpeed];
    };
    for (const Rotor& rotor : model().rotors) {
      const double speed = lifting_speed(rotor);
      const Vec3<double> thrust = in_base(rotor.body, rotor.axis) *
                                  (rotor.constants[kThrustConstant] * speed * std::abs(speed));
      sum += thrust;
      up += std::max(thrust.z, 0.0);  // with rotors in all directions only some of them lift
    }
    const Rotor& first = model().rotors[0];
    const RotorMarks marks = rotor_marks(0);
    const bool is_backwards = lifts_backwards(first);
    const double lifted = sum.z < 0.0 ? up : std::max(norm(sum), up);
    warn(PlausibilityLimit::kThrustToWeight, lifted / weight, "thrust to weight",
         {{is_backwards ? "min_speed" : "max_speed", lifting_speed(first),
           is_backwards ? marks.min_speed : marks.constants[kMaxSpeed]},
          {"mass", model().total_mass(), body_marks(0).mass}});
  }

  /// Warns of a rotor that carries little or negative thrust in hover without torque, by the
  /// pseudo-inverse: a sign of a wrong position or direction of one of the rotors. Only for free
  /// bases whose rotors all lift. Rotors that cannot produce all torques are not checked.
  void check_hover() {
    if (model().fixed_base) return;
    const std::vector<Rotor>& rotors = model().rotors;
    const bool all_lift = std::all_of(rotors.begin(), rotors.end(), [](const Rotor& rotor) {
      return rotor.axis.z > 0.5 && !rotor.is_reversible();
    });
    const std::vector<double> allocation =
        all_lift ? allocation_of(world_, robot_, world_.layout.nominal_params())
                 : std::vector<double>{};
    if (allocation.empty()) return;
    std::vector<double> thrusts(rotors.size());  // [N], for 1 N along z and no torque
    for (std::size_t k = 0; k < thrusts.size(); ++k) {
      const double thrust = allocation[4 * k];
      thrusts[k] = std::fabs(thrust) < kRoundOff ? 0.0 : thrust;
    }
    const auto [least, most] = std::minmax_element(thrusts.begin(), thrusts.end());
    const int index = static_cast<int>(least - thrusts.begin());
    const double share = *least / *most;
    warn(PlausibilityLimit::kHoverShare, share,
         "hover thrust (from `position` and `direction` of all rotors), relative to the largest, "
         "of the rotor `" +
             rotor(index).name + "`",
         {{"", share, rotor_marks(index).constants[kRotorPosition]}});
  }

  /// Finds the rotor whose value is farthest outside its usual range.
  template <class Value>
  Worst worst_rotor(PlausibilityLimit what, Value&& value_of) const {
    Worst worst;
    for (std::size_t k = 0; k < model().rotors.size(); ++k) {
      const double value = value_of(model().rotors[k]);
      if (value == 0.0) continue;  // the model omits the term
      const double distance = distance_from(what, value);
      if (distance > worst.distance) worst = {value, distance, static_cast<int>(k)};
    }
    return worst;
  }

  void check_moment_arms() {
    const Worst worst = worst_rotor(PlausibilityLimit::kMomentArm, [](const Rotor& rotor) {
      return rotor.constants[kMomentConstant] / rotor.constants[kThrustConstant];
    });
    if (worst.rotor < 0) return;
    const Rotor& bad = rotor(worst.rotor);
    warn(PlausibilityLimit::kMomentArm, worst.value,
         "`moment_constant` [N m s^2/rad^2] by `thrust_constant` of the rotor `" + bad.name + "`",
         {{"moment_constant", bad.constants[kMomentConstant],
           rotor_marks(worst.rotor).constants[kMomentConstant], bad.constants[kThrustConstant]}});
  }

  void check_lags() {
    for (const RotorParam lag : {kTauUp, kTauDown}) {
      const Worst worst =
          worst_rotor(PlausibilityLimit::kLag, [&](const Rotor& r) { return r.constants[lag]; });
      if (worst.rotor < 0) continue;
      const char* key = row_at(kRotorConstants, lag).key;
      warn(PlausibilityLimit::kLag, worst.value,
           "`" + std::string(key) + "` of the rotor `" + rotor(worst.rotor).name + "`",
           {{key, worst.value, rotor_marks(worst.rotor).constants[lag]}});
    }
  }

  /// @returns whether all arms are usual; the check of gyration is relative to them
  bool check_arms() {
    double longest = 0.0;
    SourceLocation mark;
    for (std::size_t k = 0; k < model().rotors.size(); ++k) {
      const Rotor& rotor = model().rotors[k];
      const Pose place = place_at_reset(model(), rotor.body);
      const Vec3<double> hub = place.position + rotate(place.rotation, rotor.position());
      const double arm = norm(hub - model().bodies[0].mass.com);
      if (arm > longest) mark = rotor_marks(static_cast<int>(k)).constants[kRotorPosition];
      longest = std::max(longest, arm);
    }
    warn(PlausibilityLimit::kArm, longest, "the longest arm of a rotor",
         {{"position", longest, mark}});
    return is_plausible(PlausibilityLimit::kArm, longest);
  }

  /// Checks bodies with three or more rotors: fewer rotors do not indicate the body's size.
  void check_gyration(int body) {
    const MassProperties& mass = model().bodies[static_cast<std::size_t>(body)].mass;
    double arm = 0.0;
    int rotors = 0;
    SourceLocation mark;
    for (std::size_t k = 0; k < model().rotors.size(); ++k) {
      const Rotor& rotor = model().rotors[k];
      if (rotor.body != body) continue;
      const double own = norm(rotor.position() - mass.com);
      if (own > arm) mark = rotor_marks(static_cast<int>(k)).constants[kRotorPosition];
      arm = std::max(arm, own);
      ++rotors;
    }
    if (rotors < 3 || !(arm > 0.0)) return;
    const double moments[] = {mass.inertia.xx, mass.inertia.yy, mass.inertia.zz};
    const char* const names[] = {"ixx", "iyy", "izz"};
    for (int k = 0; k < 3; ++k) {
      const double ratio = std::sqrt(moments[k] / mass.mass) / arm;
      if (is_plausible(PlausibilityLimit::kGyration, ratio)) continue;
      warn(PlausibilityLimit::kGyration, ratio,
           std::string("radius of gyration (") + names[k] + ") by the longest arm",
           {{"inertia", moments[k], body_marks(body).inertia}, {"position", arm, mark}});
      return;
    }
  }

  void check_sizes() {
    double largest = 0.0;
    SourceLocation mark;
    for (std::size_t b = 0; b < model().bodies.size(); ++b) {
      const std::vector<Shape>& shapes = model().bodies[b].collisions;
      for (std::size_t k = 0; k < shapes.size(); ++k) {
        const double length = length_of(shapes[k]);
        if (length > largest) mark = collision_mark(static_cast<int>(b), k);
        largest = std::max(largest, length);
      }
    }
    warn(PlausibilityLimit::kSize, largest, "the longest collision shape", {{"", largest, mark}});
  }

  static double length_of(const Shape& shape) {
    const Shape solid = contact_shape(shape);
    const double box = std::max({solid.size.x, solid.size.y, solid.size.z});
    return solid.type == ShapeType::kBox ? box : std::max(2.0 * solid.radius, solid.length);
  }

  const World& world_;
  int robot_;
  const Scenario& scenario_;
  const RobotUse& use_;
  int first_body_;
  const LaneState& start_;
  Diagnostics& diagnostics_;
};

}  // namespace

void warn_of_implausible_parameters(const CompiledScenario& compiled, Diagnostics& diagnostics) {
  const Scenario& scenario = compiled.scenario();
  Diagnostics found;
  LaneState start;
  write_default_state(compiled.world(), start);
  for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
    RobotCheck(compiled, static_cast<int>(r), start, found).run();
  }
  diagnostics.add(fold_warnings(found));
}

}  // namespace skybody
