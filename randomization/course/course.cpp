// Draws a race: positions of a ring's gates, the first gate of an episode, and start positions of
// the racers on the way to it.
#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody {
namespace {

class Course : public Randomizer {
 public:
  void configure(const Setup& setup) override {
    require_order(radius_, "radius");
    require_order(height_, "height");
    require_order(share_, "share");
    find_gates(setup);
    find_robots(setup);
    if (moves_gates_.value()) {
      for (const Gate& gate : gates_) {
        for (int k = 0; k < 3; ++k) setup.writes(gate.position + k);
        for (int k = 0; k < 4; ++k) setup.writes(gate.rotation + k);
      }
    }
    first_gate_ = setup.find_params("task.first_gate")[0];
    setup.writes(first_gate_);
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    Random<Real> draw = random(env);
    if (moves_gates_.value()) place_gates(draw, start);
    const double n = static_cast<double>(gates_.size());
    const Real any = min(floor(draw.uniform() * n), Real(n - 1.0));
    const Real first = starts_anywhere_.value() ? any : Real(0.0);
    start.params.set(first_gate_, first);
    place_robots(draw, first, start);
  }

 private:
  struct Gate {
    int position, rotation;  ///< first EnvParams
  };
  struct Robot {
    int position, turn, velocity;  ///< first EnvParams
    Vec3<double> beside;           ///< relative to the team's mean in the scenario, in its heading
                                   ///< [m]
    double yaw;                    ///< of the scenario [rad]
  };

  static void require_order(const RealsParameter& range, const std::string& name) {
    if (range.value(0) <= range.value(1)) return;
    refuse("`", name, "` is ", range.value(0), " to ", range.value(1), ": swap them");
  }

  void find_gates(const Setup& setup) {
    for (const ShapeInfo& shape : setup.shapes()) {
      if (shape.kind != SKYBODY_GATE) continue;
      gates_.push_back({shape.first_param + SKYBODY_OBSTACLE_POSITION,
                        shape.first_param + SKYBODY_OBSTACLE_ROTATION});
    }
    if (gates_.size() > 1) return;
    refuse("a course needs two gates or more, and there ", gates_.empty() ? "is none" : "is 1",
           ": add obstacles of kind `gate`");
  }

  void find_robots(const Setup& setup) {
    std::vector<int> chosen;
    for (const std::string& name : robots_of_.values()) chosen.push_back(setup.robot(name));
    if (chosen.empty()) {
      for (int r = 0; r < setup.robots().size(); ++r) {
        if (setup.robots()[r].fixed_base == 0) chosen.push_back(r);
      }
    }
    Vec3<double> middle{0.0, 0.0, 0.0};
    for (const int r : chosen) {
      const double* p = setup.robots()[r].position;
      middle += Vec3<double>{p[0], p[1], p[2]} / static_cast<double>(chosen.size());
    }
    for (const int r : chosen) {
      const RobotInfo& info = setup.robots()[r];
      const Vec3<double> p{info.position[0], info.position[1], info.position[2]};
      const double heading =
          yaw(Quat<double>{info.rotation[0], info.rotation[1], info.rotation[2], info.rotation[3]});
      const std::string path = "robots." + std::string(info.name) + ".start.";
      robots_.push_back({announce(setup, path + "position"), announce(setup, path + "turn"),
                         announce(setup, path + "velocity"), turned(p - middle, -heading),
                         heading});
    }
  }

  static int announce(const Setup& setup, const std::string& path) {
    const std::vector<int> params = setup.find_params(path);
    for (const int param : params) setup.writes(param);
    return params[0];
  }

  template <class Real>
  static SKYBODY_INLINE Vec3<Real> turned(const Vec3<Real>& v, const Real& angle) {
    const SinCos<Real> turn = sincos(angle);
    return {turn.cos * v.x - turn.sin * v.y, turn.sin * v.x + turn.cos * v.y, v.z};
  }

