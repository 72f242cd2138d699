// Shared libraries: a changed file is refused, or used, and the process that looks at it stands.
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

class PluginArea : public Area {
 public:
  PluginArea() {
    for (const char* name : {"srt", "rotor_speed"}) {
      material_.seeds.push_back(read_bytes(plugin_file(name)));
    }
    material_.words = {
        "\x7f"
        "ELF",
        "skybody_plugin_library",
        "libc.so.6",
        "GNU",
        ".init",
        ".so"};
  }

  void begin(const fs::path& folder) override { folder_ = folder; }

  /// A name of its own each time: the dynamic linker knows what is open by its file.
  Answer run(const std::string& input, bool) override {
    const fs::path file = folder_ / ("input_" + std::to_string(count_++) + ".so");
    write_bytes(file, input);
    const std::string failure = plugin_failure(folder_);
    fs::remove(file);
    if (failure.empty()) return Answer::kAccepted;
    check_message(failure);
    return Answer::kRefused;
  }

 private:
  fs::path folder_;
  int count_ = 0;
};

}  // namespace

std::unique_ptr<Area> make_plugin_area(const AreaOptions&) {
  return std::make_unique<PluginArea>();
}

}  // namespace skybody::fuzz
