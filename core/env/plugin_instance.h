// A configured plugin: its functions, its declarations, and the places of its state.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/env/column_type.h"
#include "core/env/row_conversion.h"
#include "core/model/parameter_spec.h"
#include "core/physics/world/world.h"
#include "core/plugin_abi/abi.h"
#include "core/plugin_abi/image.h"

namespace skybody {

/// A named part of a sensor's output or of an observation.
struct Channel {
  std::string name;
  std::string unit;
  int count = 0;
  double low = 0.0;  ///< bounds of the values, may be infinite
  double high = 0.0;
  int robot = -1;           ///< robot whose own observation contains it, -1: every robot's
  bool privileged = false;  ///< in an observation: for the critic only
  ColumnType type = ColumnType::kFloat32;
  std::vector<int> shape = {};  ///< of an image; empty: a vector, whose values are in lanes
  std::string doc = {};         ///< meaning of the values; may be empty

  bool is_image() const { return !shape.empty(); }
  int bytes() const { return count * info_of(type).bytes; }
};

/// Number of values of some channels, without images.
inline int value_count(const std::vector<Channel>& channels) {
  int sum = 0;
  for (const Channel& c : channels) sum += c.is_image() ? 0 : c.count;
  return sum;
}

/// Bytes of the images among some channels, each rounded up by image_room().
inline int image_bytes(const std::vector<Channel>& channels) {
  std::size_t sum = 0;
  for (const Channel& c : channels) {
    if (c.is_image()) sum += plugin_detail::image_room(static_cast<std::size_t>(c.bytes()));
  }
  return static_cast<int>(sum);
}

/// The body point for which a task's goal() gives a target.
struct Goal {
  int robot = 0;
  int body = 0;                       ///< world body index
  Vec3<double> point{0.0, 0.0, 0.0};  ///< brought to the goal, body frame [m]
};

/// A body and its contact partner.
struct ContactPair {
  int body = 0;  ///< world body index
  SkybodyPartner partner = SKYBODY_GROUND;
  int other = 0;  ///< world body index, or the index of an obstacle
};

/// An output of a controller.
struct PluginOutput {
  int robot = 0;    ///< the robot that receives it
  int signal = -1;  ///< SkybodySignal
  int count = 0;
};

/// Values beside the observation, stored in a plugin's buffer.
struct Report {
  Channel info;
  int word = 0;  ///< first word of the buffer
};

/// Values of an effect that sensors may read.
struct Offer {
  std::string name;
  int robot = 0, count = 0;
  int word = 0;  ///< first word of the buffer
};

/// Values of an effect that a sensor reads.
struct OfferRequest {
  std::string name;
  int robot = 0, count = 0;
};

/// A plugin's places within an environment's words and within scratch of all plugins.
struct PluginMemory {
  int state = 0, state_words = 0;    ///< within the block plugin_state
  int buffer = 0, buffer_words = 0;  ///< as above
  int first_memo = 0, memo = 0;      ///< doubles within StateGroup::memo(): not part of the state
  int scratch = 0;                   ///< doubles for a call, of each lane
  int scratch_block = 0;             ///< doubles for a call
  /// First among those of all plugins.
  int first_contact_pair = 0, first_joint_reaction = 0, first_offered = 0;
};

/// Declarations of a controller.
struct ControllerPart {
  std::vector<int> team;              ///< the robots that it serves, in order
  int input_calls = 0;                ///< number of calls of input()
  int input_signal = -1;              ///< SkybodySignal
  std::vector<PluginOutput> outputs;  ///< one; the last controller of a chain may have several
  std::vector<double> low, high;      ///< range of the input: the values of actions -1 and +1
  bool passes_on = false;             ///< its range is that of the next controller
  std::vector<WrenchSite> sites;
  std::vector<JointDrive> joints;
  /// State words of the last output, if others follow and it is not called in every physics step.
  Block last_output;

