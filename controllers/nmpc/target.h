// What the vehicle would have to do at a point of the reference, by differential flatness: the
// attitude, rates and rotor shares that the horizon's errors are measured from.
#pragma once

#include "controllers/common/flatness.h"
#include "controllers/nmpc/model.h"
#include "plugins/api/reference_point.h"

namespace skybody::nmpc {

/// Where the motion at a node should be.
struct Target {
  Vec3<double> position;      ///< W [m]
  Vec3<double> velocity;      ///< W [m/s]
  Quat<double> rotation;      ///< W from B
  Vec3<double> rates;         ///< B [rad/s]
  double share[kMostRotors];  ///< held to what a rotor can do
};

/// Shares of full thrust from an acceleration along z of B [m/s^2] and an angular acceleration, B
/// [rad/s^2]: the solution of least norm.
struct ShareRow {
  double thrust;
  Vec3<double> angular;
};

/// The reference at `time` after the point, by its derivatives, snap and yaw rate constant.
ReferencePoint<double> extrapolated(const ReferencePoint<double>& point, double time);

/// @param rows   of each rotor
/// @param least  share that no rotor goes below
Target target_of(const Model& model, const ShareRow* rows, double least,
                 const Disturbance& disturbance, const ReferencePoint<double>& point);

}  // namespace skybody::nmpc
