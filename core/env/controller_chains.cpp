#include "core/env/controller_chains.h"

#include <algorithm>
#include <array>

#include "core/model/marked_error.h"
#include "core/physics/world/world_layout.h"
#include "plugins/api/text.h"

namespace skybody {
namespace {

bool drives_base(int signal) { return signal == SKYBODY_VELOCITY || signal == SKYBODY_POSE; }

/// Signals that actuators take.
bool actuates(int signal) {
  return signal == SKYBODY_ROTOR_SPEED || signal == SKYBODY_WRENCH || signal == SKYBODY_JOINT ||
         drives_base(signal);
}

std::string with_size(int signal, int count) {
  return std::string(signal_name(signal)) + "[" + std::to_string(count) + "]";
}

/// The chains of one robot.
class RobotChains {
 public:
  RobotChains(const Scenario& scenario, int robot, const PluginInstance* controllers, int first,
              WorldPlan& plan)
      : use_(scenario.robots[static_cast<std::size_t>(robot)]),
        robot_(robot),
        controllers_(controllers),
        first_(first),
        plan_(plan) {}

  void add_to(std::vector<ControllerChain>& chains) {
    const int count = static_cast<int>(use_.controllers.size());
    for (int begin = 0; begin < count;) {
      int end = begin;
      while (end + 1 < count && !is_end(end)) check_link(end++);
      check_last(end);
      chains.push_back(make_chain(begin, end));
      begin = end + 1;
    }
  }

 private:
  const PluginInstance& at(int i) const { return controllers_[i]; }

  [[noreturn]] void refuse(int i, const std::string& message) const {
    throw MarkedError(use_.controllers[static_cast<std::size_t>(i)].mark, message);
  }

  /// What drives actuators ends a chain, unless the next controller takes just that.
  bool is_end(int i) const {
    const PluginInstance &c = at(i), &after = at(i + 1);
    const PluginOutput& given = c.outputs[0];
    if (!c.sites.empty() || !c.joints.empty()) return true;
    const bool is_taken = after.input_signal == given.signal && after.input_count() == given.count;
    return actuates(given.signal) && !is_taken;
  }

  /// Controller i gives what the next one takes.
  void check_link(int i) const {
    const PluginInstance &c = at(i), &after = at(i + 1);
    if (c.outputs.size() > 1) {
      refuse(i, "controller `" + c.name + "` gives " + std::to_string(c.outputs.size()) +
                    " signals, but is not the last one of its chain: only actuators take several");
    }
    const PluginOutput& given = c.outputs[0];
    if (after.input_signal != given.signal || after.input_count() != given.count) {
      refuse(i + 1, "controller `" + after.name + "` takes " +
                        with_size(after.input_signal, after.input_count()) + ", but `" + c.name +
                        "` before it gives " + with_size(given.signal, given.count));
    }
  }

  void check_last(int i) const {
    const PluginInstance& c = at(i);
    for (const PluginOutput& output : c.outputs) {
      if (!actuates(output.signal)) {
        refuse(i, "the last controller, `" + c.name + "`, gives " + signal_name(output.signal) +
                      "; it must give rotor_speed, wrench, joint, velocity or pose: add a "
                      "controller behind it that takes " +
                      signal_name(output.signal));
      }
      check_actuator(i, output);
    }
    if (!c.sites.empty() && !c.gives(SKYBODY_WRENCH)) {
      refuse(i, "controller `" + c.name + "` declares wrench sites, but gives " +
                    signal_name(c.outputs[0].signal) + " and no wrench");
    }
    if (!c.joints.empty() && !c.gives(SKYBODY_JOINT)) {
      refuse(i, "controller `" + c.name + "` declares joint drives, but gives " +
                    signal_name(c.outputs[0].signal) + " and no joint");
    }
  }

  void check_actuator(int i, const PluginOutput& output) const {
    const PluginInstance& c = at(i);
    const int expected = actuator_size(c, output.signal);
    if (output.count != expected) {
      refuse(i, "controller `" + c.name + "` gives " + with_size(output.signal, output.count) +
                    ", this robot takes [" + std::to_string(expected) + "]");
    }
    if (drives_base(output.signal) && use_.model.fixed_base) {
      refuse(i, "controller `" + c.name + "` drives the base, but robot `" + use_.name +
                    "` has a fixed one");
    }
  }

  int actuator_size(const PluginInstance& c, int signal) const {
    switch (signal) {
      case SKYBODY_ROTOR_SPEED:
        return plan_.layout.robots[static_cast<std::size_t>(robot_)].rotor_count;
      case SKYBODY_WRENCH:
        return 6 * static_cast<int>(c.sites.size());
      case SKYBODY_JOINT:
        return static_cast<int>(c.joints.size());
      case SKYBODY_VELOCITY:
        return 6;
      default:
        return 7;
    }
  }

