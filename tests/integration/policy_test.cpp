// `skybody run --policy PATH` and NetworkPolicy: trained networks as Python writes them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "core/base/hash.h"
#include "core/io/flight_log_hdf5.h"
#include "core/io/policy_file.h"
#include "core/io/policy_seal.h"
#include "core/model/marked_error.h"
#include "core/policy/network_policy.h"
#include "core/simulation/simulation.h"
#include "tests/integration/flips.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A policy file in the making; tests change what they are about.
struct Draft {
  std::string format = "skybody-policy", squash = "clip", scenario = "test",
              scenario_hash = "0123456789abcdef";
  std::int64_t version = 2, observation_size = 2, action_size = 1;
  struct Layer {
    hsize_t rows, columns;
    std::vector<float> weight, bias;
    std::string activation;                                 ///< of a dense layer
    std::vector<float> state_weight = {}, state_bias = {};  ///< of a recurrent one
  };
  std::vector<Layer> layers = {{2, 2, {0.5f, -1.0f, 2.0f, 0.25f}, {0.1f, -0.2f}, "tanh"},
                               {1, 2, {1.5f, -0.75f}, {0.05f}, "none"}};
  std::vector<double> mean, scale;
  double clip = 10.0;
  std::string left_out;                                  ///< an attribute
  std::function<void(const Hdf5Writer&, hid_t)> finish;  ///< called with the file at the end
};

