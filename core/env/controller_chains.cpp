#include "core/env/controller_chains.h"

#include <algorithm>
#include <array>

#include "core/env/size_mismatch_hint.h"
#include "core/physics/world/world_layout.h"
#include "core/plugin_abi/text.h"

namespace skybody {
namespace {

bool drives_base(int signal) { return signal == SKYBODY_VELOCITY || signal == SKYBODY_POSE; }

std::string with_size(int signal, int count) {
  return std::string(signal_name(signal)) + "[" + std::to_string(count) + "]";
}

/// The actuators of a robot that are already commanded, by signal.
using Claims = std::array<bool, SKYBODY_SIGNAL_COUNT>;

/// The chains of a world during construction.
struct Chains {
  const Scenario& scenario;
  WorldPlan& plan;
  std::vector<Claims> claims;  ///< per robot
  std::vector<ControllerChain> of_robots = {};
  std::vector<ControllerChain> of_teams = {};
};

/// Makes the chains of one robot or team.
class ChainMaker {
 public:
  /// @param uses         of its controllers
  /// @param controllers  the first of them
  /// @param first        its index among all controllers
  ChainMaker(Chains& all, int team, const std::vector<PluginUse>& uses, PluginInstance* controllers,
             int first)
      : all_(all),
        plan_(all.plan),
        team_(team),
        uses_(uses),
        controllers_(controllers),
        first_(first) {}