  ControllerChain make_chain(int begin, int end) {
    const PluginInstance& first = at(begin);
    ControllerChain chain;
    chain.robot = robot_;
    chain.first = first_ + begin;
    chain.count = end + 1 - begin;
    chain.signal = first.input_signal;
    chain.command = plan_.layout.command.size;
    chain.inputs = first.input_count();
    plan_.layout.command.size += chain.inputs;
    for (const PluginOutput& output : at(end).outputs) {
      claim(end, output.signal);
      chain.ends.push_back(make_end(end, at(end), output));
    }
    return chain;
  }

  /// Two chains that command the same actuators would fight.
  void claim(int i, int signal) {
    const int what = drives_base(signal) ? int{SKYBODY_VELOCITY} : signal;
    const bool may_share = what == SKYBODY_WRENCH || what == SKYBODY_JOINT;
    bool& is_taken = taken_[static_cast<std::size_t>(what)];
    if (is_taken && !may_share) {
      refuse(i, "controller `" + at(i).name + "` gives " + signal_name(signal) + " to robot `" +
                    use_.name + "`, whose actuators a chain before it commands already");
    }
    is_taken = true;
  }

  ChainEnd make_end(int i, const PluginInstance& c, const PluginOutput& output) {
    ChainEnd end{output.signal, output.count, nullptr, 0};
    switch (output.signal) {
      case SKYBODY_ROTOR_SPEED:
        end.block = &Layout::rotor_command;
        end.first = plan_.layout.robots[static_cast<std::size_t>(robot_)].first_rotor;
        break;
      case SKYBODY_WRENCH:
        end.block = &Layout::wrench;
        end.first = 6 * static_cast<int>(plan_.sites.size());
        plan_.sites.insert(plan_.sites.end(), c.sites.begin(), c.sites.end());
        break;
      case SKYBODY_JOINT:
        add_joints(i, c, end);
        break;
      default:
        add_drive(output.signal, end);
    }
    return end;
  }

  void add_joints(int i, const PluginInstance& c, ChainEnd& end) {
    for (std::size_t k = 0; k < c.joints.size(); ++k) check_joint(i, c, c.joints[k], k);
    end.block = &Layout::joint_command;
    end.first = static_cast<int>(plan_.joint_drives.size());
    plan_.joint_drives.insert(plan_.joint_drives.end(), c.joints.begin(), c.joints.end());
  }

  /// @param k  its place among the controller's
  void check_joint(int i, const PluginInstance& c, const JointDrive& drive, std::size_t k) const {
    const RobotLayout& layout = plan_.layout.robots[static_cast<std::size_t>(robot_)];
    const Joint& joint =
        use_.model.bodies[static_cast<std::size_t>(drive.body - layout.first_body)].joint;
    const auto is_same = [&](const JointDrive& other) {
      return other.body == drive.body && other.coordinate == drive.coordinate;
    };
    const auto own_end = c.joints.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::any_of(c.joints.begin(), own_end, is_same) ||
        std::any_of(plan_.joint_drives.begin(), plan_.joint_drives.end(), is_same)) {
      refuse(i, "controller `" + c.name + "` drives joint `" + joint.name +
                    "`, which is driven already; a joint has one drive");
    }
    if (drive.mode == JointMode::kPosition &&
        (joint.position < drive.low || joint.position > drive.high)) {
      refuse(i, "controller `" + c.name + "` holds joint `" + joint.name + "` to " +
                    to_text(drive.low) + " .. " + to_text(drive.high) + ", but it begins at " +
                    to_text(joint.position) +
                    ": widen `low` and `high`, or move the joint's `position`");
    }
  }

  void add_drive(int signal, ChainEnd& end) {
    const bool is_velocity = signal == SKYBODY_VELOCITY;
    end.block = &Layout::drive;
    end.first = 13 * count_driven(plan_.drives) + (is_velocity ? 0 : 6);
    plan_.drives[static_cast<std::size_t>(robot_)] =
        is_velocity ? DriveKind::kVelocity : DriveKind::kPose;
  }

  const RobotUse& use_;
  int robot_;
  const PluginInstance* controllers_;  ///< of this robot
  int first_;                          ///< the first of them within all
  WorldPlan& plan_;
  std::array<bool, SKYBODY_SIGNAL_COUNT> taken_{};
};

}  // namespace

std::vector<ControllerChain> connect_controllers(const Scenario& scenario,
                                                 const std::vector<PluginInstance>& controllers,
                                                 WorldPlan& plan) {
  std::vector<ControllerChain> chains;
  int first = 0;
  for (int r = 0; r < static_cast<int>(scenario.robots.size()); ++r) {
    RobotChains(scenario, r, controllers.data() + first, first, plan).add_to(chains);
    first += static_cast<int>(scenario.robots[static_cast<std::size_t>(r)].controllers.size());
  }
  return chains;
}

const char* signal_name(int signal) {
  static constexpr std::array<const char*, SKYBODY_SIGNAL_COUNT> kNames = {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) #word,
      SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  return signal >= 0 && signal < SKYBODY_SIGNAL_COUNT ? kNames[static_cast<std::size_t>(signal)]
                                                      : "none";
}

}  // namespace skybody
