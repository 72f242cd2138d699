// Observed and privileged columns of sensors in batches of every kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/batch/motion_hash.h"
#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::InProcessFactory;

/// Height for the policy, and vertical speed for a critic only.
class Gauge : public Sensor {
 public:
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.channel("speed", "m/s", 1, -kInfinity, kInfinity);
  }
  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> out) const {
    out.set(0, env.body(0).position.z);
    out.set(1, env.body(0).velocity.z);
  }
};

/// The number of its calls in every pixel.
class Camera : public Sensor {
 public:
  struct State {
    std::uint64_t calls;
  };
  void configure(const Setup& setup) override {
    image_ = setup.image<std::uint8_t>("image", {2, 3});
    setup.channel("calls", "", 1, 0, kInfinity);
  }
  void sense(const EnvView<double>& env, State& s, Values<double> out) const {
    if (!env.draws_again()) ++s.calls;
    for (int k = 0; k < image_.count; ++k)
      env.pixels(image_)[k] = static_cast<std::uint8_t>(s.calls);
    out.set(0, static_cast<double>(s.calls));
  }

 private:
  Image<std::uint8_t> image_;
};

ObservedChannel observed(const std::string& channel, bool privileged) {
  ObservedChannel o;
  o.channel = o.name = channel;
  o.privileged = privileged;
  return o;
}

std::shared_ptr<const CompiledScenario> observed_env() {
  InProcessFactory factory;
  factory.add<Gauge>("gauge");
  Scenario s = test::small_scenario(factory);
  s.sensors.push_back(factory.use("gauge", "gauge"));
  s.observe = {observed("gauge.height", false), observed("gauge.speed", true)};
  return std::make_shared<CompiledScenario>(std::move(s), factory);
}

std::shared_ptr<const CompiledScenario> seeing_env() {
  InProcessFactory factory;
  factory.add<Camera>("camera");
  Scenario s = test::small_scenario(factory);
  s.sensors.push_back(factory.use("camera", "camera"));
  s.observe = {observed("camera.image", false), observed("camera.calls", false)};
  return std::make_shared<CompiledScenario>(std::move(s), factory);
}

struct Shape {
  int envs, batch, threads;
  Order order;
  Autoreset autoreset;
};

/// Every row of a flight: observation, then privileged values, by environment and transition.
std::map<int, std::vector<std::vector<float>>> rows_of(const Shape& shape) {
  PoolOptions options;
  options.envs = shape.envs;
  options.batch = shape.batch;
  options.threads = shape.threads;
  options.order = shape.order;
  options.autoreset = shape.autoreset;
  Pool envs(observed_env(), options);
  std::map<int, std::vector<std::vector<float>>> rows;
  test::fly(envs, 0, 40, [&](const Batch& batch, int i) {
    const float* seen = batch.observation.data() + i * batch.width.observation;
    std::vector<float> row(seen, seen + batch.width.observation);
    row.push_back(batch.privileged[static_cast<std::size_t>(i)]);
    rows[batch.env_id[static_cast<std::size_t>(i)]].push_back(row);
  });
  return rows;
}

TEST(ObservationBatch, RowsAreThoseOfTheTaskAndTheSensor) {
  for (const auto& [env, rows] : rows_of({5, 5, 1, Order::kFixed, Autoreset::kNextStep})) {
    for (const std::vector<float>& row : rows) {
      ASSERT_EQ(row.size(), 5u);
      EXPECT_EQ(row[3], row[0]);  // height, by the sensor and by the task
      EXPECT_EQ(row[4], row[1]);  // vertical speed
    }
  }
}

TEST(ObservationBatch, RowsDoNotDependOnBatchesThreadsAndOrder) {
  const auto expected = rows_of({70, 70, 1, Order::kFixed, Autoreset::kNextStep});
  EXPECT_EQ(rows_of({70, 70, 2, Order::kFixed, Autoreset::kNextStep}), expected);
  EXPECT_EQ(rows_of({70, 13, 2, Order::kFixed, Autoreset::kNextStep}), expected);
  EXPECT_EQ(rows_of({70, 13, 2, Order::kArrival, Autoreset::kNextStep}), expected);
}

