#include "onboard/runner.h"

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

namespace skybody::onboard {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr int kMostPackets = 256;  // between two looks at the clock: a flood does not stop steps

/// The monotonic clock [ns].
std::int64_t nanoseconds() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}
double seconds_of(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

std::string mode_line(const Decision& decision) {
  switch (decision.mode) {
    case Mode::kPolicy:
      return "policy   flies";
    case Mode::kSafe:
      return "safe     " + reason_text(decision.reasons);
    case Mode::kStopped:
      return "stopped  " + reason_text(decision.reasons);
    default:
      return "waiting";
  }
}

}  // namespace

std::string FlightReport::json(const PacketCounts& packets) const {
  const auto number = [](const char* name, std::uint64_t value) {
    return "\"" + std::string(name) + "\": " + std::to_string(value) + ", ";
  };
  return "{" + number("steps", steps) + number("left_out", left_out) +
         number("safe_steps", safe_steps) + number("packets", packets.taken) +
         number("refused", packets.all_refused()) + "\"reasons\": \"" + reason_text(reasons) +
         "\",\n \"late\": " + late.json() + ",\n \"work\": " + work.json() + "}\n";
}

std::string FlightReport::text(const PacketCounts& packets) const {
  std::string text = "steps    " + std::to_string(steps) + ", left out " +
                     std::to_string(left_out) + ", safe " + std::to_string(safe_steps) + "\n";
  text += "packets  " + std::to_string(packets.taken) + ", refused " +
          std::to_string(packets.all_refused()) + "\n";
  if (late.count() > 0) {
    text +=
        "late     " + late.text() + "; above 1 ms: " + std::to_string(late.above(1'000'000)) + "\n";
  }
  return text + "work     " + work.text() + "\n";
}

void Runner::receive_all() {
  for (int k = 0; k < kMostPackets && link_.receive(seconds_of(nanoseconds())); ++k) {
  }
}

/// Waits for packets and takes them, until the clock shows `until`.
void Runner::wait_and_receive(std::int64_t until) {
  const std::int64_t left = until - nanoseconds();
  if (left > 0) {
    const timespec time{left / kSecond, left % kSecond};
    pollfd ready{link_.descriptor(), POLLIN, 0};
    ppoll(&ready, 1, &time, nullptr);
  }
  receive_all();
}

void Runner::note(const Decision& decision) {
  ++report_.steps;
  report_.safe_steps += decision.mode == Mode::kPolicy ? 0 : 1;
  report_.reasons |= decision.reasons;
  if (decision.mode == last_mode_) return;
  last_mode_ = decision.mode;
  std::printf("%s\n", mode_line(decision).c_str());
  std::fflush(stdout);
}

/// The last command: safe.
void Runner::end() {
  if (pilot_.mode() == Mode::kWaiting) return;
  pilot_.disengage();
  const double now = seconds_of(nanoseconds());
  link_.send(pilot_.step({now, inbox_.age(now), 0.0, 1}), inbox_.stamp(), now);
}

void Runner::run_in_real_time(double seconds, const volatile std::sig_atomic_t& ends) {
  const auto period = static_cast<std::int64_t>(std::llround(1e9 * pilot_.mission().period()));
  const std::int64_t begin = nanoseconds();
  std::int64_t next = begin + period;
  std::uint64_t periods = 1;
  while (ends == 0 && seconds_of(next - begin) <= seconds) {
    while (ends == 0 && nanoseconds() < next) wait_and_receive(next);
    const std::int64_t start = nanoseconds();
    inbox_.engage_if_wanted();
    const double now = seconds_of(start);
    const Decision decision =
        pilot_.step({now, inbox_.age(now), seconds_of(start - next), periods});
    if (decision.mode != Mode::kWaiting) {
      link_.send(decision, inbox_.stamp(), now);
      const std::int64_t sent = nanoseconds();
      report_.late.add(sent - next);
      report_.work.add(sent - start);
      note(decision);
    }
    periods =
        1 + static_cast<std::uint64_t>(std::max<std::int64_t>(0, nanoseconds() - next) / period);
    report_.left_out += decision.mode != Mode::kWaiting ? periods - 1 : 0;
    next += static_cast<std::int64_t>(periods) * period;
  }
  end();
}

/// Steps if a pose has come. @returns whether one has
bool Runner::answer() {
  if (inbox_.take_repeat()) link_.repeat();
  if (inbox_.poses() == answered_) return false;
  answered_ = inbox_.poses();
  inbox_.engage_if_wanted();
  const std::int64_t start = nanoseconds();
  const double stamp = inbox_.stamp();
  const double passed = (stamp - last_stamp_) / pilot_.mission().period();
  const auto periods = static_cast<std::uint64_t>(std::clamp(std::round(passed), 1.0, 1e9));
  last_stamp_ = stamp;
  const Decision decision = pilot_.step({stamp, inbox_.age(stamp), 0.0, periods});
  if (decision.mode == Mode::kWaiting) return true;
  link_.send(decision, stamp, seconds_of(start));
  report_.work.add(nanoseconds() - start);
  note(decision);
  return true;
}

void Runner::run_in_lockstep(double seconds, const volatile std::sig_atomic_t& ends) {
  constexpr std::int64_t kLook = kSecond / 10;  // looks at `ends`
  double first = NAN;
  while (ends == 0 && !(inbox_.stamp() - first >= seconds)) {
    pollfd ready{link_.descriptor(), POLLIN, 0};
    const timespec time{0, kLook};
    ppoll(&ready, 1, &time, nullptr);
    while (link_.receive(seconds_of(nanoseconds()))) {
      if (answer() && std::isnan(first)) first = inbox_.stamp();
    }
  }
  end();
}

}  // namespace skybody::onboard
