#include "core/physics/coupling/coupling_scene.h"

namespace skybody {
namespace {

Attachment joined_end(const World& world, const CouplingEnd& end) {
  if (end.robot < 0) return {-1, -1, end.point};
  const int first = world.layout.robots[static_cast<std::size_t>(end.robot)].first_body;
  return {first + end.body, end.robot, end.point};
}

int rows_of(CouplingKind kind) {
  if (kind == CouplingKind::kSpring) return 0;
  return kind == CouplingKind::kPoint ? 3 : 1;
}

/// Gives all robots that a constraint connects the same first robot.
void hold_together(const CouplingConstraint& constraint, std::vector<int>& held_with) {
  std::vector<int> robots;
  for (const Attachment& end : constraint.ends) {
    if (end.robot >= 0) robots.push_back(end.robot);
  }
  for (const int robot : robots) {
    int& first = held_with[static_cast<std::size_t>(robot)];
    if (first < 0) first = robot;
  }
  const int a = held_with[static_cast<std::size_t>(robots.front())];
  const int b = held_with[static_cast<std::size_t>(robots.back())];
  for (int& first : held_with) {
    if (first == a || first == b) first = a < b ? a : b;
  }
}

}  // namespace

CouplingScene::CouplingScene(const World& w) : world(w), held_with(w.scenario.robots.size(), -1) {
  int i = 0;
  for (const Coupling& coupling : world.scenario.couplings) {
    CouplingConstraint constraint;
    constraint.kind = coupling.kind;
    constraint.ends = {joined_end(world, coupling.ends[0]), joined_end(world, coupling.ends[1])};
    constraint.params = world.layout.coupling_params[static_cast<std::size_t>(i)];
    constraint.first_row = static_cast<int>(row_owners.size());
    constraint.row_count = rows_of(coupling.kind);
    for (int k = 0; k < constraint.row_count; ++k) row_owners.push_back(i);
    if (constraint.row_count > 0) hold_together(constraint, held_with);
    rope_count += coupling.kind == CouplingKind::kRope;
    constraints.push_back(constraint);
    ++i;
  }
  for (std::size_t r = 0; r < held_with.size(); ++r) {
    if (!is_held(static_cast<int>(r)) || world.drives[r] == DriveKind::kNone) continue;
    driven.push_back(world.layout.robots[r].first_body);
  }
}

}  // namespace skybody