  void add_to(std::vector<ControllerChain>& chains) {
    const int count = static_cast<int>(uses_.size());
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
  const RobotUse& robot(const PluginOutput& output) const {
    return all_.scenario.robots[static_cast<std::size_t>(output.robot)];
  }
  const RobotLayout& layout(const PluginOutput& output) const {
    return plan_.layout.robots[static_cast<std::size_t>(output.robot)];
  }

  [[noreturn]] void refuse(int i, const std::string& message) const {
    throw LocatedError(uses_[static_cast<std::size_t>(i)].mark, message);
  }

  /// The robot's own chain that takes a team's output, or null.
  ControllerChain* fed_by(const PluginInstance& c, const PluginOutput& output) const {
    const bool has_ends = (output.signal == SKYBODY_WRENCH && !c.controller.sites.empty()) ||
                          (output.signal == SKYBODY_JOINT && !c.controller.joints.empty());
    if (team_ < 0 || has_ends) return nullptr;
    for (ControllerChain& chain : all_.of_robots) {
      if (chain.robot == output.robot && chain.signal == output.signal &&
          chain.inputs == output.count && !chain.is_fed) {
        return &chain;
      }
    }
    return nullptr;
  }

  bool is_fed_already(const PluginOutput& output) const {
    return std::any_of(all_.of_robots.begin(), all_.of_robots.end(),
                       [&](const ControllerChain& chain) {
                         return chain.is_fed && chain.robot == output.robot &&
                                chain.signal == output.signal && chain.inputs == output.count;
                       });
  }

  /// A controller that drives actuators ends a chain, unless the next controller takes the same
  /// signal.
  bool is_end(int i) const {
    const PluginInstance &c = at(i), &after = at(i + 1);
    const PluginOutput& given = c.controller.outputs[0];
    if (!c.controller.sites.empty() || !c.controller.joints.empty()) return true;
    if (team_ >= 0 && c.controller.outputs.size() > 1) return true;
    const bool is_taken = after.controller.input_signal == given.signal &&
                          after.controller.input_count() == given.count;
    return !is_taken && (actuates(given.signal) || fed_by(c, given) != nullptr);
  }

  /// Checks that controller i's output matches the next controller's input.
  void check_link(int i) const {
    const PluginInstance &c = at(i), &after = at(i + 1);
    if (c.controller.outputs.size() > 1) {
      refuse(i, "controller `" + c.name + "` gives " + std::to_string(c.controller.outputs.size()) +
                    " signals, but is not the last one of its chain: only actuators take several");
    }
    const PluginOutput& given = c.controller.outputs[0];
    if (after.controller.input_signal != given.signal ||
        after.controller.input_count() != given.count) {
      const std::string remedy =
          after.controller.input_signal == given.signal
              ? size_mismatch_hint(given.signal, given.count, after.controller.input_count())
              : "";
      throw ChainMismatchError(
          uses_[static_cast<std::size_t>(i) + 1].mark,
          "controller `" + after.name + "` takes " +
              with_size(after.controller.input_signal, after.controller.input_count()) + ", but `" +
              c.name + "` before it gives " + with_size(given.signal, given.count) + remedy,
          given.signal, after.controller.input_signal);
    }
  }

  void check_last(int i) const {
    const PluginInstance& c = at(i);
    for (const PluginOutput& output : c.controller.outputs) {
      if (fed_by(c, output) != nullptr) continue;
      if (team_ >= 0 && is_fed_already(output)) {
        refuse(i, "controller `" + c.name + "` gives " + with_size(output.signal, output.count) +
                      " to robot `" + robot(output).name +
                      "`, whose chain that takes it is fed by another output already");
      }
      if (!actuates(output.signal)) {
        throw ChainMismatchError(
            uses_[static_cast<std::size_t>(i)].mark,
            "the last controller, `" + c.name + "`, gives " +
                with_size(output.signal, output.count) +
                "; it must give rotor_speed, wrench, joint, velocity or pose: add a "
                "controller behind it that takes " +
                signal_name(output.signal) +
                (team_ >= 0 ? ", to the team or to robot `" + robot(output).name + "`" : ""),
            output.signal, -1);
      }
      check_actuator(i, output);
    }
    check_used(i, c.controller.sites, SKYBODY_WRENCH, "wrench sites");
    check_used(i, c.controller.joints, SKYBODY_JOINT, "joint drives");
  }

  /// Checks that each site has a wrench and each drive a command, from an output to its own robot.
  template <class T>
  void check_used(int i, const std::vector<T>& all, int signal, const char* what) const {
    const PluginInstance& c = at(i);
    std::size_t used = 0;
    for (const PluginOutput& output : c.controller.outputs) {
      if (output.signal == signal) used += of_robot(all, output).size();
    }
    if (used == all.size()) return;
    const std::string word = signal_name(signal);
    refuse(i, "controller `" + c.name + "` declares " + what + ", but gives " +
                  (c.controller.gives(signal)
                       ? "no " + word + " to the robot that has them"
                       : signal_name(c.controller.outputs[0].signal) + (" and no " + word)));
  }

  void check_actuator(int i, const PluginOutput& output) const {
    const PluginInstance& c = at(i);
    const int expected = actuator_size(c, output);
    if (output.count != expected) {
      refuse(i, "controller `" + c.name + "` gives " + with_size(output.signal, output.count) +
                    ", this robot takes [" + std::to_string(expected) + "]");
    }
    if (drives_base(output.signal) && robot(output).model.fixed_base) {
      refuse(i, "controller `" + c.name + "` drives the base, but robot `" + robot(output).name +
                    "` has a fixed one");
    }
  }

  /// The sites or drives on the output's robot.
  template <class T>
  std::vector<T> of_robot(const std::vector<T>& all, const PluginOutput& output) const {
    const RobotLayout& bodies = layout(output);
    std::vector<T> own;
    for (const T& one : all) {
      const int place = one.body - bodies.first_body;
      if (place >= 0 && place < bodies.body_count) own.push_back(one);
    }
    return own;
  }

  int actuator_size(const PluginInstance& c, const PluginOutput& output) const {
    switch (output.signal) {
      case SKYBODY_ROTOR_SPEED:
        return layout(output).rotor_count;
      case SKYBODY_WRENCH:
        return 6 * static_cast<int>(of_robot(c.controller.sites, output).size());
      case SKYBODY_JOINT:
        return static_cast<int>(of_robot(c.controller.joints, output).size());
      case SKYBODY_VELOCITY:
        return 6;
      default:
        return 7;
    }
  }

  /// A controller that passes its command on gets the range of the first one after it with a range.
  void take_range(int begin, int end) const {
    int from = begin;
    while (from < end && at(from).controller.passes_on) ++from;
    if (at(from).controller.passes_on) {
      refuse(begin,
             "controller `" + at(begin).name +
                 "` passes its command on, but nothing behind it says what actions -1 and +1 "
                 "mean: add a controller behind it that takes " +
                 signal_name(at(begin).controller.input_signal));
    }
    controllers_[begin].controller.low = at(from).controller.low;
    controllers_[begin].controller.high = at(from).controller.high;
  }

  ControllerChain make_chain(int begin, int end) {
    take_range(begin, end);
    const PluginInstance& first = at(begin);
    ControllerChain chain;
    chain.robot = first.controller.team.front();
    chain.team = team_;
    chain.first = first_ + begin;
    chain.count = end + 1 - begin;
    chain.signal = first.controller.input_signal;
    chain.inputs = first.controller.input_count();
    for (const PluginOutput& output : at(end).controller.outputs) {
      chain.ends.push_back(make_end(end, at(end), output));
    }
    return chain;
  }

  /// Rejects two chains that command the same actuators.
  void claim(int i, const PluginOutput& output) {
    const int what = drives_base(output.signal) ? int{SKYBODY_VELOCITY} : output.signal;
    const bool may_share = what == SKYBODY_WRENCH || what == SKYBODY_JOINT;
    bool& is_taken =
        all_.claims[static_cast<std::size_t>(output.robot)][static_cast<std::size_t>(what)];
    if (is_taken && !may_share) {
      refuse(i, "controller `" + at(i).name + "` gives " + signal_name(output.signal) +
                    " to robot `" + robot(output).name +
                    "`, whose actuators a chain before it commands already: leave one of them out");
    }
    is_taken = true;
  }

  ChainEnd make_end(int i, const PluginInstance& c, const PluginOutput& output) {
    ChainEnd end;
    end.robot = output.robot;
    end.signal = output.signal;
    end.count = output.count;
    if (ControllerChain* chain = fed_by(c, output)) {
      chain->is_fed = true;
      end.block = &StateLayout::command;
      end.feeds = chain->first;  // place_commands() sets the place of its command
      return end;
    }
    claim(i, output);
    switch (output.signal) {
      case SKYBODY_ROTOR_SPEED:
        end.block = &StateLayout::rotor_command;
        end.first = layout(output).first_rotor;
        break;
      case SKYBODY_WRENCH:
        end.block = &StateLayout::wrench;
        end.first = 6 * static_cast<int>(plan_.sites.size());
        for (const WrenchSite& site : of_robot(c.controller.sites, output))
          plan_.sites.push_back(site);
        break;
      case SKYBODY_JOINT:
        add_joints(i, c, output, end);
        break;
      default:
        add_drive(output, end);
    }
    return end;
  }

  void add_joints(int i, const PluginInstance& c, const PluginOutput& output, ChainEnd& end) {
    end.block = &StateLayout::joint_command;
    end.first = static_cast<int>(plan_.joint_drives.size());
    for (const JointDrive& drive : of_robot(c.controller.joints, output)) {
      check_joint(i, c, output, drive);
      plan_.joint_drives.push_back(drive);
    }
  }

  void check_joint(int i, const PluginInstance& c, const PluginOutput& output,
                   const JointDrive& drive) const {
    const int place = drive.body - layout(output).first_body;
    const Joint& joint = robot(output).model.bodies[static_cast<std::size_t>(place)].joint;
    const auto is_same = [&](const JointDrive& other) {
      return other.body == drive.body && other.coordinate == drive.coordinate;
    };
    if (std::any_of(plan_.joint_drives.begin(), plan_.joint_drives.end(), is_same)) {
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

  void add_drive(const PluginOutput& output, ChainEnd& end) {
    const bool is_velocity = output.signal == SKYBODY_VELOCITY;
    end.block = &StateLayout::drive;
    end.first =
        kDriveSize * count_driven(plan_.drives) + (is_velocity ? kDriveVelocity : kDrivePosition);
    plan_.drives[static_cast<std::size_t>(output.robot)] =
        is_velocity ? DriveKind::kVelocity : DriveKind::kPose;
  }

  Chains& all_;
  WorldPlan& plan_;
  int team_;  ///< -1: of a robot
  const std::vector<PluginUse>& uses_;
  PluginInstance* controllers_;
  int first_;
};

/// The chains in the order of evaluation, with the places of their commands.
std::vector<ControllerChain> place_commands(Chains& all) {
  std::vector<ControllerChain> chains = std::move(all.of_robots);
  chains.insert(chains.end(), all.of_teams.begin(), all.of_teams.end());
  std::stable_sort(chains.begin(), chains.end(),
                   [](const ControllerChain& a, const ControllerChain& b) {
                     if (a.is_fed != b.is_fed) return b.is_fed;
                     return a.robot < b.robot;
                   });
  int& size = all.plan.layout.command.size;
  for (ControllerChain& chain : chains) {
    chain.command = size;
    size += chain.inputs;
  }
  for (ControllerChain& feeding : chains) {
    for (ChainEnd& end : feeding.ends) {
      if (end.feeds < 0) continue;
      const auto fed =
          std::find_if(chains.begin(), chains.end(),
                       [&](const ControllerChain& chain) { return chain.first == end.feeds; });
      SKYBODY_DEMAND(fed != chains.end(), "an end feeds no chain");
      end.first = fed->command;
    }
  }
  return chains;
}

}  // namespace

std::vector<ControllerChain> connect_controllers(const Scenario& scenario,
                                                 std::vector<PluginInstance>& controllers,
                                                 WorldPlan& plan) {
  Chains all{scenario, plan, std::vector<Claims>(scenario.robots.size())};
  PluginInstance* next = controllers.data();
  const auto connect = [&](const std::vector<PluginUse>& uses, int team,
                           std::vector<ControllerChain>& chains) {
    const auto first = static_cast<int>(next - controllers.data());
    ChainMaker(all, team, uses, next, first).add_to(chains);
    next += uses.size();
  };
  for (const RobotUse& robot : scenario.robots) connect(robot.controllers, -1, all.of_robots);
  int number = 0;
  for (const TeamUse& team : scenario.teams) connect(team.controllers, number++, all.of_teams);
  return place_commands(all);
}

bool actuates(int signal) {
  return signal == SKYBODY_ROTOR_SPEED || signal == SKYBODY_WRENCH || signal == SKYBODY_JOINT ||
         drives_base(signal);
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

const char* signal_meaning(int signal) {
  static constexpr std::array<const char*, SKYBODY_SIGNAL_COUNT> kMeanings = {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) doc,
      SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  return signal >= 0 && signal < SKYBODY_SIGNAL_COUNT ? kMeanings[static_cast<std::size_t>(signal)]
                                                      : "";
}

}  // namespace skybody
