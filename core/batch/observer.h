// Interface for observers of all events in a Pool, such as a recorder.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/batch/batch.h"
#include "core/env/param_request.h"

namespace skybody {

class EnvironmentStates;

/// The arguments of Pool::request() or Pool::randomize().
struct PoolRequest {
  std::span<const ParamChange> changes;
  bool redraws = false;  ///< all randomizers draw
  RequestTime when = RequestTime::kNextStep;
  std::span<const std::int32_t> env_ids;  ///< empty: all
};

/// Receives, in order, every event that determines the environments' future, after it was done, and
/// every batch that recv() returns. Called on the thread that calls the Pool. An exception from a
/// method propagates out of the Pool's method, whose work is then complete.
class PoolObserver {
 public:
  virtual ~PoolObserver() = default;

  /// Resets were sent to the environments whose byte in `mask` is not 0.
  virtual void reset_sent(std::span<const std::uint8_t> /*mask*/) {}
  /// All environments were initialized with another seed, and resets were sent to all.
  virtual void reseeded(std::uint64_t /*seed*/) {}
  /// One action row each was sent to these environments; no ids: all, in order.
  virtual void actions_sent(std::span<const float> /*actions*/,
                            std::span<const std::int32_t> /*env_ids*/) {}
  /// `saved` is the argument of Pool::restore().
  virtual void restored(std::span<const std::uint64_t> /*saved*/) {}
  virtual void forked(int /*source*/, std::span<const std::int32_t> /*targets*/, bool /*rekey*/) {}
  virtual void param_set(int /*env*/, const std::string& /*path*/, double /*value*/) {}
  virtual void requested(const PoolRequest& /*request*/) {}
  /// Called before recv() returns these rows. `states` contains the state words and hashes of their
  /// environments; no thread changes these during the call.
  virtual void received(const Batch& rows, const EnvironmentStates& states) = 0;
};

}  // namespace skybody
