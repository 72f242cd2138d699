// Overlap of shapes, for checks before a simulation.
#pragma once

#include <vector>

#include "core/model/robot_model.h"

namespace skybody {

/// Radius of the bounding sphere about the origin of a shape's frame [m]; infinite for a plane and
/// a height field. A mesh is replaced by its bounding box.
double bounding_radius(const Shape& shape);

/// Sample points of a shape: its extremities, points on its surface and inside it; in its own frame
/// [m].
/// None for a plane or a height field.
std::vector<Vec3<double>> points_of(const Shape& shape);

/// Depth of the deepest point of `a` in `b`, or of `b` in `a`; 0 without overlap. Tests
/// points_of(), so that parts thinner than a quarter of the other shape may be missed.
/// @param a_pose, b_pose  of the shapes' frames, in any common frame
/// @returns [m]
double overlap(const Shape& a, const Pose& a_pose, const Shape& b, const Pose& b_pose);

}  // namespace skybody