  /// Gate i at a random position in its own sector of a ring, roughly along the ring.
  template <class Real>
  SKYBODY_INLINE void place_gates(Random<Real>& draw, Start<Real>& start) const {
    const double sector = kTwoPi / static_cast<double>(gates_.size());
    for (std::size_t i = 0; i < gates_.size(); ++i) {
      const Real shift = draw.uniform(Real(-0.5), Real(0.5)) * sector_share_.value();
      const Real radius = draw.uniform(Real(radius_.value(0)), Real(radius_.value(1)));
      const Real height = draw.uniform(Real(height_.value(0)), Real(height_.value(1)));
      const Real turn = draw.uniform(Real(-turn_.value()), Real(turn_.value()));
      const Real angle = (static_cast<double>(i) + shift) * sector;
      const SinCos<Real> place = sincos(angle);
      const SinCos<Real> half = sincos(0.5 * (angle + turn + 0.25 * kTwoPi));
      start.params.set(gates_[i].position,
                       Vec3<Real>{radius * place.cos, radius * place.sin, height});
      start.params.set(gates_[i].rotation, Quat<Real>{half.cos, Real(0.0), Real(0.0), half.sin});
    }
  }

  /// Start on the straight line from the previous gate's centre to the first gate's, flying along
  /// it; a team keeps its formation, rotated to that line.
  template <class Real>
  SKYBODY_INLINE void place_robots(Random<Real>& draw, const Real& first,
                                   const Start<Real>& start) const {
    const double n = static_cast<double>(gates_.size());
    const Vec3<Real> to = middle(start, first);
    const Vec3<Real> from = middle(start, select(first == 0.0, Real(n - 1.0), first - 1.0));
    const Vec3<Real> way = to - from;
    const Real share = draw.uniform(Real(share_.value(0)), Real(share_.value(1)));
    const Real heading = atan2(way.y, way.x);
    const Real speed = draw.uniform(Real(0.0), Real(speed_.value()));
    const Vec3<Real> velocity = way * (speed / norm(way));
    const Real aside(spread_.value());
    for (const Robot& robot : robots_) {
      Vec3<Real> place = from + way * share + turned(to_real<Real>(robot.beside), heading);
      place.x += draw.uniform(-aside, aside);
      place.y += draw.uniform(-aside, aside);
      place.z += draw.uniform(-aside, aside);
      start.params.set(robot.position, place);
      start.params.set(robot.turn, Vec3<Real>{Real(0.0), Real(0.0), heading - robot.yaw});
      start.params.set(robot.velocity, velocity);
    }
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> middle(const Start<Real>& start, const Real& index) const {
    Vec3<Real> place = start.params.vec3(gates_[0].position);
    for (std::size_t i = 1; i < gates_.size(); ++i) {
      place = select(index == static_cast<double>(i), start.params.vec3(gates_[i].position), place);
    }
    return place;
  }

  TextsParameter robots_of_{this, words("robots", "robots to place; empty: all with a free base")};
  BooleanParameter moves_gates_{
      this, boolean("gates", false, "true: gates are drawn as well, on a ring about W's z axis")};
  BooleanParameter starts_anywhere_{
      this, boolean("anywhere", true,
                    "true: any gate may be the first; false: the scenario's first one")};
  RealsParameter radius_{this,
                         reals("radius", "m", {2.5, 3.5}, between(0.1, 1e4),
                               "smallest and largest distance of a drawn gate from the z axis")};
  RealsParameter height_{this,
                         reals("height", "m", {1.2, 2.0}, between(-1e4, 1e4),
                               "smallest and largest height of a drawn gate's centre over z = 0")};
  RealParameter sector_share_{this,
                              real("sector_share", "", 0.3, between(0.0, 1.0),
                                   "share of a gate's sector of the ring in which it may be")};
  RealParameter turn_{this, real("turn", "rad", 0.3, between(0.0, kPi),
                                 "largest angle of a drawn gate to the ring, in magnitude")};
  RealsParameter share_{this, reals("share", "", {0.3, 0.7}, between(0.0, 1.0),
                                    "share of the line between two gates at which racers start")};
  RealParameter spread_{this,
                        real("spread", "m", 0.2, between(0.0, 1e3),
                             "largest deviation of the start from that point, each coordinate")};
  RealParameter speed_{this, real("speed", "m/s", 1.0, between(0.0, 100.0),
                                  "largest initial speed, along the line between the gates")};

  std::vector<Gate> gates_;
  std::vector<Robot> robots_;
  int first_gate_ = 0;  ///< EnvParam
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Course, "course", "1.0.0",
               "Draws gates, the first gate, and the racers' start positions.");
