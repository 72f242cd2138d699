// Target at a point of the reference, by differential flatness: attitude, rates and rotor shares,
// from which the horizon's errors are measured.
#pragma once

#include "controllers/common/flatness.h"
#include "controllers/nmpc/model.h"
#include "plugins/api/reference_point.h"

namespace skybody::nmpc {

/// Desired motion at a node.
struct Target {
  Vec3<double> position;      ///< W [m]
  Vec3<double> velocity;      ///< W [m/s]
  Quat<double> rotation;      ///< W from B
  Vec3<double> rates;         ///< B [rad/s]
  double share[kMostRotors];  ///< limited to the rotors' range
};

/// Shares of full thrust for an acceleration along z of B [m/s^2] and an angular acceleration, B
/// [rad/s^2]: the solution of least norm.
struct ShareRow {
  double thrust;
  Vec3<double> angular;
};

/// The reference at `time` after the point, extrapolated by its derivatives with constant snap and
/// yaw rate.
ReferencePoint<double> extrapolated(const ReferencePoint<double>& point, double time);

/// @param rows   of each rotor
/// @param least  smallest share of a rotor
Target target_of(const Model& model, const ShareRow* rows, double least,
                 const Disturbance& disturbance, const ReferencePoint<double>& point);

}  // namespace skybody::nmpc
