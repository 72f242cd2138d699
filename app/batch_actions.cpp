#include "app/batch_actions.h"

#include "core/base/math/random.h"
#include "core/base/system/error.h"
#include "core/policy/hold/hold_policy.h"

namespace skybody {
namespace {

constexpr std::size_t kMoreRows =
    61;  // more rows than a batch, so that the actions of an environment change

/// The hold policy's action after the robots have settled. Its first action, if kept, would turn
/// them over.
std::vector<float> hold_row(const std::shared_ptr<const CompiledScenario>& compiled) {
  constexpr double kSettle = 5.0;  // [s]
  Simulation simulation(compiled, 0, 0);
  simulation.reset();
  std::vector<float> row(static_cast<std::size_t>(simulation.action_size()));
  HoldPolicy policy(*compiled);
  while (simulation.time() < kSettle && !simulation.done()) {
    policy.act(simulation, row);
    simulation.step(row);
  }
  return row;
}

}  // namespace

const std::vector<std::string>& BatchActions::names() {
  static const std::vector<std::string> names = {"hold", "zero", "random"};
  return names;
}

BatchActions::BatchActions(const std::string& name,
                           const std::shared_ptr<const CompiledScenario>& compiled, int rows)
    : width_(static_cast<std::size_t>(compiled->action_size())),
      rows_(static_cast<std::size_t>(rows) + kMoreRows),
      table_(rows_ * width_) {
  if (name == "hold") {
    const std::vector<float> row = hold_row(compiled);
    for (std::size_t k = 0; k < table_.size(); ++k) table_[k] = row[k % width_];
  } else if (name == "random") {
    Random<double> random(RandomKey{0, 0}, 0, 0, derive_stream("bench.action"));
    for (float& value : table_) value = static_cast<float>(random.uniform(-1.0, 1.0));
  } else {
    SKYBODY_DEMAND(name == "zero", "no actions " + name);
  }
}

std::span<const float> BatchActions::next(std::size_t rows) {
  const std::size_t first = turn_;
  turn_ = (turn_ + 1) % (kMoreRows + 1);
  return std::span<const float>(table_).subspan(first * width_, rows * width_);
}

}  // namespace skybody