TEST(ObservationBatch, FinalRowsHaveThePrivilegedValuesOfTheEnd) {
  for (const int batch_size : {40, 7}) {  // a round, and rows that are gathered
    PoolOptions options;
    options.envs = 40;
    options.batch = batch_size;
    options.autoreset = Autoreset::kSameStep;
    Pool envs(observed_env(), options);
    int ends = 0;
    test::fly(envs, 0, 30, [&](const Batch& batch, int i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_EQ(batch.privileged[k], batch.observation[4 * k + 1]);
      if (batch.status[k] == kRunning) return;
      ++ends;
      EXPECT_EQ(batch.final_privileged[k], batch.final_observation[4 * k + 1]);
      EXPECT_NE(batch.final_privileged[k], batch.privileged[k]);
    });
    EXPECT_GT(ends, 20);
  }
}

TEST(ObservationBatch, LastRowsComeBackAfterARestoreAndAFork) {
  PoolOptions options;
  options.envs = 3;
  Pool envs(observed_env(), options);
  test::fly(envs, 0, 5);
  const std::vector<std::uint64_t> saved = envs.save();
  std::vector<float> before(3), after(3);
  envs.privileged(before);
  test::fly(envs, 5, 8);
  envs.restore(saved);
  envs.privileged(after);
  EXPECT_EQ(after, before);
  envs.fork(0, std::vector<std::int32_t>{1, 2}, false);
  envs.privileged(after);
  EXPECT_EQ(after, std::vector<float>(3, before[0]));
}

TEST(ObservationBatch, PrivilegedRowsOfAnotherSizeAreRefused) {
  Pool envs(observed_env(), {});
  std::vector<float> rows(2);
  EXPECT_THROW(envs.privileged(rows), Error);
}

/// Compares the pixels of row `i` with those that match the observation.
void expect_pixels(const Column<std::uint8_t>& image, const Column<float>& observation, int i) {
  const auto at = static_cast<std::size_t>(i);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(static_cast<float>(image[6 * at + k]), observation[4 * at + 3]);
  }
}

TEST(ImageBatch, RowsAndFinalRowsHaveTheImagesOfTheirObservations) {
  for (const int batch_size : {40, 7}) {  // a round, and rows that are gathered
    PoolOptions options;
    options.envs = 40;
    options.batch = batch_size;
    options.threads = 2;
    options.autoreset = Autoreset::kSameStep;
    Pool envs(seeing_env(), options);
    int ends = 0;
    test::fly(envs, 0, 30, [&](const Batch& batch, int i) {
      expect_pixels(batch.images[0], batch.observation, i);
      if (batch.status[static_cast<std::size_t>(i)] == kRunning) return;
      ++ends;
      expect_pixels(batch.final_images[0], batch.final_observation, i);
    });
    EXPECT_GT(ends, 20);
  }
}

TEST(ImageBatch, ImagesComeBackAfterARestoreAndAFork) {
  PoolOptions options;
  options.envs = 3;
  options.keep_hash = true;
  Pool envs(seeing_env(), options), copy(seeing_env(), options);
  test::fly(envs, 0, 4);
  const std::vector<std::uint64_t> saved = envs.save();
  std::vector<std::uint8_t> before(18), after(18);
  envs.image(0, before);
  EXPECT_GT(before[0], 0);
  copy.restore(saved);
  copy.image(0, after);
  EXPECT_EQ(after, before);
  EXPECT_EQ(copy.hash(), envs.hash());
  copy.fork(2, std::vector<std::int32_t>{0}, false);
  copy.image(0, after);
  EXPECT_EQ(after[0], before[12]);
  EXPECT_THROW(envs.image(1, after), Error);
}

TEST(ImageBatch, ASimulationHasTheSameImageAndHash) {
  PoolOptions options;
  options.seed = 4;
  options.keep_hash = true;
  Pool envs(seeing_env(), options);
  Simulation simulation(seeing_env(), 4, 0);
  test::begin(envs);
  simulation.reset();
  std::vector<std::uint8_t> pixels(6);
  envs.image(0, pixels);
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), simulation.image(0).begin()));
  EXPECT_EQ(simulation.hash(), envs.hash(0));
  const Snapshot saved = simulation.save();
  simulation.step(std::vector<float>(4, 0.1f));
  EXPECT_NE(simulation.image(0)[0], pixels[0]);
  simulation.restore(saved);
  EXPECT_EQ(simulation.image(0)[0], pixels[0]);
}

TEST(ObservationBatch, ABatchWithoutPrivilegedColumnsHasNone) {
  Pool envs(test::small_env(), {});
  envs.send_reset();
  const auto batch = envs.recv();
  EXPECT_EQ(batch->width.privileged, 0);
  EXPECT_TRUE(batch->privileged.empty());
}

}  // namespace
}  // namespace skybody
