// A group lane after lane: each on a stepper of its own.
#include <cstring>

#include "core/base/octets.h"
#include "core/physics/group_stepper.h"
#include "core/physics/kinematics.h"
#include "core/physics/stepper.h"

namespace skybody {
namespace {

class SerialGroupStepper final : public GroupStepper {
 public:
  SerialGroupStepper(const World& world, int lanes)
      : world_(world), tree_(make_tree(world)), lanes_(static_cast<std::size_t>(lanes)) {}

  void refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t,
               PhysicsScratch&) override {
    each_lane(lanes, [&](int l) {
      Lane& lane = lane_at(l);
      read(group, l, lane.state);
      for (const TreeBody& body : tree_) make_unit(body.type, lane.state.q.data() + body.q);
      lane.stepper->update_bodies(lane.state);
      write(group, l, lane.state.q, group.q);
      write_bodies(group, l, lane.state);
    });
  }

  std::uint32_t advance(const GroupBlocks& group, std::uint32_t lanes, PhysicsScratch&) override {
    std::uint32_t through = 0, on_simbody = 0;
    each_lane(lanes, [&](int l) {
      Lane& lane = lane_at(l);
      read_commands(group, l, lane.state);
      const bool came_through = lane.stepper->advance(lane.state);
      if (lane.stepper->was_on_simbody()) on_simbody |= 1u << l;
      if (!came_through) return;
      through |= 1u << l;
      write(group, l, lane.state.q, group.q);
      write(group, l, lane.state.u, group.u);
      write(group, l, lane.state.rotor_speed, group.rotor_speed);
      write_bodies(group, l, lane.state);
    });
    note_step(lanes, on_simbody);
    return through;
  }

  void accelerations(const GroupBlocks& group, int l, double* udot) override {
    Lane& lane = lane_at(l);
    read(group, l, lane.state);
    read_commands(group, l, lane.state);
    lane.stepper->accelerations(lane.state, udot);
  }

  void add_contacts(const GroupBlocks& group, int l, std::vector<Contact>& out) override {
    Lane& lane = lane_at(l);
    read(group, l, lane.state);
    lane.stepper->add_contacts(lane.state, out);
  }

 private:
  struct Lane {
    std::unique_ptr<Stepper> stepper;
    LaneState state;
  };

  /// Made when the lane is first used: a Simbody system takes time and memory.
  Lane& lane_at(int l) {
    Lane& lane = lanes_[static_cast<std::size_t>(l)];
    if (lane.stepper) return lane;
    lane.stepper = make_stepper(world_);
    const Layout& layout = world_.layout;
    const auto size = [](const Block& block) { return static_cast<std::size_t>(block.size); };
    lane.state.q.resize(size(layout.q));
    lane.state.u.resize(size(layout.u));
    lane.state.rotor_speed.resize(size(layout.rotor_speed));
    lane.state.rotor_command.resize(size(layout.rotor_command));
    lane.state.wrench.resize(size(layout.wrench));
    lane.state.drive.resize(size(layout.drive));
    lane.state.params.resize(size(layout.params));
    lane.state.bodies.resize(world_.bodies.size());
    return lane;
  }

  static void read(const GroupBlocks& group, int l, const double* from, std::vector<double>& to) {
    if (group.lanes == 1) {
      if (!to.empty()) std::memcpy(to.data(), from, to.size() * sizeof(double));
      return;
    }
    const auto stride = static_cast<std::size_t>(group.lanes);
    for (std::size_t k = 0; k < to.size(); ++k)
      to[k] = from[k * stride + static_cast<std::size_t>(l)];
  }
  static void read(const GroupBlocks& group, int l, LaneState& state) {
    read(group, l, group.q, state.q);
    read(group, l, group.u, state.u);
    read(group, l, group.rotor_speed, state.rotor_speed);
    read(group, l, group.params, state.params);
  }
  static void read_commands(const GroupBlocks& group, int l, LaneState& state) {
    read(group, l, group.rotor_command, state.rotor_command);
    read(group, l, group.wrench, state.wrench);
    read(group, l, group.drive, state.drive);
  }

  static void write(const GroupBlocks& group, int l, const double* from, std::size_t count,
                    double* to) {
    if (group.lanes == 1) {
      if (count > 0) std::memcpy(to, from, count * sizeof(double));
      return;
    }
    const auto stride = static_cast<std::size_t>(group.lanes);
    for (std::size_t k = 0; k < count; ++k) to[k * stride + static_cast<std::size_t>(l)] = from[k];
  }
  static void write(const GroupBlocks& group, int l, const std::vector<double>& from, double* to) {
    write(group, l, from.data(), from.size(), to);
  }
  static void write_bodies(const GroupBlocks& group, int l, const LaneState& state) {
    write(group, l, reinterpret_cast<const double*>(state.bodies.data()), 13 * state.bodies.size(),
          group.bodies);
  }

  const World& world_;
  std::vector<TreeBody> tree_;
  std::vector<Lane> lanes_;
};

}  // namespace

std::unique_ptr<GroupStepper> make_serial_group_stepper(const World& world, int lanes) {
  return std::make_unique<SerialGroupStepper>(world, lanes);
}

}  // namespace skybody
