#include "core/io/files/missing_file.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/base/system/suggestion.h"
#include "core/io/files/file.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// Number of a folder's entries that are searched for similar names.
constexpr std::size_t kMostEntries = 2000;
/// Number of names of similar length that are compared.
constexpr std::size_t kMostCompared = 200;

/// Names in a folder by the texts to compare: names of subfolders, or stems of files with about the
/// extension of `wanted`.
std::map<std::string, std::string> names_in(const fs::path& folder, bool folders,
                                            const fs::path& wanted) {
  const auto key_of = [&](const fs::path& name) { return (folders ? name : name.stem()).string(); };
  const std::size_t size = key_of(wanted).size();
  std::map<std::string, std::string> names;
  std::error_code problem;
  fs::directory_iterator entry(folder, problem), end;
  for (std::size_t k = 0; !problem && entry != end && k < kMostEntries; ++k) {
    std::error_code ignored;
    const fs::path name = entry->path().filename();
    const std::string key = key_of(name);
    const bool is_wanted =
        folders ? entry->is_directory(ignored)
                : !closest(wanted.extension().string(), {name.extension().string()}).empty();
    // closest() allows an edit for three letters, and one in any case.
    const std::size_t longer = std::max(size, key.size()), shorter = std::min(size, key.size());
    if (is_wanted && longer - shorter <= 1 + size / 3) names[key] = name.string();
    entry.increment(problem);
  }
  while (names.size() > kMostCompared) names.erase(std::prev(names.end()));
  return names;
}

/// The name in a folder closest to `wanted`, or empty.
std::string closest_in(const fs::path& folder, bool folders, const fs::path& wanted) {
  const std::map<std::string, std::string> names = names_in(folder, folders, wanted);
  std::vector<std::string> keys;
  for (const auto& [key, name] : names) keys.push_back(key);
  const std::string key = closest((folders ? wanted : wanted.stem()).string(), keys);
  return key.empty() ? "" : names.at(key);
}

}  // namespace

std::string similar_file(const std::string& file) {
  const fs::path path = file;
  fs::path there;
  std::error_code ignored;
  for (auto part = path.begin(); part != path.end(); ++part) {
    fs::path next = there / *part;
    if (!fs::exists(next, ignored)) {
      const bool is_folder = std::next(part) != path.end();
      const std::string name = closest_in(there.empty() ? "." : there, is_folder, *part);
      if (name.empty()) return "";
      next = there / name;
    }
    there = std::move(next);
  }
  return is_file(there.string()) ? there.string() : "";
}

std::string missing_file_hint(const std::string& file, const std::string& remedy,
                              const std::vector<std::string>& names) {
  std::string meant = similar_file(file);
  if (meant.empty()) meant = closest(fs::path(file).stem().string(), names);
  return meant.empty() ? remedy : "did you mean `" + meant + "`?";
}

std::string missing_file(const std::string& file, const std::string& remedy,
                         const std::vector<std::string>& names) {
  std::error_code problem;
  if (file.find('\0') != file.npos || fs::exists(file, problem) || problem) return "";
  return "the file `" + file + "` does not exist; " + missing_file_hint(file, remedy, names);
}

}  // namespace skybody
