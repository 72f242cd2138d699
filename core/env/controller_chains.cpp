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

/// Which actuators of a robot are commanded already, by signal.
using Claims = std::array<bool, SKYBODY_SIGNAL_COUNT>;

/// The chains of a world while they are made.
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
  /// @param first        its place within all
  ChainMaker(Chains& all, bool is_team, const std::vector<PluginUse>& uses,
             const PluginInstance* controllers, int first)
      : all_(all),
        plan_(all.plan),
        is_team_(is_team),
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
    throw MarkedError(uses_[static_cast<std::size_t>(i)].mark, message);
  }

  /// The chain of the robot itself that takes a team's output, or null.
  ControllerChain* fed_by(const PluginOutput& output) const {
    if (!is_team_) return nullptr;
    for (ControllerChain& chain : all_.of_robots) {
      if (chain.robot == output.robot && chain.signal == output.signal &&
          chain.inputs == output.count && !chain.is_fed) {
        return &chain;
      }
    }
    return nullptr;
  }

  /// What drives actuators ends a chain, unless the next controller takes just that.
  bool is_end(int i) const {
    const PluginInstance &c = at(i), &after = at(i + 1);
    const PluginOutput& given = c.outputs[0];
    if (!c.sites.empty() || !c.joints.empty()) return true;
    if (is_team_ && c.outputs.size() > 1) return true;
    const bool is_taken = after.input_signal == given.signal && after.input_count() == given.count;
    return !is_taken && (actuates(given.signal) || fed_by(given) != nullptr);
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
      if (fed_by(output) != nullptr) continue;
      if (!actuates(output.signal)) {
        refuse(i, "the last controller, `" + c.name + "`, gives " +
                      with_size(output.signal, output.count) +
                      "; it must give rotor_speed, wrench, joint, velocity or pose: add a "
                      "controller behind it that takes " +
                      signal_name(output.signal) +
                      (is_team_ ? ", to the team or to robot `" + robot(output).name + "`" : ""));
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

  int actuator_size(const PluginInstance& c, const PluginOutput& output) const {
    switch (output.signal) {
      case SKYBODY_ROTOR_SPEED:
        return layout(output).rotor_count;
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
    chain.robot = first.team.front();
    chain.first = first_ + begin;
    chain.count = end + 1 - begin;
    chain.signal = first.input_signal;
    chain.inputs = first.input_count();
    for (const PluginOutput& output : at(end).outputs) {
      chain.ends.push_back(make_end(end, at(end), output));
    }
    return chain;
  }

  /// Two chains that command the same actuators would fight.
  void claim(int i, const PluginOutput& output) {
    const int what = drives_base(output.signal) ? int{SKYBODY_VELOCITY} : output.signal;
    const bool may_share = what == SKYBODY_WRENCH || what == SKYBODY_JOINT;
    bool& is_taken =
        all_.claims[static_cast<std::size_t>(output.robot)][static_cast<std::size_t>(what)];
    if (is_taken && !may_share) {
      refuse(i, "controller `" + at(i).name + "` gives " + signal_name(output.signal) +
                    " to robot `" + robot(output).name +
                    "`, whose actuators a chain before it commands already");
    }
    is_taken = true;
  }

  ChainEnd make_end(int i, const PluginInstance& c, const PluginOutput& output) {
    ChainEnd end{output.robot, output.signal, output.count, nullptr, 0};
    if (ControllerChain* chain = fed_by(output)) {
      chain->is_fed = true;
      end.block = &Layout::command;
      end.first = chain->first;  // which chain: place_commands() knows its place
      return end;
    }
    claim(i, output);
    switch (output.signal) {
      case SKYBODY_ROTOR_SPEED:
        end.block = &Layout::rotor_command;
        end.first = layout(output).first_rotor;
        break;
      case SKYBODY_WRENCH:
        end.block = &Layout::wrench;
        end.first = 6 * static_cast<int>(plan_.sites.size());
        plan_.sites.insert(plan_.sites.end(), c.sites.begin(), c.sites.end());
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
    for (std::size_t k = 0; k < c.joints.size(); ++k) check_joint(i, c, output, k);
    end.block = &Layout::joint_command;
    end.first = static_cast<int>(plan_.joint_drives.size());
    plan_.joint_drives.insert(plan_.joint_drives.end(), c.joints.begin(), c.joints.end());
  }

  /// @param k  its place among the controller's
  void check_joint(int i, const PluginInstance& c, const PluginOutput& output,
                   std::size_t k) const {
    const JointDrive& drive = c.joints[k];
    const int place = drive.body - layout(output).first_body;
    const std::vector<Body>& bodies = robot(output).model.bodies;
    if (place < 0 || place >= static_cast<int>(bodies.size())) {
      refuse(i, "controller `" + c.name +
                    "` drives joints of several robots; a team's controller "
                    "gives joint to one");
    }
    const Joint& joint = bodies[static_cast<std::size_t>(place)].joint;
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

  void add_drive(const PluginOutput& output, ChainEnd& end) {
    const bool is_velocity = output.signal == SKYBODY_VELOCITY;
    end.block = &Layout::drive;
    end.first = 13 * count_driven(plan_.drives) + (is_velocity ? 0 : 6);
    plan_.drives[static_cast<std::size_t>(output.robot)] =
        is_velocity ? DriveKind::kVelocity : DriveKind::kPose;
  }

  Chains& all_;
  WorldPlan& plan_;
  bool is_team_;
  const std::vector<PluginUse>& uses_;
  const PluginInstance* controllers_;
  int first_;
};

/// In the order of evaluation, with the places of their commands.
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
      if (end.block != &Layout::command) continue;
      for (const ControllerChain& chain : chains) {
        if (chain.first == end.first) {
          end.first = chain.command;
          break;
        }
      }
    }
  }
  return chains;
}

}  // namespace

std::vector<ControllerChain> connect_controllers(const Scenario& scenario,
                                                 const std::vector<PluginInstance>& controllers,
                                                 WorldPlan& plan) {
  Chains all{scenario, plan, std::vector<Claims>(scenario.robots.size())};
  const PluginInstance* next = controllers.data();
  const auto connect = [&](const std::vector<PluginUse>& uses, bool is_team,
                           std::vector<ControllerChain>& chains) {
    const auto first = static_cast<int>(next - controllers.data());
    ChainMaker(all, is_team, uses, next, first).add_to(chains);
    next += uses.size();
  };
  for (const RobotUse& robot : scenario.robots) connect(robot.controllers, false, all.of_robots);
  for (const TeamUse& team : scenario.teams) connect(team.controllers, true, all.of_teams);
  return place_commands(all);
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
