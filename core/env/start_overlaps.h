// Where robots begin an episode inside something: how deep is too deep, and how an episode's status
// tells it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/contact/contact.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A start is bad where something begins deeper in something else than so many times
/// ContactSettings::penetration, which is what robots sink in by their own weight.
inline constexpr double kDeepStart = 10.0;

/// The deepest place of two things of which one begins too deep in the other.
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
  /// @param nominal  contacts in the start that the scenario describes: what overlaps there is the
  ///                 scenario's, and may overlap in drawn starts, too
  StartOverlaps(const World& world, std::vector<Contact> nominal);

  /// Of a start with these contacts the overlap that is too deep by most, if there is one.
  std::optional<StartOverlap> find(const std::vector<Contact>& contacts) const;

  /// The bits of a status that say so: kBadStart and what reason() needs.
  std::uint64_t status(const StartOverlap& overlap) const;
  /// What begins inside what, how deep, and what to do. @param status  with kBadStart
  std::string reason(std::uint64_t status) const;

 private:
  double allowed_depth(int body, int other) const;
  double nominal_depth(int body, int other) const;
  bool stands(int body) const;
  std::string name_of(int other) const;

  const World& world_;
  std::vector<Contact> nominal_;
  std::vector<double> give_of_bodies_;     ///< how deep contact lets things get into them [m]
  std::vector<double> give_of_obstacles_;  ///< likewise
};

}  // namespace skybody
