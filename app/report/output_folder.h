// Output folder of a flight. Files are written under a temporary name first, so that none is
// incomplete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace skybody {

/// The folder of one run's flight.h5 and pictures. Files that are not committed are removed.
class OutputFolder {
 public:
  /// Uses `out`, which may exist: its flight.h5 is replaced. If `out` is empty, creates
  /// flights/NAME-SEED, or flights/NAME-SEED-2, -3, ... if that exists.
  /// @throws Error with the folder and the reason
  OutputFolder(const std::filesystem::path& out, const std::string& scenario, std::uint64_t seed);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path log() const { return path_ / "flight.h5"; }
  /// Path of the log until it is committed.
  const std::filesystem::path& partial_log() const { return partial_log_; }

  /// Moves the finished log to its place and removes pictures of the previous one.
  void commit();

 private:
  void remove_old_pictures() const;

  std::filesystem::path path_, partial_log_;
  bool created_ = false;
};

}  // namespace skybody