  int input_count() const { return static_cast<int>(low.size()); }
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

/// Declarations of a sensor.
struct SensorPart {
  int output = 0;  ///< first word of the output, within the block sensors
  int images = 0;  ///< first byte within an environment's image memory
  /// Called only if the output is read before the next call. Set if it is declared and no plugin
  /// reads the sensor between the physics steps of an action.
  bool is_only_when_read = false;
  bool has_observed_image = false;  ///< an image of it is a column of the observation
  std::vector<OfferRequest> requests;

  /// Number of values that it reads from effects.
  int requested() const {
    int sum = 0;
    for (const OfferRequest& r : requests) sum += r.count;
    return sum;
  }
};

/// Declarations of an effect.
struct EffectPart {
  std::array<bool, SKYBODY_HELD_COUNT> holds{};  ///< the inputs that apply() writes
  std::array<Block, SKYBODY_HELD_COUNT> held;    ///< state words of its contribution to each
  bool is_steady = false;                        ///< the output depends on EnvParams only
  std::vector<Offer> offers;                     ///< values for sensors
};

/// Declarations of a randomizer.
struct RandomizerPart {
  std::vector<int> starts;     ///< places of InitialStates that its EnvParams belong to
  bool draws_in_time = false;  ///< also called before every physics step
};

/// Declarations of a task.
struct TaskPart {
  std::vector<ValueCopy> repeats;  ///< values of the observation that are copies
  std::vector<Channel> infos;      ///< values beside the observation
  std::vector<Channel> actions;    ///< parts of the action; none: the chains' commands
  std::vector<Goal> goals;
  bool robot_rewards = false;  ///< evaluate() gives each robot its own reward
  bool interpolates = false;   ///< commands change over the steps of an action
};

/// A plugin instance. Immutable once the ScenarioModel is built. Besides the common members, only
/// the part of its kind has a meaning.
struct PluginInstance {
  SkybodyKind kind = SKYBODY_CONTROLLER;
  std::string name;     ///< instance name, as in paths
  std::string plugin;   ///< the plugin's own name
  SourceLocation mark;  ///< the scenario's line that names it
  std::string file;     ///< its library; empty: an instance made by a test

  std::shared_ptr<const void> self;  ///< keeps the library loaded
  SkybodyKernels kernels{};          ///< for the chosen instruction set
  SkybodyKernels dual_kernels{};     ///< for dual numbers; null: the plugin is not smooth

  // Declared in configure():
  int period = 0;                 ///< physics steps between calls, 0: the default of its kind
  std::vector<Channel> channels;  ///< sensors: outputs; tasks: the observation
  std::vector<Report> reports;
  std::vector<int> reads;   ///< sensor values that it reads, the first of each channel
  std::vector<int> writes;  ///< EnvParams that a randomizer or the task writes
  bool needs_bodies_before = false;
  bool needs_contacts = false;
  std::vector<ContactPair> contact_pairs;
  std::vector<int> joint_reactions;  ///< world body indices

  ControllerPart controller;
  SensorPart sensor;
  EffectPart effect;
  RandomizerPart randomizer;
  TaskPart task;
  PluginMemory memory;

  int channel_count() const { return value_count(channels); }
};

/// Makes instances: implemented by the plugin host, or by a test. Called once per use, in the order
/// sensors, controllers, effects, randomizers, task.
class PluginFactory {
 public:
  virtual ~PluginFactory() = default;

  struct Made {
    std::shared_ptr<const void> self;
    SkybodyKernels kernels{};
    int state_words = 0;
    std::string file = {};          ///< its library; empty: an instance made by a test
    SkybodyKernels dual_kernels{};  ///< for dual numbers; null: the plugin is not smooth
  };
  /// @throws Error with the plugin's own text if it refuses
  virtual Made make(SkybodyKind kind, const std::string& plugin, const SkybodySetup& setup,
                    const SkybodyDeclare& declare) = 0;
  /// The parameters that a plugin declares, in order. They live as long as the factory.
  virtual const std::vector<ParameterSpec>& parameters(SkybodyKind kind,
                                                       const std::string& plugin) = 0;
};

}  // namespace skybody
