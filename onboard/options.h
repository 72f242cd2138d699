// The command line of `skybody onboard`.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace skybody::onboard {

/// Values of the options; help_text() has their meanings.
struct Options {
  std::string mission;  ///< file
  bool about = false, help = false;
  std::string listen = "127.0.0.1:14650";  ///< HOST:PORT
  bool mavlink = false, lockstep = false, waits = false, locks_memory = false;
  std::optional<std::string> peer;                    ///< HOST:PORT
  std::optional<std::string> json, gates, reference;  ///< files
  double seconds = 1e12;                              ///< length of the flight [s]
  int fifo = 0;  ///< priority of SCHED_FIFO; 0: the usual scheduler
  std::vector<std::pair<std::string, std::vector<double>>> params, limits;  ///< name, values
};

/// @throws Error for an unknown option or a bad value
Options parse_options(const std::vector<std::string>& arguments);
/// The text of --help.
const char* help_text();

}  // namespace skybody::onboard
