// The derivative of a function of a dual group's rows, by few evaluations on dual numbers.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/derivative/dual_group.h"

namespace skybody {

/// Which rows of the results depend on which rows before, found once by trying, and columns put
/// together so that each result depends on one of a set alone: a set's derivatives come from one
/// evaluation (A. R. Curtis, M. J. D. Powell, J. K. Reid, "On the estimation of sparse Jacobian
/// matrices", 1974). Results are rows of the same group: what is overwritten no longer depends on
/// itself.
class SparseJacobian {
 public:
  /// @param inputs   rows that may matter
  /// @param outputs  rows that may change
  SparseJacobian(std::vector<int> inputs, std::vector<int> outputs)
      : inputs_(std::move(inputs)), outputs_(std::move(outputs)) {}

  /// Adds the dependences that show at the group's present values in any of the lanes.
  /// @param call  call() evaluates and leaves inputs' values as they were
  template <class Call>
  void look(DualGroup& group, std::uint32_t lanes, const Call& call) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      seed(group, {&inputs_[i], 1}, 1.0);
      call();
      for (std::size_t o = 0; o < outputs_.size(); ++o) {
        if (is_touched(group.tangent(outputs_[o]), lanes)) note(i, o);
      }
      clear(group);
    }
  }
  /// Takes every dependence for one that may show, so that each input is asked about alone.
  void take_all() { depends_.assign(inputs_.size(), std::vector<bool>(outputs_.size(), true)); }
  /// As if look() had been called as on another map of the same inputs and outputs.
  void copy_sparsity(const SparseJacobian& other) { depends_ = other.depends_; }
  /// Makes the sets. After all look(), before pull_back().
  void color_columns();

  /// From adjoints of all rows after the call to those before it.
  /// @param adjoints  row k at k * kGroupLanes; overwritten in `lanes`
  template <class Call>
  void pull_back(DualGroup& group, std::uint32_t lanes, const Call& call, double* adjoints) {
    take_outputs(lanes, adjoints);
    for (const Set& set : sets_) {
      seed(group, set.columns, 1.0);
      call();
      add(group, set, lanes, adjoints);
      clear(group, set);
    }
  }

  /// Whether anything depends on any of these rows. After color_columns().
  bool depends_on(std::span<const int> rows) const;
  /// Whether a row of the results depends on another row. After color_columns().
  bool changes(int row) const;
  int set_count() const { return static_cast<int>(sets_.size()); }

 private:
  struct Entry {
    int input, output;  ///< rows
    int place;          ///< of the output among outputs_
  };
  struct Set {
    std::vector<int> columns;  ///< rows
    std::vector<Entry> entries;
  };
  static bool is_touched(const double* tangents, std::uint32_t lanes);
  void note(std::size_t input, std::size_t output);
  void seed(DualGroup& group, std::span<const int> rows, double tangent) const;
  void clear(DualGroup& group) const;
  static void clear(DualGroup& group, const Set& set);
  void take_outputs(std::uint32_t lanes, double* adjoints);
  void add(const DualGroup& group, const Set& set, std::uint32_t lanes, double* adjoints) const;

  std::vector<int> inputs_, outputs_;
  std::vector<std::vector<bool>> depends_;  ///< by input, then output
  std::vector<Set> sets_;
  AlignedArray<double> taken_;  ///< adjoints of the outputs
};

}  // namespace skybody
