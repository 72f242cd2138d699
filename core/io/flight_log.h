// The flight log: an HDF5 file with everything that happened in some episodes of one environment.
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

/// What holds for the whole flight. The columns fix the width of every row.
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
  std::vector<std::string> references;  ///< kinds of path that robots follow
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
  std::uint8_t touching = 0;  ///< 1: something touches the ground, an obstacle or a robot, 0: no
  std::span<const double> sensors;
  std::span<const float> info;   ///< as the task and other plugins report
  std::span<const double> goal;  ///< 4 per goal: position (W) [m], yaw [rad]
};

/// Writes the file while the flight goes on: rows are kept until a chunk is full, then compressed
/// and written, so that memory does not grow with the flight.
class FlightLog {
 public:
  /// Creates the file, replacing one that exists.
  /// @throws Error with the file and the reason, here and in all members
  FlightLog(const std::filesystem::path& file, const FlightLogHeader& header);
  /// Closes the file as it is; call close() to hear of errors.
  ~FlightLog();
  FlightLog(const FlightLog&) = delete;
  FlightLog& operator=(const FlightLog&) = delete;

  /// Ends the episode before, if any, and begins the next. @param params  drawn values
  void begin_episode(std::span<const double> params);
  /// Appends a row to the episode.
  void add(const FlightLogRow& row);
  /// Notes what happened at the row added last: "reset", "terminated", ...
  void event(const std::string& text);
  /// Writes what is left and closes the file.
  void close();

 private:
  struct File;
  std::unique_ptr<File> file_;
};

/// For programs whose only HDF5 files are flight logs; to be called before the first. HDF5's own
/// clean-up at exit would try again, and complain, where a log could not be closed on a full disk.
void skip_hdf5_cleanup_at_exit();

}  // namespace skybody
