// Where a flight's files go: written under another name first, so that nothing is half-written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace skybody {

/// The folder of one run's flight.h5 and pictures. What is not committed is removed again.
class OutputFolder {
 public:
  /// `out`, which may exist: its flight.h5 is replaced. Where `out` is empty, a new folder
  /// flights/NAME-SEED, or flights/NAME-SEED-2, -3, ... where that exists.
  /// @throws Error with the folder and the reason
  OutputFolder(const std::filesystem::path& out, const std::string& scenario, std::uint64_t seed);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path log() const { return path_ / "flight.h5"; }
  /// Where the log is written before it is committed.
  const std::filesystem::path& partial_log() const { return partial_log_; }

  /// Puts the finished log in its place and removes pictures of the one before.
  void commit();

 private:
  void remove_old_pictures() const;

  std::filesystem::path path_, partial_log_;
  bool created_ = false;
};

}  // namespace skybody
