// Shared libraries: a changed file is either refused or used, and must never end the host process.
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPlugin = "srt";

class PluginArea : public Area {
 public:
  PluginArea() {
    material_.seeds.push_back(read_bytes(plugin_file(kPlugin)));
    material_.words = {("\x7f"
                        "ELF"),
                       "skybody_plugin_library",
                       "libc.so.6",
                       "GNU",
                       ".init",
                       ".so"};
  }

  void begin(const fs::path& folder) override { folder_ = folder; }

  /// Under the plugin's own name, which the file declares.
  Answer run(const std::string& input, bool) override {
    write_bytes(folder_ / (std::string(kPlugin) + ".so"), input);
    const std::string failure = plugin_failure(folder_);
    if (failure.empty()) return Answer::kAccepted;
    check_message(failure);
    return Answer::kRefused;
  }

 private:
  fs::path folder_;
};

}  // namespace

std::unique_ptr<Area> make_plugin_area(const AreaOptions&) {
  return std::make_unique<PluginArea>();
}

}  // namespace skybody::fuzz
