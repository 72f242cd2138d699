// Reads flight logs with HDF5's C API, as any other program would.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <string>
#include <vector>

namespace skybody::test {

class FlightFile {
 public:
  /// Throws std::runtime_error if the file is not an HDF5 file.
  explicit FlightFile(const std::filesystem::path& path);
  ~FlightFile();
  FlightFile(const FlightFile&) = delete;
  FlightFile& operator=(const FlightFile&) = delete;

  bool has(const std::string& object) const;
  /// Names within a group, sorted.
  std::vector<std::string> names(const std::string& group) const;
  std::vector<std::size_t> shape(const std::string& dataset) const;
  std::vector<double> values(const std::string& dataset) const;
  std::vector<std::string> texts(const std::string& dataset) const;
  std::string text_attribute(const std::string& object, const char* name) const;
  /// An attribute that is a list of texts, such as `columns`.
  std::vector<std::string> texts_attribute(const std::string& object, const char* name) const;
  double number_attribute(const std::string& object, const char* name) const;
  /// The texts of an episode's events.
  std::vector<std::string> events(const std::string& episode) const;

 private:
  hid_t file_;
};

}  // namespace skybody::test
