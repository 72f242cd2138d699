// Reading and writing whole files.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace skybody::fuzz {

inline std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Replaces the file.
inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

/// Copies the shipped scenarios and models, as into a user's own folder.
inline void copy_scenarios(const std::filesystem::path& folder) {
  std::filesystem::copy(
      std::filesystem::path(SKYBODY_SOURCE_DIR) / "scenarios", folder,
      std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
}

/// Path of a file of this project.
inline std::string shipped(const std::string& name) {
  return read_bytes(std::filesystem::path(SKYBODY_SOURCE_DIR) / "scenarios" / name);
}

}  // namespace skybody::fuzz
