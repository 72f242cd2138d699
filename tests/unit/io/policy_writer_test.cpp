#include "core/io/files/policy_writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/system/error.h"
#include "core/io/files/atomic_file.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

PolicyLayer layer(int inputs, int outputs, std::vector<double> weight, std::vector<double> bias,
                  Activation activation) {
  PolicyLayer made;
  made.inputs = inputs;
  made.outputs = outputs;
  made.weight = std::move(weight);
  made.bias = std::move(bias);
  made.activation = activation;
  return made;
}

PolicyFile small_policy() {
  PolicyFile policy;
  policy.scenario = "hover";
  policy.scenario_hash = "0123456789abcdef";
  policy.algorithm = "fast-ppo";
  policy.steps = 12345678901;
  policy.observation_size = 2;
  policy.action_size = 1;
  policy.mean = {0.1, -0.2};
  policy.scale = {3.0, 1e-3};
  policy.clip = 10.0;
  policy.layers = {layer(2, 3, {1, 2, 3, 4, 5, 6.5}, {0.5, 0, -1}, Activation::kTanh),
                   layer(3, 1, {-1, 0.25, 2}, {0.125}, Activation::kNone)};
  return policy;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(PolicyWriter, WhatIsWrittenReadsBackTheSame) {
  const TempFolder folder;
  const PolicyFile policy = small_policy();
  write_policy(folder.path("policy.h5"), policy, 7);
  const PolicyFile read = read_policy(folder.path("policy.h5"));
  EXPECT_EQ(read.scenario, "hover");
  EXPECT_EQ(read.scenario_hash, policy.scenario_hash);
  EXPECT_EQ(read.algorithm, "fast-ppo");
  EXPECT_EQ(read.steps, 12345678901);
  EXPECT_EQ(read.squash, ActionSquash::kClip);
  EXPECT_EQ(read.mean, policy.mean);
  EXPECT_EQ(read.scale, policy.scale);
  EXPECT_EQ(read.clip, 10.0);
  ASSERT_EQ(read.layers.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(read.layers[k].weight, policy.layers[k].weight);
    EXPECT_EQ(read.layers[k].bias, policy.layers[k].bias);
    EXPECT_EQ(read.layers[k].activation, policy.layers[k].activation);
  }
}

TEST(PolicyWriter, MemoryAndSharedPoliciesReadBackTheSame) {
  const TempFolder folder;
  PolicyFile policy = small_policy();
  policy.observation_size = 4;
  policy.action_size = 2;
  policy.agents = {{{0, 1}, {0}}, {{2, 3}, {1}}};
  PolicyLayer gru = layer(2, 1, {1, 2, 3, 4, 5, 6}, {1, 2, 3}, Activation::kNone);
  gru.kind = LayerKind::kGru;
  gru.state_weight = {-1, -2, -3};
  gru.state_bias = {0.5, 0.25, 0.125};
  policy.layers = {gru, layer(1, 1, {2}, {1}, Activation::kElu)};
  write_policy(folder.path("policy.h5"), policy, 0);
  const PolicyFile read = read_policy(folder.path("policy.h5"));
  ASSERT_EQ(read.agents.size(), 2u);
  EXPECT_EQ(read.agents[1].observation, policy.agents[1].observation);
  EXPECT_EQ(read.agents[1].action, policy.agents[1].action);
  ASSERT_EQ(read.layers.size(), 2u);
  EXPECT_EQ(read.layers[0].kind, LayerKind::kGru);
  EXPECT_EQ(read.layers[0].weight, gru.weight);
  EXPECT_EQ(read.layers[0].state_weight, gru.state_weight);
  EXPECT_EQ(read.layers[0].state_bias, gru.state_bias);
  EXPECT_EQ(read.layers[1].activation, Activation::kElu);
}

TEST(PolicyWriter, LongShortTermMemoryReadsBackTheSame) {
  const TempFolder folder;
  PolicyFile policy = small_policy();
  PolicyLayer lstm = layer(2, 1, {1, 2, 3, 4, 5, 6, 7, 8}, {1, 2, 3, 4}, Activation::kNone);
  lstm.kind = LayerKind::kLstm;
  lstm.state_weight = {-1, -2, -3, -4};
  lstm.state_bias = {0.5, 0.25, 0.125, 2.0};
  policy.layers = {lstm, layer(1, 1, {2}, {1}, Activation::kNone)};
  write_policy(folder.path("policy.h5"), policy, 0);
  const PolicyFile read = read_policy(folder.path("policy.h5"));
  ASSERT_EQ(read.layers.size(), 2u);
  EXPECT_EQ(read.layers[0].kind, LayerKind::kLstm);
  EXPECT_EQ(read.layers[0].outputs, 1);
  EXPECT_EQ(read.layers[0].state_size(), 2);
  EXPECT_EQ(read.layers[0].weight, lstm.weight);
  EXPECT_EQ(read.layers[0].state_weight, lstm.state_weight);
}

TEST(PolicyWriter, ANormalizationThatIsNotThereStaysAway) {
  const TempFolder folder;
  PolicyFile policy = small_policy();
  policy.mean = policy.scale = {};
  policy.squash = ActionSquash::kTanh;
  write_policy(folder.path("policy.h5"), policy, UINT64_MAX);
  const PolicyFile read = read_policy(folder.path("policy.h5"));
  EXPECT_TRUE(read.mean.empty());
  EXPECT_EQ(read.squash, ActionSquash::kTanh);
}

TEST(PolicyWriter, EqualPoliciesGiveEqualBytesAtAnyTime) {
  const std::string before = policy_bytes(small_policy(), 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // times in HDF5 are whole seconds
  EXPECT_EQ(policy_bytes(small_policy(), 1), before);
  EXPECT_NE(policy_bytes(small_policy(), 2), before);
}

TEST(PolicyWriter, AFolderThatIsNotThereIsNamed) {
  const TempFolder folder;
  try {
    write_policy(folder.path("none/policy.h5"), small_policy(), 0);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("none/"), std::string::npos) << error.what();
  }
}

/// Limits the size of files during its lifetime, as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(WholeFile, KeepsTheOldFileAndLeavesNoOtherWhereThereIsNoSpace) {
  const TempFolder folder;
  write_file_atomically(folder.path("a.txt"), "before");
  {
    const FileSizeLimit full(100);
    EXPECT_THROW(write_file_atomically(folder.path("a.txt"), std::string(1000, 'x')), Error);
  }
  EXPECT_EQ(bytes_of(folder.path("a.txt")), "before");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path("")), {}), 1);
}

}  // namespace
}  // namespace skybody
