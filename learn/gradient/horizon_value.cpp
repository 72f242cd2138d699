#include "learn/gradient/horizon_value.h"

#include <algorithm>

#include "core/physics/world/lane_values.h"

namespace skybody::learn {
namespace {

/// Rows per pass through the network. Constant except for the last pass, so that only the first
/// call allocates.
constexpr int kChunk = 256;

}  // namespace

HorizonValue::HorizonValue(const ValueFunction& value, const Hyperparameters& hyper, int stride,
                           double weight, int most_rows)
    : value_(value),
      stride_(stride),
      discount_(hyper.discount),
      lambda_(hyper.gae_lambda),
      weight_(weight),
      rows_(static_cast<std::size_t>(most_rows) * static_cast<std::size_t>(stride)),
      targets_(static_cast<std::size_t>(most_rows)),
      gradient_(value.network().parameter_count()),
      unused_gradient_(value.network().parameter_count()),
      slopes_(static_cast<std::size_t>(kGroupLanes) * static_cast<std::size_t>(stride)),
      output_(kChunk),
      error_(kChunk) {
  const auto steps = static_cast<std::size_t>(hyper.rollout_steps);
  before_.resize(steps * kGroupLanes);
  after_end_.resize(kGroupLanes);
  for (std::vector<double>* values : {&lane_gain_, &lane_value_, &lane_target_}) {
    values->resize(steps);
  }
  // Runs the largest call once, so that later ones allocate nothing.
  std::vector<float> zeros(static_cast<std::size_t>(kChunk) * static_cast<std::size_t>(stride));
  value_.network().forward(value_.target_parameters(), zeros.data(), stride_, kChunk, memory_,
                           output_.data(), 1);
}

const float* HorizonValue::slopes(const float* end) {
  value_.network().forward(value_.target_parameters(), end, stride_, kGroupLanes, memory_,
                           output_.data(), 1);
  unused_gradient_.fill_zero();
  std::fill_n(error_.data(), kGroupLanes, static_cast<float>(value_.scale()));
  value_.network().backward(value_.delayed_transposed(), end, stride_, memory_, error_.data(), 1,
                            {unused_gradient_.data(), unused_gradient_.size()}, slopes_.data(),
                            stride_);
  return slopes_.data();
}

void HorizonValue::evaluate(const float* rows, int count, double* values) {
  for (int first = 0; first < count; first += kChunk) {
    const int some = std::min(kChunk, count - first);
    value_.network().forward(value_.target_parameters(), rows + std::ptrdiff_t{1} * first * stride_,
                             stride_, some, memory_, output_.data(), 1);
    for (int k = 0; k < some; ++k) {
      values[first + k] =
          value_.scale() * static_cast<double>(output_[static_cast<std::size_t>(k)]);
    }
  }
}

void HorizonValue::add(const HorizonRows& rows) {
  evaluate(rows.observation, rows.steps * kGroupLanes, before_.data());
  evaluate(rows.end, kGroupLanes, after_end_.data());
  for (int l = 0; l < kGroupLanes; ++l) add_lane(rows, l);
}

void HorizonValue::add_lane(const HorizonRows& rows, int lane) {
  const auto is_taken = [&](int t) {
    return t < rows.steps && (rows.taken[static_cast<std::size_t>(t)] >> lane & 1u) != 0;
  };
  const auto at = [&](int t) { return static_cast<std::size_t>(t * kGroupLanes + lane); };
  int steps = 0;
  for (; is_taken(steps); ++steps) {
    const auto t = static_cast<std::size_t>(steps);
    lane_gain_[t] = rows.gain[at(steps)];
    const bool is_worthless = (rows.worthless >> lane & 1u) != 0;
    lane_value_[t] = is_taken(steps + 1) ? before_[at(steps + 1)]
                     : is_worthless      ? 0.0
                                         : after_end_[static_cast<std::size_t>(lane)];
  }
  const auto count = static_cast<std::size_t>(steps);
  td_lambda({lane_gain_.data(), count}, {lane_value_.data(), count}, discount_, lambda_,
            {lane_target_.data(), count});
  for (int t = 0; t < steps; ++t) {
    const auto row = static_cast<std::size_t>(count_++);
    std::copy_n(rows.observation + at(t) * static_cast<std::size_t>(rows.stride), stride_,
                rows_.data() + row * static_cast<std::size_t>(stride_));
    targets_[row] = static_cast<float>(lane_target_[static_cast<std::size_t>(t)] / value_.scale());
  }
}

void HorizonValue::find_gradient() {
  gradient_.fill_zero();
  loss_ = 0.0;
  for (int first = 0; first < count_; first += kChunk) {
    const int some = std::min(kChunk, count_ - first);
    const float* x = rows_.data() + static_cast<std::ptrdiff_t>(first) * stride_;
    value_.network().forward(value_.parameters(), x, stride_, some, memory_, output_.data(), 1);
    for (int k = 0; k < some; ++k) {
      const auto row = static_cast<std::size_t>(k);
      const double error = static_cast<double>(output_[row]) -
                           static_cast<double>(targets_[static_cast<std::size_t>(first + k)]);
      error_[row] = static_cast<float>(weight_ * error);
      loss_ += 0.5 * weight_ * error * error;
    }
    value_.network().backward(value_.transposed(), x, stride_, memory_, error_.data(), 1,
                              {gradient_.data(), gradient_.size()});
  }
}

}  // namespace skybody::learn
