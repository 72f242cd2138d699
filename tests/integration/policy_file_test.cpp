// Invalid policy files and the messages that refuse them.
#include "core/io/files/policy_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>

#include "core/io/files/policy_checksum.h"
#include "core/model/located_error.h"
#include "tests/integration/flips.h"
#include "tests/integration/policy_draft.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;

/// The message that refuses the file, or an empty text.
std::string refusal_of(const fs::path& file) {
  try {
    read_policy(file);
  } catch (const LocatedError& error) {
    return error.message();
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
    return std::to_string(
        policy.layers.size());  // the seal covers every bit: nothing is read at all
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
  const char* message;  ///< after the file's name
};
void PrintTo(const BadPolicy& bad, std::ostream* out) { *out << bad.name; }

/// Adds /layers/2/weight of size `rows` x 1 with the storage properties `properties`.
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
     "not a policy: its format is `onnx`; allowed: `skybody-policy`; give a policy.h5, which "
     "`skybody "
     "train` writes"},
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
       d.layers[0] = {5,
                      2,
                      std::vector<float>(10),
                      std::vector<float>(5),
                      "",
                      std::vector<float>(5),
                      std::vector<float>(5)};
     },
     "`/layers/0/weight` has 5 x 2 values; needed: 3 or 4 units x 2"},
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

}  // namespace
}  // namespace skybody::test
