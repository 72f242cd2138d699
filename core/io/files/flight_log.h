// The flight log: an HDF5 file with the complete record of some episodes of one environment.
// docs/flight-log.md describes the file for readers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skybody {

/// One value of a row: its name, such as `quad.base.z`, and its unit.
struct LogColumn {
  std::string name;
  std::string unit;
};

/// Data of the whole flight. The columns define the width of every row.
struct FlightLogHeader {
  std::string scenario_name;
  std::string scenario_file;  ///< absolute
  std::string scenario_text;  ///< merged YAML
  std::uint64_t scenario_hash = 0;
  std::uint64_t seed = 0;
  std::string policy;
  double dt = 0.0;                                            ///< physics step [s]
  int action_repeat = 1;                                      ///< K
  std::vector<std::pair<std::string, std::string>> versions;  ///< component, version

  std::vector<std::string> bodies;      ///< `robot.body`
  std::vector<std::string> goals;       ///< the body of each goal, as in `bodies`
  std::vector<std::string> references;  ///< kinds of path that the robots follow
  std::vector<LogColumn> q, u, rotors, action, command, observation, sensors, info;
  std::vector<LogColumn> params;       ///< randomizable values, by path
  std::vector<double> nominal_params;  ///< in the order of `params`
};

/// The state after a reset or a step, with the action and command that led to it.
struct FlightLogRow {
  double time = 0.0;  ///< since the reset [s]
  std::span<const double>
      bodies;  ///< 13 per body: position, quaternion, velocity, angular velocity
  std::span<const double> q, u;
  std::span<const double> rotor_speed, rotor_command;  ///< [rad/s]
  std::span<const double> action, command;
  std::span<const float> observation;  ///< the privileged values last
  float reward = 0.0f;
  std::uint64_t status = 0;   ///< EpisodeStatus bits
  std::uint8_t touching = 0;  ///< 1: a body touches the ground, an obstacle or a robot; 0: none
  std::span<const double> sensors;
  std::span<const float> info;   ///< reported by the task and other plugins
  std::span<const double> goal;  ///< 4 per goal: position (W) [m], yaw [rad]
};

/// Writes the file during the flight. Rows are buffered until a chunk is full, then compressed and
/// written: memory use does not grow with the flight.
class FlightLog {
 public:
  /// Creates the file, or replaces an existing one.
  /// @throws Error with the file and the reason, here and in all members
  FlightLog(const std::filesystem::path& file, const FlightLogHeader& header);
  /// Closes the file and ignores errors; call close() to get them.
  ~FlightLog();
  FlightLog(const FlightLog&) = delete;
  FlightLog& operator=(const FlightLog&) = delete;

  /// Ends the current episode, if any, and begins the next. @param params  drawn values
  void begin_episode(std::span<const double> params);
  /// Appends a row to the episode.
  void add(const FlightLogRow& row);
  /// Adds an event at the last row: "reset", "terminated", ...
  void event(const std::string& text);
  /// Writes the remaining rows and closes the file.
  void close();

 private:
  struct File;
  std::unique_ptr<File> file_;
};

/// For programs whose only HDF5 files are flight logs; call it before the first. If a log could not
/// be closed on a full disk, HDF5's own clean-up at exit would fail again and print errors.
void skip_hdf5_cleanup_at_exit();

}  // namespace skybody
