// A track: gates of the scenario in passing order, as a closed loop.
#pragma once

#include <skybody/task_kit.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "plugins/obstacles/distance.h"
#include "tasks/racing/gate.h"

namespace skybody::racing {

/// The gates' names are resolved once. Their poses are read from each environment, because
/// randomizers may move them.
class Track {
 public:
  /// @param names  obstacles of kind `gate` in the order of the track; none: all, in their order
  /// @param is_closed  whether the first gate follows the last one
  /// @param bound  limit of each coordinate's magnitude [m]
  /// @throws std::runtime_error if there are no gates, if a name is not a gate, or if the gates
  ///     cannot be passed
  void configure(const Setup& setup, const std::vector<std::string>& names, bool is_closed,
                 double bound) {
    if (names.empty()) {
      for (const ShapeInfo& shape : setup.shapes()) {
        if (shape.kind == SKYBODY_GATE) add(shape);
      }
    }
    for (const std::string& name : names) add(find(setup, name));
    if (gates_.empty()) {
      refuse(
          "there is no gate to race through: add `obstacles: [{name: gate_1, gate: [1.4, 1.4, "
          "0.1], position: [2, 0, 1.5]}]`");
    }
    for (const Entry& gate : gates_) {
      task_kit::require_within(gate.nominal.centre, "gate `" + gate.name + "`", bound);
    }
    check_overlaps();
    check_order(is_closed);
  }

  /// Rejects gates that reach into the ground, or whose centre is below the height at which an
  /// episode ends. @param height_min  negative if there is no ground [m]
  void require_above(double height_min) const {
    for (const Entry& gate : gates_) {
      const Gate<double>& g = gate.nominal;
      const double lowest = g.centre.z - drop(g);
      if (lowest < min(height_min, 0.0) - kRounding) {
        refuse("gate `", gate.name, "` opens down to z = ", lowest,
               " m, below the ground: lift it by ", min(height_min, 0.0) - lowest,
               " m, or make it lower");
      }
      if (g.centre.z >= height_min) continue;
      refuse("gate `", gate.name, "` has its middle at z = ", g.centre.z, " m, below `height_min` ",
             height_min, ", where an episode ends: lift it, or lower that");
    }
  }

  /// Rejects gates whose opening leaves a racer no position farther than `radius` from the frame
  /// [m].
  void require_wide(double radius) const {
    for (const Entry& gate : gates_) {
      const Vec3<double>& half = gate.nominal.half;
      if (min(half.y, half.z) > radius) continue;
      refuse("gate `", gate.name, "` opens ", 2.0 * half.y, " m by ", 2.0 * half.z,
             " m, and nearer than `radius` ", radius,
             " m to its frame a racer collides: let it open more than ", 2.0 * radius,
             " m each way");
    }
  }

  /// Rejects lanes that lead beside an opening. @param width  distance between two lanes [m]
  void require_lanes(double width, int racers, double radius) const {
    const double aside = 0.5 * (racers - 1) * width;
    for (const Entry& gate : gates_) {
      const double room = gate.nominal.half.y - radius;
      if (racers < 2 || aside <= room) continue;
      refuse("`lane_width` ", width, " leads racers ", aside, " m aside, and gate `", gate.name,
             "` lets those of `radius` ", radius, " be ", room, " m aside: take at most ",
             2.0 * room / (racers - 1), ", or widen the gate");
    }
  }

  int size() const { return static_cast<int>(gates_.size()); }

  /// Gate `index` of an environment; indices continue after the last gate.
  template <class Real>
  SKYBODY_INLINE Gate<Real> at(const EnvView<Real>& env, const Real& index) const {
    const double n = size();
    const Real k = index - n * floor(index / n);
    Gate<Real> gate = read(env, 0);
    for (int i = 1; i < size(); ++i) {
      gate = choose(k == static_cast<double>(i), read(env, i), gate);
    }
    return gate;
  }

  /// Distance of a point from the nearest bar of all gates [m].
  template <class Real>
  SKYBODY_INLINE Real frame_distance(const EnvView<Real>& env, const Vec3<Real>& p) const {
    Real nearest(kInfinity);
    for (int i = 0; i < size(); ++i) {
      const obstacles::PlacedObstacle<Real> gate = place(env, i);
      nearest = min(nearest, obstacles::distance_to_gate(gate.size, gate.local(p)));
    }
    return nearest;
  }

