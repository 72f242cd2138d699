// The derivative of a function of a dual group's rows, by few evaluations on dual numbers.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/derivative/dual_group.h"

namespace skybody {

/// A sparse Jacobian. The dependences of output rows on input rows are found once by trials.
/// Columns are grouped so that each output depends on only one column of a set: one evaluation
/// gives a set's derivatives (A. R. Curtis, M. J. D. Powell, J. K. Reid, "On the estimation of
/// sparse Jacobian matrices", 1974). Outputs are rows of the same group: an overwritten row no
/// longer depends on itself.
class SparseJacobian {
 public:
  /// @param inputs   rows that may matter
  /// @param outputs  rows that may change
  SparseJacobian(std::vector<int> inputs, std::vector<int> outputs)
      : inputs_(std::move(inputs)), outputs_(std::move(outputs)) {}

  /// Adds the dependences visible at the group's present values in any of the lanes.
  /// @param call  call() evaluates the function and leaves the inputs' values unchanged
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
  /// Assumes that every output depends on every input, so that each input is evaluated alone.
  void take_all() { depends_.assign(inputs_.size(), std::vector<bool>(outputs_.size(), true)); }
  /// Copies the dependences found by look() on another map of the same inputs and outputs.
  void copy_sparsity(const SparseJacobian& other) { depends_ = other.depends_; }
  /// Builds the sets. Call it after all look(), before pull_back().
  void color_columns();

  /// Converts adjoints of all rows after the call to adjoints of the rows before it.
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

  /// Whether any output depends on any of these rows. Valid after color_columns().
  bool depends_on(std::span<const int> rows) const;
  /// Whether this output row depends on another row. Valid after color_columns().
  bool changes(int row) const;
  int set_count() const { return static_cast<int>(sets_.size()); }

 private:
  struct Entry {
    int input, output;  ///< rows
    int place;          ///< index of the output within outputs_
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
