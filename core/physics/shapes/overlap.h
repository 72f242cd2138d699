// Whether shapes lie in one another, for checks before a flight.
#pragma once

#include <vector>

#include "core/model/robot_model.h"

namespace skybody {

/// Radius of the sphere about a shape's frame that holds it [m]; infinite of a plane and a height
/// field. A mesh is the box about it.
double bounding_radius(const Shape& shape);

/// Points that span a shape: its extremities, points on its surface and inside; its own frame [m].
/// None of a plane or a height field.
std::vector<Vec3<double>> points_of(const Shape& shape);

/// How deep the deepest point of `a` lies in `b`, or of `b` in `a`: 0 where none does. Points are
/// points_of(), so that what is thinner than a quarter of the other shape may be missed.
/// @param a_pose, b_pose  of the shapes' frames, in any common frame
/// @returns [m]
double overlap(const Shape& a, const Pose& a_pose, const Shape& b, const Pose& b_pose);

}  // namespace skybody
