#include "core/derivative/sparse_jacobian.h"

#include <algorithm>
#include <cstring>

#include "core/base/simd/isa.h"
#include "core/base/simd/kernels.h"
#include "core/base/simd/pack.h"

namespace skybody {
namespace {

/// sum += a b, in lanes.
struct AddProduct {
  template <int W>
  static SKYBODY_INLINE void run(std::uint32_t lanes, const double* a, const double* b,
                                 double* sum) {
    for (int l = 0; l < kGroupLanes; l += W) {
      using Real = Pack<W>;
      const auto mask = mask_from_bits<Real>(lanes >> l);
      store_lanes(sum + l,
                  load_lanes<Real>(sum + l) + load_lanes<Real>(a + l) * load_lanes<Real>(b + l),
                  mask);
    }
  }
};

}  // namespace

bool SparseJacobian::is_touched(const double* tangents, std::uint32_t lanes) {
  for (int l = 0; l < kGroupLanes; ++l) {
    if ((lanes >> l & 1u) != 0 && tangents[l] != 0.0) return true;
  }
  return false;
}

void SparseJacobian::note(std::size_t input, std::size_t output) {
  if (depends_.empty()) depends_.assign(inputs_.size(), std::vector<bool>(outputs_.size()));
  depends_[input][output] = true;
}

void SparseJacobian::seed(DualGroup& group, std::span<const int> rows, double tangent) const {
  for (const int row : rows) std::fill_n(group.tangent(row), kGroupLanes, tangent);
}

void SparseJacobian::clear(DualGroup& group) const {
  for (const int row : inputs_) std::fill_n(group.tangent(row), kGroupLanes, 0.0);
  for (const int row : outputs_) std::fill_n(group.tangent(row), kGroupLanes, 0.0);
}

void SparseJacobian::clear(DualGroup& group, const Set& set) {
  for (const int row : set.columns)
    std::memset(group.tangent(row), 0, kGroupLanes * sizeof(double));
  for (const Entry& e : set.entries) {
    std::memset(group.tangent(e.output), 0, kGroupLanes * sizeof(double));
  }
}

bool SparseJacobian::depends_on(std::span<const int> rows) const {
  for (const Set& set : sets_) {
    for (const int column : set.columns) {
      if (std::find(rows.begin(), rows.end(), column) != rows.end()) return true;
    }
  }
  return false;
}

bool SparseJacobian::changes(int row) const {
  for (const Set& set : sets_) {
    for (const Entry& e : set.entries) {
      if (e.output == row && e.input != row) return true;
    }
  }
  return false;
}

void SparseJacobian::color_columns() {
  sets_.clear();
  taken_ = AlignedArray<double>(outputs_.size() * kGroupLanes);
  std::vector<std::vector<bool>> used;  // outputs of each set
  for (std::size_t i = 0; i < depends_.size(); ++i) {
    const auto& column = depends_[i];
    if (std::find(column.begin(), column.end(), true) == column.end()) continue;
    std::size_t s = 0;
    const auto clashes = [&](const std::vector<bool>& taken) {
      for (std::size_t o = 0; o < column.size(); ++o) {
        if (column[o] && taken[o]) return true;
      }
      return false;
    };
    while (s < used.size() && clashes(used[s])) ++s;
    if (s == used.size()) {
      used.emplace_back(column.size());
      sets_.emplace_back();
    }
    sets_[s].columns.push_back(inputs_[i]);
    for (std::size_t o = 0; o < column.size(); ++o) {
      if (!column[o]) continue;
      used[s][o] = true;
      sets_[s].entries.push_back({inputs_[i], outputs_[o], static_cast<int>(o)});
    }
  }
}

void SparseJacobian::take_outputs(std::uint32_t lanes, double* adjoints) {
  for (std::size_t o = 0; o < outputs_.size(); ++o) {
    double* const row = adjoints + static_cast<std::ptrdiff_t>(outputs_[o]) * kGroupLanes;
    double* const taken = taken_.data() + o * kGroupLanes;
    for (int l = 0; l < kGroupLanes; ++l) {
      const bool is_served = (lanes >> l & 1u) != 0;
      taken[l] = is_served ? row[l] : 0.0;
      row[l] = is_served ? 0.0 : row[l];
    }
  }
}

void SparseJacobian::add(const DualGroup& group, const Set& set, std::uint32_t lanes,
                         double* adjoints) const {
  static const auto add_product = kernel<AddProduct>(best_isa());
  for (const Entry& e : set.entries) {
    add_product(lanes, group.tangent(e.output),
                taken_.data() + static_cast<std::ptrdiff_t>(e.place) * kGroupLanes,
                adjoints + static_cast<std::ptrdiff_t>(e.input) * kGroupLanes);
  }
}

}  // namespace skybody
