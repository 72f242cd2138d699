// The passes over the contacts of a substep.
#pragma once

namespace skybody {

/// Velocities from which the forces of a substep are computed.
enum class ContactPass {
  kStart,    ///< those at its start; contact points are computed
  kMean,     ///< mean ones, from the previous pass
  kLimited,  ///< likewise; too stiff springs use those at the start, by limited_force()
};

}  // namespace skybody
