#include "core/env/fault_cause.h"

#include <bit>
#include <cmath>
#include <cstdio>

#include "core/base/math/math.h"
#include "core/base/math/vec3.h"
#include "core/env/status_field.h"
#include "core/model/held_inputs.h"

namespace skybody {
namespace {

/// The kinds of causes. Each determines the list that the number indexes, and the text.
enum class Cause { kNone, kRotor, kJoint, kWrench, kDrive, kHeld, kVelocity, kSpin, kJointRate };

/// Bits of a status: 1 + the number, the cause, and the value as a float. A status with a number
/// but no cause is about a body that is not physical (impossible_body()).
constexpr StatusField kNumber{kBadStartPlace, 10}, kCause{kBadStartPlace + 10, 4},
    kValue{kBadStartPlace + 14, 32};

std::uint64_t bits_of(Cause cause, int number, double value) {
  const auto word = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return kNumber.put(number + 1.0) | kCause.put(static_cast<double>(cause)) |
         static_cast<std::uint64_t>(word) << kValue.place;
}

std::string robot_text(const World& world, int robot) {
  return " of robot `" + world.scenario.robots[static_cast<std::size_t>(robot)].name + "`";
}
std::string link_text(const World& world, int body) {
  const WorldBody& b = world.bodies[static_cast<std::size_t>(body)];
  return "link `" + b.model->name + "`" + robot_text(world, b.robot);
}
std::string joint_text(const World& world, int body) {
  const WorldBody& b = world.bodies[static_cast<std::size_t>(body)];
  return "joint `" + b.model->joint.name + "`" + robot_text(world, b.robot);
}
std::string rotor_text(const World& world, int index) {
  const WorldRotor& rotor = world.rotors[static_cast<std::size_t>(index)];
  return "rotor `" + rotor.model->name + "`" + robot_text(world, rotor.robot);
}

std::string value_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Searches a lane's values for the cause.
class Search {
 public:
  Search(const World& world, const StateGroup& group, int lane)
      : world_(world), group_(group), lane_(lane) {}

  std::uint64_t bits() const {
    const StateLayout& l = world_.layout;
    std::uint64_t bits = 0;
    const auto look = [&](const Block& block, Cause cause, int values_each) {
      for (int k = 0; k < block.size && bits == 0; ++k) {
        const double value = group_.reals(block.offset + k)[lane_];
        if (!std::isfinite(value)) bits = bits_of(cause, k / values_each, value);
      }
    };
    look(l.rotor_command, Cause::kRotor, 1);
    look(l.joint_command, Cause::kJoint, 1);
    look(l.wrench, Cause::kWrench, 6);
    look(l.drive, Cause::kDrive, kDriveSize);
    for (int i = 0; i < SKYBODY_HELD_COUNT && bits == 0; ++i) {
      const Block& block = l.held[static_cast<std::size_t>(i)];
      for (int k = 0; k < block.size && bits == 0; ++k) {
        const double value = group_.reals(block.offset + k)[lane_];
        if (!is_allowed(i, k, value)) bits = bits_of(Cause::kHeld, i, value);
      }
    }
    return bits != 0 ? bits : fastest();
  }

 private:
  /// Whether a held value is allowed: some inputs have a neutral value that is not finite.
  static bool is_allowed(int input, int k, double value) {
    const double neutral =
        neutral_value(input, k % kHeldInputs[static_cast<std::size_t>(input)].size);
    return std::isfinite(value) || value == neutral || (value != value && neutral != neutral);
  }

  /// The greatest velocity, angular velocity or joint rate, or the first that is NaN.
  std::uint64_t fastest() const {
    double most = 0.0;
    std::uint64_t bits = 0;
    const auto note = [&](Cause cause, std::size_t number, double value) {
      const double size = std::isnan(value) ? kInfinity : std::fabs(value);
      if (!(size > most)) return;
      most = size;
      bits = bits_of(cause, static_cast<int>(number), value);
    };
    for (std::size_t i = 0; i < world_.bodies.size(); ++i) {
      const auto value = [&](std::size_t k) {
        return group_.bodies()[(13 * i + k) * static_cast<std::size_t>(group_.lanes()) +
                               static_cast<std::size_t>(lane_)];
      };
      note(Cause::kVelocity, i, norm(Vec3<double>{value(7), value(8), value(9)}));
      note(Cause::kSpin, i, norm(Vec3<double>{value(10), value(11), value(12)}));
      const WorldBody& body = world_.bodies[i];
      if (!is_moving_joint(body.model->joint)) continue;
      for (int k = 0; k < velocity_size(body.model->joint.type); ++k) {
        note(Cause::kJointRate, i, group_.reals(world_.layout.u.offset + body.u + k)[lane_]);
      }
    }
    return bits;
  }

  const World& world_;
  const StateGroup& group_;
  int lane_;
};

}  // namespace

std::uint64_t cause_bits(const World& world, const StateGroup& group, int lane) {
  return Search(world, group, lane).bits();
}

std::string cause_text(const World& world, std::uint64_t status) {
  if ((status & kBadState) == 0 || (status & kBadStart) != 0) return "";
  const auto cause = static_cast<Cause>(kCause.get(status));
  const int number = static_cast<int>(kNumber.get(status)) - 1;
  const auto index = static_cast<std::size_t>(number);
  const auto word = static_cast<std::uint32_t>(kValue.get(status));
  const std::string value = value_text(static_cast<double>(std::bit_cast<float>(word)));
  switch (cause) {
    case Cause::kNone:
      return "";
    case Cause::kRotor:
      return rotor_text(world, number) + " was commanded " + value + " rad/s";
    case Cause::kJoint:
      return joint_text(world, world.joint_drives[index].body) + " was commanded " + value;
    case Cause::kWrench:
      return "a controller's wrench on " + link_text(world, world.sites[index].body) + " had " +
             value;
    case Cause::kDrive:
      return "the drive of a base was commanded " + value;
    case Cause::kHeld:
      return "effects held `" + std::string(kHeldInputs[index].name) + "` at " + value;
    case Cause::kVelocity:
      return link_text(world, number) + " moved at " + value + " m/s before";
    case Cause::kSpin:
      return link_text(world, number) + " turned at " + value + " rad/s before";
    case Cause::kJointRate: {
      const bool is_slider = world.bodies[index].model->joint.type == JointType::kSlider;
      return joint_text(world, number) + " moved at " + value +
             (is_slider ? " m/s before" : " rad/s before");
    }
  }
  return "";
}

}  // namespace skybody
