// A world of one quadrotor as seen by a plugin, with artificial values for a group of environments.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/env/plugin_setup_tables.h"
#include "core/plugin_host/instance.h"

namespace skybody::test {

/// The folders of tests/plugins.
std::filesystem::path good_plugins();
std::filesystem::path bad_plugins();
std::filesystem::path twin_plugins();
std::filesystem::path hostile_plugins();
/// A new empty folder, removed at the end.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A plugin's declarations in configure(), one line each.
struct Declared {
  std::vector<std::string> lines;
  int buffer_words = 0;
  SkybodyDeclare table();
};

/// The setup of one quadrotor (robot `quad`, body `base`, four rotors, one parameter) and the
/// default values of a plugin's parameters.
class SmallWorld {
 public:
  explicit SmallWorld(const PluginEntry& entry);
  SkybodySetup& setup() { return setup_; }
  /// Creates an instance. @throws as create_instance
  std::shared_ptr<const void> create();
  Declared declared;

 private:
  const PluginEntry& entry_;
  std::vector<ParameterValue> defaults_;
  BoundValues values_;
  std::int32_t team_[1] = {0};
  SkybodyRobotInfo robot_{};
  SkybodyBodyInfo body_{};
  std::vector<SkybodyRotorInfo> rotors_;
  SkybodyEnvParamInfo param_{"robots.quad.controllers.c.gain", "", 1.0, 0.0, 2.0};
  SkybodySetup setup_{};
};

/// Values in lanes for `lanes` environments; each lane has the values of that environment alone.
class Group {
 public:
  /// @param first  the first environment
  Group(std::uint32_t lanes, std::uint32_t first, std::uint32_t active, int state_words,
        int buffer_words);
  /// Calls every step function of `kernels` `steps` times after a reset.
  void run(const SkybodyKernels& kernels, const void* self, int steps);
  /// Bits of all written values of one lane.
  std::vector<std::uint64_t> lane(std::uint32_t l) const;
  /// Bits of one lane that the host keeps between calls.
  /// @param with_output  true: the output is kept too (a sensor's)
  std::vector<std::uint64_t> kept(std::uint32_t l, bool with_output) const;

 private:
  std::vector<std::uint64_t> words(std::uint32_t l,
                                   std::initializer_list<const std::vector<double>*> blocks) const;
  std::vector<double> fill(int words, double scale, int salt) const;
  SkybodyLanes view();

  std::uint32_t lanes_, first_, active_;
  std::vector<std::uint64_t> key_, episode_, step_, physics_step_, state_, end_;
  std::vector<double> bodies_, q_, u_, rotor_speed_, params_, sensors_, action_, command_, buffer_,
      input_, output_, observation_, reward_, robot_reward_, info_, goal_;
};

}  // namespace skybody::test
