// Batches, actions and states as Eigen matrices with a row for each environment, without copies.
// Header only; your project brings Eigen (find_package(Eigen3), version 3.4).
//
// A map does not own its memory. A map of a Batch is valid as long as the batch's shared_ptr is
// held, a map of a span as long as the span's values exist.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <type_traits>

#include "core/base/system/arguments.h"
#include "core/batch/batch.h"

namespace skybody {

/// A row for each environment; the values of a row are contiguous.
template <class Scalar>
using RowMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A map of values, writable unless they are const.
template <class Scalar>
using RowMap =
    Eigen::Map<std::conditional_t<std::is_const_v<Scalar>,
                                  const RowMatrix<std::remove_const_t<Scalar>>, RowMatrix<Scalar>>>;

/// Maps values as rows, such as the output of Pool::state().
/// @throws Error unless there are rows * width values
template <class Scalar>
RowMap<Scalar> row_map(std::span<Scalar> values, int rows, int width) {
  check_values("values", values.size(), static_cast<std::size_t>(rows), width);
  return {values.data(), rows, width};
}

/// The values of a matrix of rows: actions for Pool::send(), memory for Pool::state().
template <class Scalar>
std::span<Scalar> values_of(RowMatrix<Scalar>& rows) {
  return {rows.data(), static_cast<std::size_t>(rows.size())};
}
template <class Scalar>
std::span<const Scalar> values_of(const RowMatrix<Scalar>& rows) {
  return {rows.data(), static_cast<std::size_t>(rows.size())};
}

/// Observations of a batch: rows x observation_size().
inline RowMap<const float> observations(const Batch& batch) {
  return {batch.observation.data(), batch.rows, batch.width.observation};
}

/// Privileged rows of a batch, for the critic only: rows x privileged_size().
inline RowMap<const float> privileged(const Batch& batch) {
  return {batch.privileged.data(), batch.rows, batch.width.privileged};
}

/// Info values of a batch: rows x info_size(), rows x 0 without PoolOptions::info.
inline RowMap<const float> infos(const Batch& batch) {
  return {batch.info.data(), batch.rows, batch.width.info};
}

/// Rewards of a batch, one per row.
inline Eigen::Map<const Eigen::VectorXf> rewards(const Batch& batch) {
  return {batch.reward.data(), batch.rows};
}

/// Rewards of the agents of a batch: rows x agents.
inline RowMap<const float> agent_rewards(const Batch& batch) {
  return {batch.agent_reward.data(), batch.rows, batch.width.agents};
}

}  // namespace skybody
