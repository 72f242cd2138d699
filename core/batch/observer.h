// Whoever wants to know everything that happens in a Pool, such as a recorder.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/batch/batch.h"
#include "core/env/param_request.h"

namespace skybody {

class EnvironmentStates;

/// What Pool::request() or Pool::randomize() asks for.
struct PoolRequest {
  std::span<const ParamChange> changes;
  bool redraws = false;  ///< all randomizers draw
  RequestTime when = RequestTime::kNextStep;
  std::span<const std::int32_t> env_ids;  ///< empty: all
};

/// Told of all that determines the environments' future, in order, after it was done, and of every
/// batch that recv() gives. Called on the thread that calls the Pool. What a method throws comes
/// out of the Pool's method, whose work is done by then.
class PoolObserver {
 public:
  virtual ~PoolObserver() = default;

  /// Resets were sent to the environments whose byte in `mask` is not 0.
  virtual void reset_sent(std::span<const std::uint8_t> /*mask*/) {}
  /// All environments were put at their beginning under another seed, and resets were sent to all.
  virtual void reseeded(std::uint64_t /*seed*/) {}
  /// One action row each was sent to these environments; no ids: all, in order.
  virtual void actions_sent(std::span<const float> /*actions*/,
                            std::span<const std::int32_t> /*env_ids*/) {}
  /// `saved` is what Pool::restore() was given.
  virtual void restored(std::span<const std::uint64_t> /*saved*/) {}
  virtual void forked(int /*source*/, std::span<const std::int32_t> /*targets*/, bool /*rekey*/) {}
  virtual void param_set(int /*env*/, const std::string& /*path*/, double /*value*/) {}
  virtual void requested(const PoolRequest& /*request*/) {}
  /// recv() is about to give these rows. `states` has the state words and hashes of their
  /// environments, which nobody touches now.
  virtual void received(const Batch& rows, const EnvironmentStates& states) = 0;
};

}  // namespace skybody
