// Dynamics for worlds without couplings.
#pragma once

#include "core/physics/simbody/dynamics.h"

namespace skybody::test {

class UncoupledDynamics : public Dynamics {
 public:
  void hold(const bool*) override {}
  void constrained_accelerations(const double* q, const double* u,
                                 const SpatialForce<double>* body_forces,
                                 const double* joint_forces, double* udot) override {
    accelerations(q, u, body_forces, joint_forces, udot);
  }
  void project(double*, double*) override {}
};

}  // namespace skybody::test
