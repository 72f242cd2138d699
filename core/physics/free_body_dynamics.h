// `dynamics: tree` for a world of one free rigid body: Newton's and Euler's equations in closed
// form. R. Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.14 (spatial inertia,
// taken to a point other than the centre of mass) and 2.15 (equation of motion).
//
// In body axes, with c the centre of mass from the body's origin, I the inertia about it, w the
// angular velocity, and a force F and a moment M about the origin:
//   I dw/dt = M - c x F - w x (I w)
//   dv/dt   = F / m - dw/dt x c - w x (w x c)      v: velocity of the origin
// Components of dw/dt in the turning axes are those of the vector, since w x w = 0; v is in W axes.
#pragma once

#include <memory>
#include <string>

#include "core/physics/dynamics.h"

namespace skybody {

/// Why `dynamics: tree` cannot do a world, as the end of a sentence that begins with "the world";
/// empty if it can. It can do one robot that is one free body, without obstacles.
std::string why_not_tree(const World& world);

/// Dynamics of one free body. A drive is read from `world.drives`. Allocates when it is made only;
/// results have the same bits on every processor.
/// @param world  why_not_tree(world) is empty; must outlive the dynamics
/// @throws Error (naming the body) if no rigid body can have the nominal mass properties
std::unique_ptr<Dynamics> make_free_body_dynamics(const World& world);

}  // namespace skybody
