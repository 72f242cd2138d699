#include "app/onnx_policy.h"

#include <cstdlib>
#include <vector>

#include "app/python_tool.h"
#include "core/base/system/error.h"
#include "core/policy/network_policy.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr PythonTool kConverter{"skybody.exports", "h5 ", "onnx"};
constexpr std::string_view kEnding = ".onnx", kError = "error: ";

/// A folder that is removed at the end of its scope.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "skybody-XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) throw Error("no temporary folder can be made: " + path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  fs::path path() const { return path_; }

 private:
  std::string path_;
};

/// The folders that are searched for plugins before the default ones.
std::vector<fs::path> plugin_folders(const LoadOptions& options) {
  std::vector<fs::path> folders = options.plugin_path;
  if (!options.trust_scenario) return folders;
  const fs::path own = fs::absolute(scenario_file(options.scenario)).parent_path();
  std::error_code ignored;
  for (const fs::path& folder : {own, own / "plugins"}) {
    if (fs::is_directory(folder, ignored)) folders.push_back(folder);
  }
  return folders;
}

}  // namespace

bool is_onnx(const std::string& policy) {
  return policy.size() > kEnding.size() && policy.ends_with(kEnding);
}

std::unique_ptr<Policy> open_onnx_policy(const std::string& file, const LoadOptions& options,
                                         const fs::path& map) {
  const TemporaryFolder folder;
  const fs::path converted = folder.path() / "policy.h5";
  std::vector<std::string> words{
      file, "--to", "h5", "--scenario", options.scenario, "-o", converted.string()};
  for (const std::string& override : options.overrides)
    words.insert(words.end(), {"--set", override});
  for (const fs::path& path : plugin_folders(options)) {
    words.insert(words.end(), {"--plugin-path", path.string()});
  }
  if (!map.empty()) words.insert(words.end(), {"--map", map.string()});
  const MadeFiles made = make_files(kConverter, words);
  if (!made.failure.empty()) {
    const bool is_marked = made.failure.starts_with(kError);
    throw Error(is_marked ? made.failure.substr(kError.size()) : made.failure);
  }
  return std::make_unique<NetworkPolicy>(converted);
}

}  // namespace skybody
