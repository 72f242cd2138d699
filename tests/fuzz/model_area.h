// A model file inside a valid scenario.
#pragma once

#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"

namespace skybody::fuzz {

class ModelArea : public Area {
 public:
  /// @param file      the path to which the input is written
  /// @param scenario  YAML that names the file
  ModelArea(const char* file, const char* scenario) : file_(file), scenario_(scenario) {}

  void begin(const std::filesystem::path& folder) override {
    folder_ = folder;
    copy_scenarios(folder);
    write_bytes(folder / "input.yaml", scenario_);
  }

  Answer run(const std::string& input, bool thorough) override {
    write_bytes(folder_ / file_, input);
    LoadOptions options;
    options.scenario = (folder_ / "input.yaml").string();
    return check_flight(options, thorough);
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  const char *file_, *scenario_;
  std::filesystem::path folder_;
};

}  // namespace skybody::fuzz
