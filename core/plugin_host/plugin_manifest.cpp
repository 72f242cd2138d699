#include "core/plugin_host/plugin_manifest.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "core/base/system/printable.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// A sidecar has a few names. A longer file is not a sidecar and is not read any further.
constexpr std::size_t kLongestSidecar = 65536;

/// @returns at most one byte more than a sidecar may have
std::string beginning_of(const fs::path& sidecar) {
  std::string text(kLongestSidecar + 1, '\0');
  std::ifstream in(sidecar, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    line.erase(std::min(line.find('#'), line.size()));
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos) continue;
    names.push_back(line.substr(first, line.find_last_not_of(" \t\r") + 1 - first));
  }
  return names;
}

void read_sidecar(const fs::path& sidecar, PluginManifest& found) {
  found.sidecar = sidecar;
  const std::string text = beginning_of(sidecar);
  found.names = names_in(text);
  if (access(sidecar.c_str(), R_OK) != 0) {
    found.problem = "its list of plugins " + sidecar.string() +
                    " cannot be read: " + std::strerror(errno) + "; make it readable or remove it";
  } else if (text.size() > kLongestSidecar) {
    found.problem = "its list of plugins " + sidecar.string() + " has more than " +
                    std::to_string(kLongestSidecar) +
                    " bytes, which no list has; write one name a line";
  }
  const auto is_no_name = [](const std::string& name) {
    return name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos;
  };
  if (found.problem.empty() && std::any_of(found.names.begin(), found.names.end(), is_no_name)) {
    found.problem = "its list of plugins " + sidecar.string() +
                    " has lines that are no plugin's name; write one name a line, in lower-case "
                    "letters, digits and underscores";
    found.names.clear();
  }
  if (!found.problem.empty()) found.names.push_back(found.file.stem().string());
}

PluginManifest plugin_manifest(const fs::path& file) {
  PluginManifest found{file, {}, {}, {}};
  fs::path sidecar = file;
  sidecar.replace_extension(".plugins");
  std::error_code ignored;
  if (fs::is_regular_file(sidecar, ignored)) {
    read_sidecar(sidecar, found);
  } else {
    found.names.push_back(file.stem().string());
  }
  return found;
}

}  // namespace

bool PluginManifest::promises(std::string_view name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string folder_problem(const fs::path& folder) {
  std::error_code failed;
  const fs::directory_iterator names(folder, failed);
  if (!failed || failed == std::errc::no_such_file_or_directory ||
      failed == std::errc::not_a_directory) {
    return {};
  }
  return printable(folder.string()) +
         ": this folder of plugins cannot be read: " + failed.message() +
         "; make it readable or leave it out";
}

std::vector<PluginManifest> plugin_manifests(const fs::path& folder) {
  std::vector<PluginManifest> files;
  std::error_code failed;
  for (fs::directory_iterator it(folder, failed), end; !failed && it != end; it.increment(failed)) {
    std::error_code ignored;
    if (it->path().extension() != ".so" || it->is_directory(ignored) || !it->exists(ignored)) {
      continue;
    }
    files.push_back(plugin_manifest(it->path()));
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.file < b.file; });
  return files;
}

}  // namespace skybody