 private:
  /// [m] behind a gate: position from which the next gate must be in front.
  static constexpr double kLeave = 0.5;

  /// [m] tolerance for a gate that stands on the ground.
  static constexpr double kRounding = 1e-9;

  struct Entry {
    std::string name;
    obstacles::Obstacle obstacle;
    Gate<double> nominal;
  };

  static std::string place_of(const Entry& gate) {
    const Vec3<double>& p = gate.nominal.centre;
    return "[" + to_text(p.x) + ", " + to_text(p.y) + ", " + to_text(p.z) + "] m";
  }

  /// Vertical extent of the opening below its centre [m].
  static double drop(const Gate<double>& gate) {
    const Vec3<double> up = rotate_inverse(gate.rotation, Vec3<double>{0.0, 0.0, 1.0});
    return abs(up.y) * gate.half.y + abs(up.z) * gate.half.z;
  }

  void add(const ShapeInfo& shape) {
    gates_.push_back({shape.name,
                      {shape.kind, shape.first_param},
                      {{shape.position[0], shape.position[1], shape.position[2]},
                       {shape.rotation[0], shape.rotation[1], shape.rotation[2], shape.rotation[3]},
                       {0.5 * shape.size[2], 0.5 * shape.size[0], 0.5 * shape.size[1]}}});
  }

  static const ShapeInfo& find(const Setup& setup, const std::string& name) {
    std::string known;
    for (const ShapeInfo& shape : setup.shapes()) {
      if (shape.kind != SKYBODY_GATE) continue;
      if (name == shape.name) return shape;
      known += (known.empty() ? "" : ", ") + std::string(shape.name);
    }
    refuse("`gates` names no gate `", name, "`: there are ", (known.empty() ? "none" : known));
  }

  void check_overlaps() const {
    for (std::size_t j = 1; j < gates_.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        if (gates_[i].obstacle.first_param == gates_[j].obstacle.first_param) {
          refuse("`gates` names `", gates_[i].name, "` twice: name each gate once");
        }
        if (overlap(gates_[i].nominal, gates_[j].nominal)) {
          refuse("gate `", gates_[j].name, "` at ", place_of(gates_[j]), " overlaps `",
                 gates_[i].name, "` at ", place_of(gates_[i]), ": move one of them away");
        }
      }
    }
  }

  /// The next gate must be in front of a racer that leaves a gate.
  void check_order(bool is_closed) const {
    const std::size_t pairs = gates_.size() - (is_closed && gates_.size() > 1 ? 0 : 1);
    for (std::size_t i = 0; i < pairs; ++i) {
      const Entry &gate = gates_[i], &next = gates_[(i + 1) % gates_.size()];
      const Vec3<double> left = gate.nominal.centre + gate.nominal.normal() * kLeave;
      const double behind = next.nominal.local(left).x;
      if (behind <= kRounding) continue;
      const double before = -next.nominal.local(gate.nominal.centre).x;
      if (before > 0.0 && dot(gate.nominal.normal(), next.nominal.normal()) > 0.0) {
        refuse("gate `", next.name, "` stands ", before, " m behind `", gate.name,
               "`; allowed: ", kLeave, " m or more. Move it on");
      }
      refuse("gate `", next.name, "` faces away from `", gate.name,
             "`: whoever leaves that one is ", behind,
             " m behind the plane of this one; turn it about z by 3.14159, or give `gates` in "
             "another order");
    }
  }

  template <class Real>
  SKYBODY_INLINE obstacles::PlacedObstacle<Real> place(const EnvView<Real>& env, int i) const {
    obstacles::PlacedObstacle<Real> gate =
        obstacles::place(env, gates_[static_cast<std::size_t>(i)].obstacle);
    gate.rotation = normalized(gate.rotation);
    return gate;
  }
  template <class Real>
  SKYBODY_INLINE Gate<Real> read(const EnvView<Real>& env, int i) const {
    const obstacles::PlacedObstacle<Real> gate = place(env, i);
    return {
        gate.position, gate.rotation, {0.5 * gate.size.z, 0.5 * gate.size.x, 0.5 * gate.size.y}};
  }

  std::vector<Entry> gates_;
};

}  // namespace skybody::racing
