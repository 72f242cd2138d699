#include "core/env/start_overlaps.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/env/status_field.h"
#include "core/physics/contact/contact_scene.h"

namespace skybody {
namespace {

/// Bits above kBadStart: the body, the thing that it begins in, and the depth in units of 10 um.
constexpr StatusField kBodyField{kBadStartPlace, 10}, kOtherField{kBadStartPlace + 10, 15},
    kDepthField{kBadStartPlace + 25, 21};
constexpr double kDepthUnit = 1e-5;

/// Contact::other as a number: 0 the ground, then the obstacles, then the bodies.
int number_of(int other, int obstacles) {
  if (other == kGround) return 0;
  return is_obstacle(other) ? 1 + obstacle_of(other) : 1 + obstacles + other;
}
int other_of(int number, int obstacles) {
  if (number == 0) return kGround;
  return number <= obstacles ? kFirstObstacle - (number - 1) : number - 1 - obstacles;
}

bool is_of(const Contact& contact, int body, int other) {
  return (contact.body == body && contact.other == other) ||
         (contact.body == other && contact.other == body);
}

std::string in_metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g m", value);
  return text;
}

}  // namespace

bool StartOverlap::operator==(const StartOverlap& o) const {
  return body == o.body && other == o.other && depth == o.depth && point.x == o.point.x &&
         point.y == o.point.y && point.z == o.point.z;
}

StartOverlaps::StartOverlaps(const World& world, std::vector<Contact> nominal)
    : world_(world),
      nominal_(std::move(nominal)),
      give_of_bodies_(world.bodies.size(), kInfinity),
      give_of_obstacles_(world.scenario.obstacles.size(), kInfinity) {
  const ContactScene scene(world);
  for (const ContactBody& body : scene.bodies) {
    give_of_bodies_[static_cast<std::size_t>(body.body)] = body.give;
  }
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const ContactShape& solid = scene.obstacles[i];
    if (solid.rounding == kNoShape || is_unbounded_below(solid.type)) continue;
    double& give = give_of_obstacles_[static_cast<std::size_t>(scene.obstacle_owners[i])];
    give = min(give, penetration_limit(solid.half, solid.rounding));
  }
}

/// Whether a body is not moved by forces.
bool StartOverlaps::stands(int body) const {
  const WorldBody& b = world_.bodies[static_cast<std::size_t>(body)];
  return b.parent < 0 && world_.drives[static_cast<std::size_t>(b.robot)] != DriveKind::kNone;
}

double StartOverlaps::nominal_depth(int body, int other) const {
  double depth = 0.0;
  for (const Contact& c : nominal_) {
    if (is_of(c, body, other)) depth = max(depth, c.depth);
  }
  return depth;
}

/// The allowed depth. kDeepStart times the rest depth would let robots pass through thin things, so
/// it is bounded by the depth that contact allows, but it is at least twice the rest depth.
double StartOverlaps::allowed_depth(int body, int other) const {
  double give = give_of_bodies_[static_cast<std::size_t>(body)];
  if (other == kGround) give = kInfinity;
  if (is_obstacle(other)) {
    give = min(give, give_of_obstacles_[static_cast<std::size_t>(obstacle_of(other))]);
  } else if (other >= 0) {
    give = min(give, give_of_bodies_[static_cast<std::size_t>(other)]);
  }
  const double rest = world_.scenario.contact.penetration;
  return min(kDeepStart * rest, max(give, 2.0 * rest)) + nominal_depth(body, other);
}

std::optional<StartOverlap> StartOverlaps::find(const std::vector<Contact>& contacts) const {
  std::optional<StartOverlap> worst;
  double most = 0.0;
  for (const Contact& c : contacts) {
    const double beyond = c.depth - allowed_depth(c.body, c.other);
    if (!(beyond > most)) continue;
    if (stands(c.body) && (c.other < 0 || stands(c.other))) continue;
    most = beyond;
    worst = StartOverlap{c.body, c.other, c.depth, c.point};
  }
  return worst;
}

std::uint64_t StartOverlaps::status(const StartOverlap& overlap) const {
  const int obstacles = static_cast<int>(world_.scenario.obstacles.size());
  return kBadStart | kBodyField.put(overlap.body) |
         kOtherField.put(number_of(overlap.other, obstacles)) |
         kDepthField.put(round_half_even(overlap.depth / kDepthUnit));
}

std::string StartOverlaps::name_of(int other) const {
  const Scenario& scenario = world_.scenario;
  if (other == kGround) return "the ground";
  if (is_obstacle(other)) {
    return "the obstacle `" +
           scenario.obstacles[static_cast<std::size_t>(obstacle_of(other))].name + "`";
  }
  const int robot = world_.bodies[static_cast<std::size_t>(other)].robot;
  return "robot `" + scenario.robots[static_cast<std::size_t>(robot)].name + "`";
}

std::string StartOverlaps::reason(std::uint64_t status) const {
  const int obstacles = static_cast<int>(world_.scenario.obstacles.size());
  return name_of(static_cast<int>(kBodyField.get(status))) + " begins inside " +
         name_of(other_of(static_cast<int>(kOtherField.get(status)), obstacles)) + ", by " +
         in_metres(static_cast<double>(kDepthField.get(status)) * kDepthUnit) +
         ", however often its start is drawn; narrow what randomizers draw, move the robot's "
         "`pose`, or raise `contact.redraws` (" +
         std::to_string(world_.scenario.contact.redraws) + ")";
}

}  // namespace skybody
