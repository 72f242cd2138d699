#include "plugins/host/promises.h"

#include <algorithm>
#include <fstream>

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// A sidecar has a few names; what is longer is something else and read no further.
constexpr std::streamsize kLongestSidecar = 65536;

std::vector<std::string> read_sidecar(const fs::path& sidecar) {
  std::string text(static_cast<std::size_t>(kLongestSidecar), '\0');
  std::ifstream in(sidecar, std::ios::binary);
  in.read(text.data(), kLongestSidecar);
  text.resize(static_cast<std::size_t>(in.gcount()));
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

PromisingFile promising_file(const fs::path& file) {
  PromisingFile found{file, {}, {}};
  fs::path sidecar = file;
  sidecar.replace_extension(".plugins");
  std::error_code ignored;
  if (fs::is_regular_file(sidecar, ignored)) {
    found.names = read_sidecar(sidecar);
    found.sidecar = sidecar;
  } else {
    found.names.push_back(file.stem().string());
  }
  return found;
}

}  // namespace

bool PromisingFile::promises(std::string_view name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<PromisingFile> promising_files(const fs::path& folder) {
  std::vector<PromisingFile> files;
  std::error_code failed;
  for (fs::directory_iterator it(folder, failed), end; !failed && it != end; it.increment(failed)) {
    std::error_code ignored;
    if (it->path().extension() != ".so" || it->is_directory(ignored) || !it->exists(ignored)) {
      continue;
    }
    files.push_back(promising_file(it->path()));
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.file < b.file; });
  return files;
}

}  // namespace skybody
