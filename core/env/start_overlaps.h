// Robots that begin an episode inside something: the allowed depth, and the encoding of an overlap
// in the episode's status.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/contact/contact.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A start is rejected if one thing begins deeper inside another than this many times
/// ContactSettings::penetration, the depth to which robots sink in by their own weight.
inline constexpr double kDeepStart = 10.0;

/// The deepest point of an overlap that is too deep.
struct StartOverlap {
  int body = 0;                       ///< world body index
  int other = kGround;                ///< as in Contact
  double depth = 0.0;                 ///< [m]
  Vec3<double> point{0.0, 0.0, 0.0};  ///< W [m]

  bool operator==(const StartOverlap&) const;
};

/// Immutable; refers to the world, which must outlive it.
class StartOverlaps {
 public:
  /// @param nominal  contacts of the start in the scenario file; overlaps there are intended and
  ///   allowed in drawn starts, too
  StartOverlaps(const World& world, std::vector<Contact> nominal);

  /// The overlap that exceeds its limit most, given the contacts of a start; none if all are
  /// allowed.
  std::optional<StartOverlap> find(const std::vector<Contact>& contacts) const;

  /// The status bits of an overlap: kBadStart and the data for reason().
  std::uint64_t status(const StartOverlap& overlap) const;
  /// The message: the overlapping things, the depth and the remedy. @param status  with kBadStart
  std::string reason(std::uint64_t status) const;

 private:
  double allowed_depth(int body, int other) const;
  double nominal_depth(int body, int other) const;
  bool stands(int body) const;
  std::string name_of(int other) const;

  const World& world_;
  std::vector<Contact> nominal_;
  std::vector<double> give_of_bodies_;     ///< greatest depth before contact lets things pass
                                           ///< through a body [m]
  std::vector<double> give_of_obstacles_;  ///< the same for obstacles
};

}  // namespace skybody