void write_matrix(const Hdf5Writer& writer, hid_t parent, const char* name, int rank,
                  const hsize_t* extent, const std::vector<float>& values) {
  const Hdf5Id space(writer.check(H5Screate_simple(rank, extent, nullptr)), H5Sclose);
  const Hdf5Id set(writer.check(H5Dcreate2(parent, name, H5T_IEEE_F32LE, space, H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT)),
                   H5Dclose);
  writer.check(H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

fs::path write_unsealed(const fs::path& path, const Draft& draft) {
  const Hdf5Writer writer(path, "policy");
  const Hdf5Id file = writer.create_file();
  const auto text = [&](const char* name, const std::string& value) {
    if (draft.left_out != name) writer.write_text(file, name, value);
  };
  const auto number = [&](const char* name, std::int64_t value) {
    if (draft.left_out != name) writer.write_attribute(file, name, value);
  };
  text("format", draft.format);
  number("version", draft.version);
  text("scenario", draft.scenario);
  text("scenario_hash", draft.scenario_hash);
  number("seed", 1);
  text("algorithm", "ppo");
  number("steps", 1000);
  text("skybody_version", "0");
  number("observation_size", draft.observation_size);
  number("action_size", draft.action_size);
  text("action_squash", draft.squash);
  if (!draft.mean.empty()) {
    const Hdf5Id group = writer.create_group(file, "normalization");
    writer.write_dataset(group, "mean", draft.mean);
    writer.write_dataset(group, "scale", draft.scale);
    writer.write_attribute(group, "clip", draft.clip);
  }
  const Hdf5Id layers = writer.create_group(file, "layers");
  for (std::size_t k = 0; k < draft.layers.size(); ++k) {
    const Draft::Layer& layer = draft.layers[k];
    const Hdf5Id group = writer.create_group(layers, std::to_string(k));
    const hsize_t shape[2] = {layer.rows, layer.columns}, bias = layer.bias.size();
    write_matrix(writer, group, "weight", 2, shape, layer.weight);
    write_matrix(writer, group, "bias", 1, &bias, layer.bias);
    if (layer.state_weight.empty()) {
      writer.write_text(group, "activation", layer.activation);
    } else {
      const hsize_t rows = layer.state_bias.size();
      const hsize_t states[2] = {rows, layer.state_weight.size() / rows};
      write_matrix(writer, group, "state_weight", 2, states, layer.state_weight);
      write_matrix(writer, group, "state_bias", 1, &rows, layer.state_bias);
    }
  }
  if (draft.finish) draft.finish(writer, file);
  return path;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

fs::path write_policy(const fs::path& path, const Draft& draft) {
  write_unsealed(path, draft);
  const std::string content = bytes_of(path);
  put_bytes(path, policy_seal(content) + content);
  return path;
}

float act(const fs::path& file, std::vector<float> observation) {
  NetworkPolicy policy(file);
  float action = 0.0f;
  policy.act(observation, {&action, 1});
  return action;
}

TEST(NetworkPolicy, GivesWhatIsComputedByHand) {
  const TemporaryFolder folder;
  const fs::path file = write_policy(folder.path() / "policy.h5", {});
  const double h0 = std::tanh(0.5 * 0.3 - 1.0 * -0.4 + static_cast<double>(0.1f));
  const double h1 = std::tanh(2.0 * 0.3 + 0.25 * -0.4 - static_cast<double>(0.2f));
  const double y = 1.5 * h0 - 0.75 * h1 + static_cast<double>(0.05f);
  // Inputs and output are floats: three roundings of 6e-8 each, times weights below 3.
  EXPECT_NEAR(static_cast<double>(act(file, {0.3f, -0.4f})), y, 3e-7);
}

TEST(NetworkPolicy, ClipsOrSquashesIntoTheRangeOfActions) {
  const TemporaryFolder folder;
  Draft draft;
  draft.layers = {{1, 2, {3.0f, 0.0f}, {0.0f}, "none"}};
  const fs::path clipped = write_policy(folder.path() / "clip.h5", draft);
  EXPECT_EQ(act(clipped, {1.0f, 0.0f}), 1.0f);
  EXPECT_EQ(act(clipped, {-1.0f, 0.0f}), -1.0f);
  EXPECT_EQ(act(clipped, {0.125f, 0.0f}), 0.375f);
  draft.squash = "tanh";
  const fs::path squashed = write_policy(folder.path() / "tanh.h5", draft);
  // One rounding to float of a value below 1.
  EXPECT_NEAR(static_cast<double>(act(squashed, {0.5f, 0.0f})), std::tanh(1.5), 6e-8);
  EXPECT_EQ(act(squashed, {100.0f, 0.0f}), 1.0f);
}

TEST(NetworkPolicy, NormalizesAndClipsObservations) {
  const TemporaryFolder folder;
  Draft draft;
  draft.layers = {{1, 2, {0.25f, 0.0f}, {0.0f}, "relu"}};
  draft.mean = {2.0, 0.0};
  draft.scale = {0.5, 1.0};
  draft.clip = 3.0;
  const fs::path file = write_policy(folder.path() / "policy.h5", draft);
  EXPECT_EQ(act(file, {4.0f, 0.0f}), 0.25f);
  EXPECT_EQ(act(file, {100.0f, 0.0f}), 0.75f) << "beyond the clip";
  EXPECT_EQ(act(file, {0.0f, 0.0f}), 0.0f) << "relu";
}

TEST(NetworkPolicy, ActivatesByExponentialLinearUnits) {
  const TemporaryFolder folder;
  Draft draft;
  draft.layers = {{1, 2, {0.5f, 0.0f}, {0.0f}, "elu"}};
  const fs::path file = write_policy(folder.path() / "policy.h5", draft);
  EXPECT_EQ(act(file, {1.0f, 0.0f}), 0.5f);
  // One rounding to float of a value below 1.
  EXPECT_NEAR(static_cast<double>(act(file, {-1.0f, 0.0f})), std::expm1(-0.5), 6e-8);
}

/// One unit, whose gates see the first observation with these weights and biases.
Draft recurrent_draft() {
  Draft draft;
  draft.layers = {{3,
                   2,
                   {0.5f, 0.0f, -1.0f, 0.0f, 2.0f, 0.0f},
                   {0.1f, 0.2f, 0.3f},
                   "",
                   {0.75f, 1.5f, -0.5f},
                   {-0.1f, 0.4f, 0.6f}},
                  {1, 1, {0.9f}, {0.0f}, "none"}};
  return draft;
}

/// The next state of that unit.
double next_state(double h, double x) {
  const auto sigmoid = [](double s) { return 1.0 / (1.0 + std::exp(-s)); };
  const double r = sigmoid(0.5 * x + 0.1 + 0.75 * h - 0.1);
  const double z = sigmoid(-1.0 * x + 0.2 + 1.5 * h + 0.4);
  const double n = std::tanh(2.0 * x + 0.3 + r * (-0.5 * h + 0.6));
  return (1.0 - z) * n + z * h;
}

TEST(NetworkPolicy, RemembersByItsRecurrentLayersUntilItIsReset) {
  const TemporaryFolder folder;
  NetworkPolicy policy(write_policy(folder.path() / "policy.h5", recurrent_draft()));
  for (int episode = 0; episode < 2; ++episode) {
    double h = 0.0;
    for (const float x : {0.3f, -0.8f, 0.1f, 0.0f}) {
      const float observation[] = {x, 5.0f};
      float action = 0.0f;
      policy.act(observation, {&action, 1});
      h = next_state(h, static_cast<double>(x));
      // Weights are floats: 3e-8 of each, over four steps.
      EXPECT_NEAR(static_cast<double>(action), 0.9 * h, 5e-7);
    }
    policy.reset();
  }
}

TEST(NetworkPolicy, IsFoundInACheckpointAndInARunsNewestCheckpoint) {
  const TemporaryFolder folder;
  for (const char* step : {"step_000000000500", "step_000000002000", "step_000000001000"}) {
    const fs::path checkpoint = folder.path() / "checkpoints" / step;
    fs::create_directories(checkpoint);
    write_policy(checkpoint / "policy.h5", {});
  }
  fs::create_directories(folder.path() / "checkpoints" / "step_000000009000");  // unfinished
  const fs::path newest = folder.path() / "checkpoints" / "step_000000002000";
  EXPECT_EQ(find_policy(folder.path()), newest / "policy.h5");
  EXPECT_EQ(find_policy(newest), newest / "policy.h5");
  EXPECT_EQ(find_policy(newest / "policy.h5"), newest / "policy.h5");
}

constexpr const char* kDamaged =
    "damaged, cut short or changed: its bytes are not those that its first lines name; take "
    "another copy, or an earlier checkpoint";

/// The message of a file that is refused, or an empty text.
std::string refusal_of(const fs::path& file) {
  try {
    read_policy(file);
  } catch (const MarkedError& error) {
    return error.what();
  }
  return "";
}

TEST(PolicyFile, IsRefusedWithAnyBitTurned) {
  const TemporaryFolder folder;
  Draft draft;
  draft.mean = {2.0, 0.0};
  draft.scale = {0.5, 1.0};
  const fs::path file = write_policy(folder.path() / "policy.h5", draft);
  const int flips = flips_wanted(2000);
  const FlipCounts counts = flip_bits(file, flips, [&] {
    const PolicyFile policy = read_policy(file);
    return std::to_string(policy.layers.size());  // every bit is guarded: nothing is read at all
  });
  EXPECT_EQ(counts, FlipCounts{.refused = counts.refused}) << testing::PrintToString(counts);
  std::printf("%s\n", testing::PrintToString(counts).c_str());
}

TEST(PolicyFile, IsRefusedCutShortOrLengthenedOrWithoutAGroup) {
  const TemporaryFolder folder;
  Draft draft;
  draft.mean = {2.0, 0.0};
  draft.scale = {0.5, 1.0};
  const fs::path file = write_policy(folder.path() / "policy.h5", draft);
  const std::string whole = bytes_of(file);
  for (const std::size_t size : {std::size_t{17}, kPolicySealBytes, whole.size() - 1}) {
    put_bytes(file, whole.substr(0, size));
    EXPECT_EQ(refusal_of(file), kDamaged) << size;
  }
  put_bytes(file, whole + '\0');
  EXPECT_EQ(refusal_of(file), kDamaged);
  put_bytes(file, whole);
  {
    const Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    ASSERT_GE(H5Ldelete(opened, "/normalization", H5P_DEFAULT), 0);
  }
  EXPECT_EQ(refusal_of(file), kDamaged) << "flies with other numbers";
}

struct BadPolicy {
  const char* name;
  std::function<void(Draft&)> change;
  const char* message;  ///< behind the file's name
};
void PrintTo(const BadPolicy& bad, std::ostream* out) { *out << bad.name; }

/// Adds /layers/2/weight of `rows` x 1, stored as `properties` say.
void add_layer(const Hdf5Writer& writer, hid_t file, hsize_t rows, hid_t properties) {
  const Hdf5Id group = writer.create_group(file, "/layers/2");
  const hsize_t extent[2] = {rows, 1};
  const Hdf5Id space(writer.check(H5Screate_simple(2, extent, nullptr)), H5Sclose);
  const Hdf5Id set(writer.check(H5Dcreate2(group, "weight", H5T_IEEE_F32LE, space, H5P_DEFAULT,
                                           properties, H5P_DEFAULT)),
                   H5Dclose);
}

Hdf5Id chunked(const Hdf5Writer& writer, hsize_t rows) {
  const hsize_t chunk[2] = {rows, 1};
  Hdf5Id properties(writer.check(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  writer.check(H5Pset_chunk(properties, 2, chunk));
  return properties;
}

void add_huge_layer(const Hdf5Writer& writer, hid_t file) {
  add_layer(writer, file, hsize_t{1} << 60, chunked(writer, 1));
}

void add_compressed_layer(const Hdf5Writer& writer, hid_t file) {
  const Hdf5Id properties = chunked(writer, 1);
  writer.check(H5Pset_shuffle(properties));
  add_layer(writer, file, 1, properties);
}

void add_huge_chunk(const Hdf5Writer& writer, hid_t file) {
  const Hdf5Id properties = chunked(writer, hsize_t{1} << 29);
  const Hdf5Id group = writer.create_group(file, "/layers/2");
  const hsize_t extent[2] = {1, 1}, most[2] = {H5S_UNLIMITED, 1};
  const Hdf5Id space(writer.check(H5Screate_simple(2, extent, most)), H5Sclose);
  const Hdf5Id set(writer.check(H5Dcreate2(group, "weight", H5T_IEEE_F32LE, space, H5P_DEFAULT,
                                           properties, H5P_DEFAULT)),
                   H5Dclose);
}

void add_external_layer(const Hdf5Writer& writer, hid_t file) {
  const Hdf5Id properties(writer.check(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  writer.check(H5Pset_external(properties, "/etc/hostname", 0, 4));
  add_layer(writer, file, 1, properties);
}

class BadPolicies : public testing::TestWithParam<BadPolicy> {};

TEST_P(BadPolicies, GetOneClearError) {
  const TemporaryFolder folder;
  Draft draft;
  GetParam().change(draft);
  write_policy(folder.path() / "policy.h5", draft);
  const Outcome outcome = run_skybody({"run", "hover", "--policy", "policy.h5", "--out", "out"},
                                      {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, std::string("policy.h5: error: ") + GetParam().message + "\n");
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(folder.names(), std::vector<std::string>{"policy.h5"});
}

const BadPolicy kBadPolicies[] = {
    {"another_format", [](Draft& d) { d.format = "onnx"; },
     "not a policy: its format is `onnx`; allowed: `skybody-policy`"},
    {"no_format", [](Draft& d) { d.left_out = "format"; },
     "the attribute `format` of `/` is missing in this policy file"},
    {"newer_version", [](Draft& d) { d.version = 3; },
     "policy format 3; this Skybody reads format 2: export the policy anew"},
    {"no_observations", [](Draft& d) { d.observation_size = 0; },
     "`observation_size` is 0; allowed: 1..16777216"},
    {"no_layers", [](Draft& d) { d.layers.clear(); }, "`/layers/0` is missing in this policy file"},
    {"wrong_inputs", [](Draft& d) { d.observation_size = 3; },
     "`/layers/0/weight` has 2 x 2 values; needed: outputs x 3"},
    {"wrong_bias", [](Draft& d) { d.layers[0].bias.push_back(0.0f); },
     "`/layers/0/bias` has 3 values; needed: 2"},
    {"wrong_outputs", [](Draft& d) { d.action_size = 4; },
     "the last layer gives 1 values; `action_size` is 4"},
    {"not_finite",
     [](Draft& d) { d.layers[1].weight[1] = std::numeric_limits<float>::quiet_NaN(); },
     "value 1 of `/layers/1/weight` is not finite: the network cannot fly; take an earlier "
     "checkpoint"},
    {"recurrent_rows",
     [](Draft& d) {
       d.layers[0] = {4,
                      2,
                      std::vector<float>(8),
                      std::vector<float>(4),
                      "",
                      std::vector<float>(4),
                      std::vector<float>(4)};
     },
     "`/layers/0/weight` has 4 x 2 values; needed: 3 units x 2"},
    {"recurrent_state_weight",
     [](Draft& d) {
       d.layers[0] = {6,
                      2,
                      std::vector<float>(12),
                      std::vector<float>(6),
                      "",
                      std::vector<float>(18),
                      std::vector<float>(6)};
     },
     "`/layers/0/state_weight` has 6 x 3 values; needed: 6 x 2"},
    {"unknown_activation", [](Draft& d) { d.layers[0].activation = "gelu"; },
     "`activation` of `/layers/0` is `gelu`; allowed: none, tanh, relu, elu"},
    {"unknown_squash", [](Draft& d) { d.squash = "sine"; },
     "`action_squash` is `sine`; allowed: clip, tanh"},
    {"soft_link",
     [](Draft& d) {
       d.finish = [](const Hdf5Writer& writer, hid_t file) {
         writer.check(H5Lcreate_soft("/layers/0", file, "/layers/2", H5P_DEFAULT, H5P_DEFAULT));
       };
     },
     "`/layers/2` is a link to another place; a policy holds its values itself"},
    {"external_link",
     [](Draft& d) {
       d.finish = [](const Hdf5Writer& writer, hid_t file) {
         writer.check(
             H5Lcreate_external("gone.h5", "/", file, "normalization", H5P_DEFAULT, H5P_DEFAULT));
       };
     },
     "`/normalization` is a link to another place; a policy holds its values itself"},
    {"variable_text",
     [](Draft& d) {
       d.left_out = "scenario";
       d.finish = [](const Hdf5Writer& writer, hid_t file) {
         writer.write_attribute(file, "scenario", std::string("hover"));
       };
     },
     "the attribute `scenario` of `/` is a text of variable length; allowed: texts of fixed "
     "length"},
    {"values_without_storage", [](Draft& d) { d.finish = add_huge_layer; },
     "`/layers/2/weight` claims more values than the file has bytes for: the file is damaged"},
    {"external_storage", [](Draft& d) { d.finish = add_external_layer; },
     "`/layers/2/weight` is stored in other files; a policy holds its values itself"},
    {"compressed", [](Draft& d) { d.finish = add_compressed_layer; },
     "`/layers/2/weight` is compressed or filtered; allowed: fletcher32"},
    {"huge_chunk", [](Draft& d) { d.finish = add_huge_chunk; },
     "`/layers/2/weight` has chunks of more than 16 MiB"},
    {"short_mean", [](Draft& d) { d.mean = d.scale = {1.0}; },
     "`/normalization/mean` has 1 values; needed: 2"},
};

INSTANTIATE_TEST_SUITE_P(Files, BadPolicies, testing::ValuesIn(kBadPolicies),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(RunPolicy, SaysWhatIsWrongWithFilesThatAreNoPolicies) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "text.h5") << "not HDF5";
  fs::create_directory(folder.path() / "empty");
  write_policy(folder.path() / "cut.h5", {});
  write_unsealed(folder.path() / "old.h5", {});
  put_bytes(folder.path() / "newer.h5", "skybody-policy 3\nbytes 0\n");
  put_bytes(folder.path() / "sealed_text.h5", policy_seal("no HDF5") + "no HDF5");
  fs::resize_file(folder.path() / "cut.h5", fs::file_size(folder.path() / "cut.h5") / 2);
  const auto run = [&](const char* policy) {
    const Outcome outcome = run_skybody({"run", "hover", "--policy", policy, "--out", "out"},
                                        {.folder = folder.path()});
    EXPECT_EQ(outcome.exit_code, 2) << policy;
    EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
    return outcome.err;
  };
  EXPECT_EQ(run("text.h5"),
            "text.h5: error: not a policy file: it does not begin with `skybody-policy 2`\n");
  EXPECT_EQ(run("cut.h5"), std::string("cut.h5: error: ") + kDamaged + "\n");
  EXPECT_EQ(run("old.h5"),
            "old.h5: error: an HDF5 file without the seal of policy format 2; a policy of format 1 "
            "is converted by `python -m skybody.train.convert_policy old.h5`\n");
  EXPECT_EQ(run("newer.h5"),
            "newer.h5: error: policy format 3; this Skybody reads format 2: export the policy "
            "anew\n");
  EXPECT_THAT(run("sealed_text.h5"), HasSubstr("error: not a policy file, or cut short: "));
  EXPECT_THAT(run("empty"), HasSubstr("error: the folder empty has neither policy.h5 nor"));
  EXPECT_THAT(run("gone.h5"), HasSubstr("there is no policy or file `gone.h5`"));
}

/// Fits the hover scenario: all rotors in the middle of their range.
Draft hover_draft(const Simulation& simulation) {
  Draft draft;
  const auto inputs = static_cast<hsize_t>(simulation.observation_size());
  const auto outputs = static_cast<hsize_t>(simulation.action_size());
  draft.observation_size = simulation.observation_size();
  draft.action_size = simulation.action_size();
  draft.scenario = "hover";
  draft.scenario_hash = to_hex(simulation.scenario().hash);
  draft.layers = {{outputs, inputs, std::vector<float>(inputs * outputs, 0.01f),
                   std::vector<float>(outputs, 0.1f), "tanh"}};
  return draft;
}

/// The same with a recurrent layer of four units in front.
Draft recurrent_hover_draft(const Simulation& simulation) {
  Draft draft = hover_draft(simulation);
  const auto inputs = static_cast<std::size_t>(simulation.observation_size());
  const Draft::Layer gru = {12,
                            inputs,
                            std::vector<float>(12 * inputs, 0.05f),
                            std::vector<float>(12, 0.1f),
                            "",
                            std::vector<float>(12 * 4, 0.3f),
                            std::vector<float>(12, -0.1f)};
  const hsize_t outputs = draft.layers[0].rows;
  draft.layers = {gru,
                  {outputs, 4, std::vector<float>(outputs * 4, 0.1f),
                   std::vector<float>(outputs, 0.1f), "tanh"}};
  return draft;
}

/// Actions of one step.
std::vector<float> fly_step(Simulation& simulation, NetworkPolicy& policy) {
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  policy.act(simulation, action);
  simulation.step(action);
  return action;
}

TEST(NetworkPolicy, RemembersSimulationsApartAndBeginsAnewWithAnEpisode) {
  const TemporaryFolder folder;
  Simulation alone({.scenario = "hover", .seed = 1}), one({.scenario = "hover", .seed = 1}),
      other({.scenario = "hover", .seed = 2});
  const fs::path file = write_policy(folder.path() / "policy.h5", recurrent_hover_draft(alone));
  NetworkPolicy policy(file), shared(file);
  for (Simulation* simulation : {&alone, &one, &other}) simulation->reset();
  for (int step = 0; step < 5; ++step) {
    const std::vector<float> wanted = fly_step(alone, policy);
    EXPECT_EQ(fly_step(one, shared), wanted);
    fly_step(other, shared);
  }
  NetworkPolicy fresh(file);
  EXPECT_NE(fly_step(one, fresh), fly_step(alone, policy)) << "it does remember";
  one.reset();
  alone.reset();
  NetworkPolicy again(file);
  EXPECT_EQ(fly_step(one, shared), fly_step(alone, again)) << "of another episode nothing";
}

TEST(RunPolicy, FliesARecurrentNetworkThroughEpisodes) {
  const TemporaryFolder folder;
  const Simulation simulation({.scenario = "hover"});
  write_policy(folder.path() / "policy.h5", recurrent_hover_draft(simulation));
  const Outcome outcome = run_skybody({"run", "hover", "--policy", "policy.h5", "--steps", "20",
                                       "--episodes", "2", "--out", "out", "--no-picture"},
                                      {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

TEST(RunPolicy, FliesATrainedNetwork) {
  const TemporaryFolder folder;
  const Simulation simulation({.scenario = "hover"});
  write_policy(folder.path() / "policy.h5", hover_draft(simulation));
  const Outcome outcome = run_skybody(
      {"run", "hover", "--policy", "policy.h5", "--steps", "20", "--out", "out", "--no-picture"},
      {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(fs::exists(folder.path() / "out" / "flight.h5"));
}

TEST(RunPolicy, WarnsOfAnotherScenarioAndRefusesOtherSizes) {
  const TemporaryFolder folder;
  const Simulation simulation({.scenario = "hover"});
  Draft draft = hover_draft(simulation);
  draft.scenario = "other";
  draft.scenario_hash = "0123456789abcdef";
  write_policy(folder.path() / "other.h5", draft);
  write_policy(folder.path() / "small.h5", {});
  const auto run = [&](const char* policy) {
    return run_skybody(
        {"run", "hover", "--policy", policy, "--steps", "5", "--out", "out", "--no-picture"},
        {.folder = folder.path()});
  };
  const Outcome other = run("other.h5");
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_THAT(other.err, HasSubstr("warning: the policy other.h5 was trained on `other` with hash "
                                   "0123456789abcdef; this is `hover` with hash " +
                                   to_hex(simulation.scenario().hash)));
  const Outcome small = run("small.h5");
  EXPECT_EQ(small.exit_code, 2);
  EXPECT_THAT(small.err, HasSubstr("error: the policy small.h5 has observations of 2 values; "));
}

}  // namespace
}  // namespace skybody::test
