// The loop of a flight: in real time, or in lockstep with a simulator.
#pragma once

#include <csignal>
#include <cstdint>
#include <string>

#include "onboard/inbox.h"
#include "onboard/latency.h"
#include "onboard/link.h"
#include "onboard/pilot.h"

namespace skybody::onboard {

/// Results of a flight.
struct FlightReport {
  LatencyHistogram late;  ///< from the time of a step to the moment when its command is sent
  LatencyHistogram work;  ///< of that: from the step's beginning
  std::uint64_t steps = 0, left_out = 0;  ///< left_out: periods in which no step could begin
  std::uint64_t safe_steps = 0;
  std::uint32_t reasons = 0;  ///< all that occurred
  /// An object of JSON: counts, reasons, histograms.
  std::string json(const PacketCounts& packets) const;
  /// Lines for a terminal.
  std::string text(const PacketCounts& packets) const;
};

class Runner {
 public:
  Runner(Pilot& pilot, Inbox& inbox, Link& link) : pilot_(pilot), inbox_(inbox), link_(link) {}

  /// A step each period of the mission by the monotonic clock, until `seconds` [s] are over or
  /// `ends` is not 0.
  void run_in_real_time(double seconds, const volatile std::sig_atomic_t& ends);
  /// A step for each pose of the base, with the stamps as clock.
  /// @param seconds  by the stamps, from the first one [s]
  void run_in_lockstep(double seconds, const volatile std::sig_atomic_t& ends);
  const FlightReport& report() const { return report_; }

 private:
  void wait_and_receive(std::int64_t until);
  void receive_all();
  void note(const Decision& decision);
  void end();
  bool answer();

  Pilot& pilot_;
  Inbox& inbox_;
  Link& link_;
  FlightReport report_;
  Mode last_mode_ = Mode::kWaiting;
  std::uint64_t answered_ = 0;  ///< poses of the base so far, in lockstep
  double last_stamp_ = 0.0;
};

}  // namespace skybody::onboard
