// The program behind `skybody onboard`.
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "onboard/about.h"
#include "onboard/link.h"
#include "onboard/options.h"
#include "onboard/runner.h"
#include "onboard/safe_command.h"

namespace skybody::onboard {
namespace {

constexpr int kInterrupted = 130;
volatile std::sig_atomic_t ends = 0;

void end_soon(int) { ends = 1; }

/// Puts another file in the place of the task's.
void set_reference(Mission& mission, const std::string& file) {
  for (SetupValue& value : mission.setup.values()) {
    if (!value.is_file()) continue;
    value.contents[0] = read_file(file);
    return;
  }
  throw Error(
      "--reference: the path of this mission is no file; export a scenario with "
      "`kind: csv`");
}

Mission open_mission(const Options& options) {
  Mission mission = read_mission(options.mission);
  if (options.gates) mission.setup.set_gates(read_gates(*options.gates, mission));
  if (options.reference) set_reference(mission, *options.reference);
  for (const auto& [name, values] : options.limits) set_limit(mission.limits, name, values);
  return mission;
}

/// @throws Error if a column cannot be made on a vehicle
void require_known(const Needs& needs) {
  if (needs.unknown.empty()) return;
  std::string names;
  for (const std::string& name : needs.unknown) names += (names.empty() ? "" : ", ") + name;
  throw Error("no packet gives the values of these columns of the observation: " + names);
}

void become_real_time(const Options& options) {
  if (options.locks_memory && mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    throw Error(std::string("--lock-memory: ") + std::strerror(errno) +
                "; raise `ulimit -l`, or leave it out");
  }
  if (options.fifo == 0) return;
  const sched_param priority{options.fifo};
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) {
    throw Error(std::string("--fifo: ") + std::strerror(errno) +
                "; raise `ulimit -r` or give the program CAP_SYS_NICE, or leave it out");
  }
}

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = end_soon;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void write_report(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw Error(file + ": cannot be written");
}

int fly(const Options& options, const Mission& mission, const Needs& needs) {
  Pilot pilot(mission);
  for (const auto& [path, values] : options.params) {
    if (!pilot.situation().set_param(mission, path, values)) {
      throw Error("--set: the mission has no value `" + path + "`");
    }
  }
  Inbox inbox(pilot, needs, options.lockstep, !options.waits);
  UdpSocket socket(address_of(options.listen));
  if (options.peer) socket.set_peer(address_of(*options.peer));
  std::unique_ptr<Link> link;
  if (options.mavlink) {
    link = std::make_unique<MavlinkLink>(socket, inbox, mission);
  } else {
    link = std::make_unique<PacketLink>(socket, inbox, mission);
  }
  if (mission.limits.safe == SafeAction::kDescend && !can_descend(mission.chain().signal)) {
    std::printf("safe     stop: there is no descent by %s\n", signal_word(mission.chain().signal));
  }
  become_real_time(options);
  std::printf("link     %s, port %d, %s\n", options.mavlink ? "MAVLink" : "UDP", socket.port(),
              options.lockstep ? "lockstep" : "real time");
  std::fflush(stdout);
  Runner runner(pilot, inbox, *link);
  if (options.lockstep) {
    runner.run_in_lockstep(options.seconds, ends);
  } else {
    runner.run_in_real_time(options.seconds, ends);
  }
  std::printf("%s", runner.report().text(inbox.counts()).c_str());
  if (options.json) write_report(*options.json, runner.report().json(inbox.counts()));
  return ends != 0 ? kInterrupted : 0;
}

int run(const std::vector<std::string>& arguments) {
  const Options options = parse_options(arguments);
  if (options.help) {
    std::printf("%s", help_text());
    return 0;
  }
  const Mission mission = open_mission(options);
  const Needs needs = find_needs(mission);
  if (options.about) {
    std::printf("%s", about(mission, needs).c_str());
    require_known(needs);
    return 0;
  }
  require_known(needs);
  std::printf("mission  %s, robot %s, a step each %g s\n", mission.scenario.c_str(),
              mission.vehicle().name, mission.period());
  catch_signals();
  return fly(options, mission, needs);
}

}  // namespace
}  // namespace skybody::onboard

int main(int count, char** arguments) {
  try {
    return skybody::onboard::run({arguments + 1, arguments + count});
  } catch (const std::exception& error) {
    std::fflush(stdout);
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}
