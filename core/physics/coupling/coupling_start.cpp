#include "core/physics/coupling/coupling_start.h"

#include <cmath>
#include <cstdio>

#include "core/model/located_error.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/coupling/coupling_scene.h"
#include "core/physics/world/pose_math.h"

namespace skybody {
namespace {

/// Largest gap at a reset that is closed silently [m]: numbers in files are rounded.
constexpr double kSmallestGap = 1e-3;

Vec3<double> place_of(const Attachment& end, const LaneState& start) {
  if (end.body < 0) return end.point;
  const BodyState& body = start.bodies[static_cast<std::size_t>(end.body)];
  return body.position + rotate(body.rotation, end.point);
}

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g m", value);
  return text;
}

void fit(Coupling& coupling, double distance) {
  const std::string ends =
      "the ends of `" + coupling.name + "` are " + metres(distance) + " apart at the start";
  const bool is_there = coupling.constants[kCouplingPresent] != 0.0;
  const auto refuse = [&](const std::string& why) {
    if (is_there) throw LocatedError(coupling.mark, ends + why);
  };
  if (coupling.kind == CouplingKind::kPoint) {
    if (distance > kSmallestGap) {
      refuse(
          "; a point holds them at one place: move robots, points or joint positions until they "
          "are within " +
          metres(kSmallestGap));
    }
    return;
  }
  double& length = coupling.constants[kCouplingLength];
  const bool is_coiled = coupling.kind == CouplingKind::kRope && coupling.has_length;
  if (coupling.kind != CouplingKind::kSpring && !is_coiled && distance < kSmallestGap) {
    refuse(" and have no direction; allowed: more than " + metres(kSmallestGap) +
           "; `kind: point` holds two points at one place");
  }
  if (!coupling.has_length) length = std::fmax(distance, SKYBODY_LEAST_LENGTH);
  if (coupling.kind == CouplingKind::kRope && distance > length + kSmallestGap) {
    refuse(", the rope is " + metres(length) + " long; make it longer, or move robots or points");
  }
  if (coupling.kind == CouplingKind::kRod && std::fabs(distance - length) > kSmallestGap) {
    refuse(", the rod is " + metres(length) +
           " long; leave `length` out, or move robots or points");
  }
}

/// The reason why forces cannot move an end; empty if they can.
std::string hold_of(const World& world, const CouplingEnd& end) {
  if (end.robot < 0) return "the world";
  if (end.body != 0) return "";
  const auto r = static_cast<std::size_t>(end.robot);
  const RobotUse& robot = world.scenario.robots[r];
  const std::string base = "the base of `" + robot.name + "`";
  if (robot.model.bodies[0].joint.type == JointType::kWeld) return base + ", which is fixed";
  if (world.drives[r] != DriveKind::kNone) return base + ", which a controller drives";
  return "";
}

}  // namespace

void check_driven_ends(const World& world) {
  for (const Coupling& coupling : world.scenario.couplings) {
    const std::string first = hold_of(world, coupling.ends[0]),
                      second = hold_of(world, coupling.ends[1]);
    if (first.empty() || second.empty()) continue;
    throw LocatedError(coupling.mark, "the ends of `" + coupling.name + "` are of " + first +
                                          ", and of " + second +
                                          ", so that nothing can give way; name a body that forces "
                                          "move, or another controller");
  }
}

void fit_couplings(Scenario& scenario) {
  if (scenario.couplings.empty()) return;
  const World world(scenario);
  LaneState start;
  write_default_state(world, start);
  const CouplingScene scene(world);
  for (std::size_t i = 0; i < scene.constraints.size(); ++i) {
    const CouplingConstraint& constraint = scene.constraints[i];
    fit(scenario.couplings[i],
        norm(place_of(constraint.ends[0], start) - place_of(constraint.ends[1], start)));
  }
}

}  // namespace skybody
