// policy.h5: a changed file is either refused or flies exactly as the original does.
#include <cstring>

#include "core/policy/network_policy.h"
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/seed_policy.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int kObservations = 16;  // number of observations given to a network

/// A network's outputs and the file's metadata, as comparable words.
struct Content {
  std::string scenario, scenario_hash, algorithm;
  std::int64_t steps = 0;
  int observation_size = 0, action_size = 0;
  std::vector<std::uint32_t> actions;
  bool operator==(const Content&) const = default;
};

/// Values of both signs, from small to far outside any clip.
float observation(int set, std::size_t k) {
  Dice dice(static_cast<std::uint64_t>(set), "policy.observation", k);
  const double size = set % 4 == 3 ? 1e4 : 3.0;
  return static_cast<float>(size * (2.0 * (static_cast<double>(dice.bits() >> 11) * 0x1p-53) - 1));
}

Content content_of(const fs::path& file) {
  NetworkPolicy network(file);
  const PolicyFile& policy = network.policy();
  Content content{policy.scenario,
                  policy.scenario_hash,
                  policy.algorithm,
                  policy.steps,
                  policy.observation_size,
                  policy.action_size,
                  {}};
  std::vector<float> in(static_cast<std::size_t>(policy.observation_size));
  std::vector<float> out(static_cast<std::size_t>(policy.action_size));
  std::size_t largest = 0;
  for (const PolicyImage& image : policy.images) {
    largest = std::max(largest, static_cast<std::size_t>(image.height) * image.width *
                                    static_cast<std::size_t>(image.channels));
  }
  const std::vector<std::uint8_t> pixels(largest, 100);
  const std::vector<ImageView> images(policy.images.size(), {ColumnType::kUint8, pixels.data()});
  for (int set = 0; set < kObservations; ++set) {
    for (std::size_t k = 0; k < in.size(); ++k) in[k] = observation(set, k);
    network.act(in, out, images);
    for (const float value : out) {
      content.actions.emplace_back();
      std::memcpy(&content.actions.back(), &value, sizeof value);
    }
  }
  return content;
}

class PolicyArea : public Area {
 public:
  explicit PolicyArea(const AreaOptions& options) {
    fs::path seed = options.policy;
    if (seed.empty()) {
      seed = options.folder / "seed_policy.h5";
      write_seed_policy(seed);
    }
    original_ = content_of(seed);
    material_.seeds.push_back(read_bytes(seed));
    material_.words = {"skybody-policy", "TREE", "SNOD", "HEAP", "OHDR", "OCHK", "FRHP",
                       "FHDB",           "GCOL", "BTHD", "/",    "0",    "mean", "weight"};
  }

  void begin(const fs::path& folder) override { file_ = folder / "policy.h5"; }

  Answer run(const std::string& input, bool) override {
    write_bytes(file_, input);
    Content content;
    try {
      content = content_of(file_);
    } catch (const Error& error) {
      check_message(error.what());
      return Answer::kRefused;
    }
    if (content.actions != original_.actions) silent_change("flies with other actions");
    if (content != original_) silent_change("says something else of its training");
    return Answer::kAccepted;
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  fs::path file_;
  Content original_;
};

}  // namespace

std::unique_ptr<Area> make_policy_area(const AreaOptions& options) {
  return std::make_unique<PolicyArea>(options);
}

}  // namespace skybody::fuzz
