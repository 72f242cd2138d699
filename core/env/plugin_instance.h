// A configured plugin as the engine uses it: functions, what it declared, where its state lies.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/env/column_type.h"
#include "core/env/group_rows.h"
#include "core/model/parameter_spec.h"
#include "core/physics/world/world.h"
#include "plugins/api/abi.h"
#include "plugins/api/image.h"

namespace skybody {

/// A named part of a sensor's output or of an observation.
struct Channel {
  std::string name;
  std::string unit;
  int count = 0;
  double low = 0.0;  ///< bounds of the values, may be infinite
  double high = 0.0;
  int robot = -1;           ///< whose own observation it belongs to, -1: every robot's
  bool privileged = false;  ///< of an observation: for a critic only
  ColumnType type = ColumnType::kFloat32;
  std::vector<int> shape = {};  ///< of an image; empty: a vector, whose values lie in lanes
  std::string doc = {};         ///< what the values are; empty: unsaid

  bool is_image() const { return !shape.empty(); }
  int bytes() const { return count * info_of(type).bytes; }
};

/// Number of values of some channels, without images.
inline int value_count(const std::vector<Channel>& channels) {
  int sum = 0;
  for (const Channel& c : channels) sum += c.is_image() ? 0 : c.count;
  return sum;
}

/// Bytes of the images among some channels; each begins where image_room() says.
inline int image_bytes(const std::vector<Channel>& channels) {
  std::size_t sum = 0;
  for (const Channel& c : channels) {
    if (c.is_image()) sum += plugin_detail::image_room(static_cast<std::size_t>(c.bytes()));
  }
  return static_cast<int>(sum);
}

/// What a task's goal() is about.
struct Goal {
  int robot = 0;
  int body = 0;                       ///< world body index
  Vec3<double> point{0.0, 0.0, 0.0};  ///< of the body, in its frame: what is brought there [m]
};

/// One body, and what it may touch.
struct ContactPair {
  int body = 0;  ///< world body index
  SkybodyPartner partner = SKYBODY_GROUND;
  int other = 0;  ///< world body index, or the place among the obstacles
};

/// What a controller gives.
struct PluginOutput {
  int robot = 0;    ///< that it is for
  int signal = -1;  ///< SkybodySignal
  int count = 0;
};

/// Values beside the observation that lie in a plugin's buffer.
struct Report {
  Channel info;
  int word = 0;  ///< of the buffer
};

/// A plugin instance. Immutable once the CompiledScenario is built.
struct PluginInstance {
  SkybodyKind kind = SKYBODY_CONTROLLER;
  std::string name;       ///< instance, as in paths
  std::string plugin;     ///< the plugin's own name
  std::vector<int> team;  ///< controllers: the robots that they serve, in order
  SourceLocation mark;    ///< where the scenario names it
  std::string file;       ///< its library; empty: a test's own

  std::shared_ptr<const void> self;  ///< keeps the library loaded
  SkybodyKernels kernels{};          ///< of the chosen instruction set
  SkybodyKernels dual_kernels{};     ///< on dual numbers; null: it is not smooth

  // Declared in configure():
  int inputs = 0;                     ///< calls of input()
  int input_signal = -1;              ///< SkybodySignal, controllers only
  std::vector<PluginOutput> outputs;  ///< one; the last one of a chain may have several
  std::vector<double> low, high;      ///< of the input: what actions -1 and +1 mean
  bool passes_on = false;             ///< they are those of the controller behind it
  std::vector<WrenchSite> sites;
  std::vector<JointDrive> joints;
  std::array<bool, SKYBODY_HELD_COUNT> holds{};  ///< effects: what apply() fills
  bool is_steady = false;                        ///< effects: it follows from EnvParams alone
  std::vector<Channel> channels;
  std::vector<ValueCopy> repeats;  ///< tasks: values of the observation that are copies
  std::vector<Channel> infos;      ///< tasks: values beside the observation
  std::vector<Goal> goals;
  bool robot_rewards = false;  ///< tasks: evaluate() gives each robot a reward of its own
  std::vector<int> writes;     ///< EnvParams that a randomizer or the task writes
  std::vector<int> starts;     ///< places of InitialStates that these belong to
  bool draws_in_time = false;  ///< randomizers: is called before every physics step, too
  std::vector<int> reads;      ///< sensors' values that it looks at, the first of each channel
  std::vector<Report> reports;
  std::vector<Channel> actions;  ///< tasks: parts of the action; none: the chains' commands
  bool interpolates = false;     ///< tasks: commands change over the physics steps of an action
  int period = 0;                ///< physics steps between calls, 0: its kind's own
  int scratch = 0;               ///< doubles of memory for a call
  int memo = 0;                  ///< doubles of memory that lasts and is no state
  bool needs_bodies_before = false;
  bool needs_contacts = false;
  std::vector<ContactPair> contact_pairs;
  std::vector<int> joint_reactions;  ///< world body indices
  /// Sensors: called only where the output is read before the next call. Declared, and then no
  /// plugin reads it between the physics steps of an action.
  bool is_only_when_read = false;

  // Where things lie, within the blocks plugin_state and sensors:
  int state = 0, state_words = 0;
  int buffer = 0, buffer_words = 0;
  int first_memo = 0;  ///< within StateGroup::memo()
  int output = 0;      ///< sensors: first word of the output
  /// State words: what it gave last, of a controller that others follow and that is not
  /// called in every physics step; and, per held input, what this effect adds.
  Block last_output;
  std::array<Block, SKYBODY_HELD_COUNT> held;
  int first_contact_pair = 0, first_joint_reaction = 0;  ///< among those of all plugins
  int images = 0;  ///< sensors: first byte within an environment's image memory

  int input_count() const { return static_cast<int>(low.size()); }
  int channel_count() const { return value_count(channels); }
  int output_count() const {
    int sum = 0;
    for (const PluginOutput& given : outputs) sum += given.count;
    return sum;
  }
  bool serves(int robot) const { return std::find(team.begin(), team.end(), robot) != team.end(); }
  bool gives(int signal) const {
    return std::any_of(outputs.begin(), outputs.end(),
                       [signal](const PluginOutput& o) { return o.signal == signal; });
  }
};

/// Makes instances: the plugin host, or a test's own. Called once per use, in the order
/// sensors, controllers, effects, randomizers, task.
class PluginFactory {
 public:
  virtual ~PluginFactory() = default;

  struct Made {
    std::shared_ptr<const void> self;
    SkybodyKernels kernels{};
    int state_words = 0;
    std::string file = {};          ///< its library; empty: a test's own
    SkybodyKernels dual_kernels{};  ///< on dual numbers; null: it is not smooth
  };
  /// @throws Error with the plugin's own text if it refuses
  virtual Made make(SkybodyKind kind, const std::string& plugin, const SkybodySetup& setup,
                    const SkybodyDeclare& declare) = 0;
  /// The parameters that a plugin declares, in order. Live as long as the factory.
  virtual const std::vector<ParameterSpec>& parameters(SkybodyKind kind,
                                                       const std::string& plugin) = 0;
};

}  // namespace skybody
