// Needs: a batch moves every row in every step, so whole groups must be fast. A lane must get the
// same bits alone and beside others.
//
// Idea: whole blocks of eight lanes (core/base/simd/lane_mask.h) are processed in packs. Every
// other lane is processed alone, by the same template with Real = double. Only rows of floats need
// separate code for packs: four values of several lanes are transposed in registers.
//
// Limits: groups have 1 or kGroupLanes lanes. Only the latter have blocks of eight lanes, so the
// stride between values is a constant wherever packs are used.
#include "core/env/row_conversion.h"

#include <algorithm>
#include <cstring>

#include "core/base/math/math_basic.h"
#include "core/base/simd/kernels.h"
#include "core/base/simd/lane_mask.h"
#include "core/base/simd/pack.h"
#include "core/model/state_layout.h"
#include "core/physics/world/lane_values.h"

namespace skybody {
namespace {

// A piece of a table: W lanes times four values, transposed in registers. Two pieces of four lanes,
// or one of eight, form a block of eight lanes.
template <int W>
struct FloatPack;
template <>
struct FloatPack<4> {
  typedef float Native __attribute__((vector_size(16)));
};
template <>
struct FloatPack<8> {
  typedef float Native __attribute__((vector_size(32)));
};
template <int W>
using Floats = typename FloatPack<W>::Native;
/// Lanes of a piece, on an instruction set with packs of W doubles.
template <int W>
inline constexpr int kPiece = std::max(4, W);

template <class Vector>
SKYBODY_INLINE void load(const float* p, Vector& v) {
  std::memcpy(&v, p, sizeof(v));
}
template <class Vector>
SKYBODY_INLINE void store(float* p, const Vector& v) {
  std::memcpy(p, &v, sizeof(v));
}

/// Calls f(first lane, Real) for the lanes of a mask: whole blocks of eight lanes in packs of W,
/// the rest lane by lane, as double.
template <int W, class F>
SKYBODY_INLINE void serve(std::uint32_t mask, F&& f) {
  const std::uint32_t octets = whole_octets(mask);
  each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
    for (int l = first; l < first + kOctet; l += W) f(l, Pack<W>());
  });
  each_lane(mask & ~octets, [&](int lane) SKYBODY_INLINE_LAMBDA { f(lane, 0.0); });
}

/// The lanes of a mask that satisfy a predicate. octet(first lane) tests whole blocks of eight
/// lanes; lane(lane) tests all others, and the lanes of blocks that fail.
template <class Octet, class Lane>
SKYBODY_INLINE std::uint32_t lanes_where(std::uint32_t mask, Octet&& octet, Lane&& lane) {
  std::uint32_t those = 0;
  each_octet(whole_octets(mask), [&](int first) SKYBODY_INLINE_LAMBDA {
    if (octet(first)) those |= 0xffu << first;
  });
  each_lane(mask & ~those, [&](int l) SKYBODY_INLINE_LAMBDA {
    if (lane(l)) those |= 1u << l;
  });
  return those;
}

/// The same if octet(first lane, bits) can also test some lanes of a block of eight, given by
/// `bits`. This is cheaper than lane by lane from two lanes on.
template <class Octet, class Lane>
SKYBODY_INLINE std::uint32_t lanes_where_some(std::uint32_t mask, int lanes, Octet&& octet,
                                              Lane&& lane) {
  std::uint32_t those = 0;
  for (int first = 0; first < lanes && lanes > 1; first += kOctet) {
    const std::uint32_t bits = mask >> first & 0xffu;
    if ((bits & (bits - 1)) != 0 && octet(first, bits)) those |= bits << first;
  }
  each_lane(mask & ~those, [&](int l) SKYBODY_INLINE_LAMBDA {
    if (lane(l)) those |= 1u << l;
  });
  return those;
}

// Transposes columns a, b, c, d of four lanes to rows a0 b0 c0 d0, a1 b1 c1 d1, ...; and back. With
// eight lanes, row i is followed by row i + 4.
SKYBODY_INLINE void transpose(Floats<4> (&v)[4]) {
  const Floats<4> a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
  const Floats<4> b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
  const Floats<4> c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Floats<4> d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}
SKYBODY_INLINE void transpose(Floats<8> (&v)[4]) {
  const Floats<8> a = __builtin_shufflevector(v[0], v[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats<8> b = __builtin_shufflevector(v[2], v[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats<8> c = __builtin_shufflevector(v[0], v[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const Floats<8> d = __builtin_shufflevector(v[2], v[3], 2, 10, 3, 11, 6, 14, 7, 15);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// Four values of lane i, and of lane i + 4 if there are eight.
SKYBODY_INLINE void load_rows(const float* row, std::ptrdiff_t, Floats<4>& v) { load(row, v); }
SKYBODY_INLINE void load_rows(const float* row, std::ptrdiff_t stride, Floats<8>& v) {
  Floats<4> low, high;
  load(row, low);
  load(row + 4 * stride, high);
  v = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
/// @param bits  the rows to write: bit 0 and bit 4
SKYBODY_INLINE void store_rows(float* row, std::ptrdiff_t, const Floats<4>& v, std::uint32_t bits) {
  if ((bits & 1u) != 0) store(row, v);
}
SKYBODY_INLINE void store_rows(float* row, std::ptrdiff_t stride, const Floats<8>& v,
                               std::uint32_t bits) {
  if ((bits & 1u) != 0) store(row, __builtin_shufflevector(v, v, 0, 1, 2, 3));
  if ((bits & 16u) != 0) store(row + 4 * stride, __builtin_shufflevector(v, v, 4, 5, 6, 7));
}

template <class Vector>
SKYBODY_INLINE void to_floats(const double* lanes, Vector& v) {
  constexpr int W = sizeof(Vector) / sizeof(float);
  v = __builtin_convertvector(load_lanes<Pack<W>>(lanes).v, Vector);
}

/// Whether a float, or each float of a vector, is finite. Applied to a sum: if the sum is finite,
/// so are all its terms. (Finite terms with a sum that is not finite are rare: then each is
/// tested.)
SKYBODY_INLINE bool is_finite(float value) { return value - value == 0.0f; }
template <class Vector>
SKYBODY_INLINE bool is_finite(const Vector& sum) {
  float lanes[sizeof(Vector) / sizeof(float)];
  store(lanes, Vector(sum - sum));
  float faults = 0.0f;
  for (const float lane : lanes) faults += lane;
  return faults == 0.0f;
}

/// Whether the sum of all values of eight rows is finite.
SKYBODY_INLINE bool are_rows_finite(const float* rows, std::ptrdiff_t stride, int count) {
  Floats<4> sum{};
  float rest = 0.0f;
  for (int l = 0; l < kOctet; ++l, rows += stride) {
    int k = 0;
    for (; k + 4 <= count; k += 4) {
      Floats<4> v;
      load(rows + k, v);
      sum += v;
    }
    for (; k < count; ++k) rest += rows[k];
  }
  return is_finite(sum) && is_finite(rest);
}

SKYBODY_INLINE bool is_row_finite(const float* row, int count) {
  for (int k = 0; k < count; ++k) {
    if (!is_finite(row[k])) return false;
  }
  return true;
}

template <class Real>
SKYBODY_INLINE Real clipped(const Real& value) {
  return clamp(value, Real(-1.0), Real(1.0));
}

/// One lane's values from index k on.
SKYBODY_INLINE void read_row(const float* row, int lanes, int k, int count, double* values) {
  for (; k < count; ++k) values[k * lanes] = clipped(static_cast<double>(row[k]));
}

template <int W>
SKYBODY_INLINE void read_octet(const float* rows, std::ptrdiff_t stride, int count,
                               double* values) {
  for (int first = 0; first < kOctet; first += W) {
    const float* row = rows + first * stride;
    double* out = values + first;
    int k = 0;
    for (; k + 4 <= count; k += 4) {
      Floats<W> v[4];
      for (int i = 0; i < 4; ++i) load_rows(row + i * stride + k, stride, v[i]);
      transpose(v);
      for (int i = 0; i < 4; ++i) {
        const Pack<W> a(__builtin_convertvector(v[i], typename Pack<W>::Native));
        store_lanes(out + (k + i) * kGroupLanes, clipped(a));
      }
    }
    for (int i = 0; i < W; ++i) read_row(row + i * stride, kGroupLanes, k, count, out + i);
  }
}

struct ReadClippedActions {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(std::uint32_t mask, int lanes, const float* rows,
                                          std::ptrdiff_t stride, int count, double* values) {
    const auto octet = [&](int first) SKYBODY_INLINE_LAMBDA {
      const float* row = rows + first * stride;
      const bool finite = are_rows_finite(row, stride, count);
      if (finite) read_octet<kPiece<W>>(row, stride, count, values + first);
      return finite;
    };
    const auto lane = [&](int l) SKYBODY_INLINE_LAMBDA {
      const float* row = rows + l * stride;
      const bool finite = is_row_finite(row, count);
      if (finite) read_row(row, lanes, 0, count, values + l);
      return finite;
    };
    return lanes_where(mask, octet, lane);
  }
};

struct Scale {
  template <int W>
  static SKYBODY_INLINE void run(std::uint32_t mask, int lanes, const double* action, int count,
                                 const double* low, const double* high, double* command) {
    for (int k = 0; k < count; ++k, action += lanes, command += lanes) {
      const double from = low[k], range = high[k] - low[k];
      serve<W>(mask, [&]<class Real>(int l, const Real&) SKYBODY_INLINE_LAMBDA {
        const Real a = load_lanes<Real>(action + l);
        store_lanes(command + l, Real(from) + 0.5 * (a + 1.0) * Real(range));
      });
    }
  }
};

struct Copy {
  template <int W>
  static SKYBODY_INLINE void run(std::uint32_t mask, const double* from, int count, double* to) {
    const std::uint32_t octets = whole_octets(mask);
    if (mask == octets) return copy_octets<W>(octets, from, count, to);
    for (int first = 0; first < kGroupLanes; first += W) {
      const std::uint32_t bits = (mask >> first) & ((1u << W) - 1u);
      if (bits == 0) continue;
      const Mask<W> some = mask_from_bits<Pack<W>>(bits);
      for (int k = 0; k < count; ++k) {
        const int at = k * kGroupLanes + first;
        store_lanes(to + at, load_lanes<Pack<W>>(from + at), some);
      }
    }
  }

 private:
  /// The common case: no masks, value after value in memory order.
  template <int W>
  static SKYBODY_INLINE void copy_octets(std::uint32_t octets, const double* from, int count,
                                         double* to) {
    for (int k = 0; k < count; ++k, from += kGroupLanes, to += kGroupLanes) {
      each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
        for (int l = first; l < first + kOctet; l += W) {
          store_lanes(to + l, load_lanes<Pack<W>>(from + l));
        }
      });
    }
  }
};

struct Fill {
  template <int W>
  static SKYBODY_INLINE void run(std::uint32_t mask, int lanes, const double* values, int size,
                                 int count, double* to) {
    const double* const end = values + size;
    const double* value = values;
    for (int k = 0; k < count; ++k, to += lanes) {
      serve<W>(mask, [&]<class Real>(int l, const Real&)
                         SKYBODY_INLINE_LAMBDA { store_lanes(to + l, Real(*value)); });
      if (++value == end) value = values;
    }
  }
};

struct Multiples {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(std::uint32_t mask, const std::uint64_t* counts,
                                          double period) {
    const double inverse = 1.0 / period;
    std::uint32_t multiples = 0;
    serve<W>(mask, [&]<class Real>(int l, const Real&) SKYBODY_INLINE_LAMBDA {
      const Real count = to_real(load_words<Real>(counts + l));
      // For a multiple, the product is the quotient up to a relative error of 2^-52; the test
      // itself is exact.
      const Real quotient = round_half_even(count * inverse);
      multiples |= bits_from_mask(quotient * period == count) << l;
    });
    return multiples;
  }
};

struct Count {
  template <int W>
  static SKYBODY_INLINE void run(std::uint32_t mask, std::uint64_t* words) {
    serve<W>(mask, [&]<class Real>(int l, const Real&) SKYBODY_INLINE_LAMBDA {
      store_words(words + l, load_words<Real>(words + l) + 1);
    });
  }
};

template <int W>
SKYBODY_INLINE bool is_octet_finite(const double* values, int count) {
  Floats<W> sum{};
  for (int k = 0; k < count; ++k) {
    for (int l = 0; l < kOctet; l += W) {
      Floats<W> v;
      to_floats(values + k * kGroupLanes + l, v);
      sum += v;
    }
  }
  return is_finite(sum);
}

struct AreFinite {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(std::uint32_t mask, int lanes, const double* values,
                                          int count) {
    const auto octet = [&](int first) SKYBODY_INLINE_LAMBDA {
      return is_octet_finite<kPiece<W>>(values + first, count);
    };
    const auto lane = [&](int l) SKYBODY_INLINE_LAMBDA {
      for (int k = 0; k < count; ++k) {
        if (!is_finite(static_cast<float>(values[k * lanes + l]))) return false;
      }
      return true;
    };
    return lanes_where(mask, octet, lane);
  }
};

/// Writes a run of the values of a block of eight lanes to its rows, and adds them to `sum`.
/// @param bits  the lanes whose rows are written
template <int W>
SKYBODY_INLINE void write_run(const double* values, int size, const ValueRun& run, float* rows,
                              std::uint32_t bits, Floats<W>& sum) {
  const int last = run.first + run.count;
  for (int first = 0; first < kOctet; first += W) {
    const double* in = values + first;
    float* row = rows + static_cast<std::ptrdiff_t>(first) * size;
    const auto write_four = [&](int k) SKYBODY_INLINE_LAMBDA {
      Floats<W> v[4];
      for (int i = 0; i < 4; ++i) {
        to_floats(in + (k + i) * kGroupLanes, v[i]);
        sum += v[i];
      }
      transpose(v);
      for (int i = 0; i < 4; ++i) store_rows(row + i * size + k, size, v[i], bits >> first >> i);
    };
    int k = run.first;
    for (; k + 4 <= last; k += 4) write_four(k);
    if (k < last && run.count >= 4) {
      write_four(last - 4);  // writes some values twice
      continue;
    }
    for (; k < last; ++k) {
      Floats<W> v;
      to_floats(in + k * kGroupLanes, v);
      sum += v;
      if (size == 1 && bits == 0xffu) {
        store(row, v);
      } else {
        for (int i = 0; i < W; ++i) {
          if ((bits >> first >> i & 1u) != 0) row[i * size + k] = v[i];
        }
      }
    }
  }
}

/// Copies N floats.
template <int N>
SKYBODY_INLINE void copy_floats(const float* from, float* to) {
  Floats<N> v;
  load(from, v);
  store(to, v);
}
/// Copies N floats or more; the last ones may be copied twice.
template <int N>
SKYBODY_INLINE void copy_by(const float* from, int count, float* to) {
  for (int k = 0; k + N < count; k += N) copy_floats<N>(from + k, to + k);
  copy_floats<N>(from + count - N, to + count - N);
}

/// Copies within rows of `size` values.
/// @param bits  the rows to copy in
SKYBODY_INLINE void copy_within(const ValueCopy& copy, std::uint32_t bits, int size, float* rows) {
  const auto each_row = [&](const auto& f) SKYBODY_INLINE_LAMBDA {
    if (bits == 0xffu) {
      float* row = rows;
      for (int l = 0; l < kOctet; ++l, row += size) f(row + copy.from, row + copy.to);
    } else {
      each_lane(bits, [&](int l) SKYBODY_INLINE_LAMBDA {
        float* row = rows + static_cast<std::ptrdiff_t>(l) * size;
        f(row + copy.from, row + copy.to);
      });
    }
  };
  if (copy.count == 12) {  // velocity and rotation of a teammate
    each_row([](const float* from, float* to) SKYBODY_INLINE_LAMBDA {
      copy_floats<8>(from, to);
      copy_floats<4>(from + 8, to + 8);
    });
  } else if (copy.count >= 8) {
    each_row([&](const float* from, float* to)
                 SKYBODY_INLINE_LAMBDA { copy_by<8>(from, copy.count, to); });
  } else if (copy.count >= 4) {
    each_row([&](const float* from, float* to)
                 SKYBODY_INLINE_LAMBDA { copy_by<4>(from, copy.count, to); });
  } else {
    each_row([&](const float* from, float* to)
                 SKYBODY_INLINE_LAMBDA { std::copy_n(from, copy.count, to); });
  }
}
SKYBODY_INLINE void copy_parts(const RowParts& parts, float* row) {
  for (const ValueCopy& copy : parts.copies) copy_within(copy, 1u, parts.size, row);
}

struct Write {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(std::uint32_t mask, int lanes, const double* values,
                                          int count, float* rows) {
    const auto octet = [&](int first) SKYBODY_INLINE_LAMBDA {
      Floats<kPiece<W>> sum{};
      float* row = rows + static_cast<std::ptrdiff_t>(first) * count;
      write_run<kPiece<W>>(values + first, count, {0, count}, row, 0xffu, sum);
      return is_finite(sum);
    };
    const auto lane = [&](int l) SKYBODY_INLINE_LAMBDA {
      float* row = rows + static_cast<std::ptrdiff_t>(l) * count;
      for (int k = 0; k < count; ++k) row[k] = static_cast<float>(values[k * lanes + l]);
      return is_row_finite(row, count);
    };
    return lanes_where(mask, octet, lane);
  }
};

struct WriteParts {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(std::uint32_t mask, int lanes, const double* values,
                                          const RowParts& parts, float* rows) {
    const auto rows_of = [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
      Floats<kPiece<W>> sum{};
      float* own = rows + static_cast<std::ptrdiff_t>(first) * parts.size;
      for (const RowPiece& piece : parts.pieces) {
        write_run<kPiece<W>>(values + first, parts.size, piece.written, own, bits, sum);
        copy_within(piece.copied, bits, parts.size, own);
      }
      return is_finite(sum);  // else lanes are tested one by one
    };
    const auto octet = [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
      return bits == 0xffu ? rows_of(first, 0xffu) : rows_of(first, bits);
    };
    const auto lane = [&](int l) SKYBODY_INLINE_LAMBDA {
      float* row = rows + static_cast<std::ptrdiff_t>(l) * parts.size;
      for (const ValueRun& run : parts.written) {
        for (int k = run.first; k < run.first + run.count; ++k) {
          row[k] = static_cast<float>(values[k * lanes + l]);
        }
      }
      copy_parts(parts, row);
      return is_row_finite(row, parts.size);
    };
    return lanes_where_some(mask, lanes, octet, lane);
  }
};

struct End {
  template <int W>
  static SKYBODY_INLINE void run(std::uint32_t mask, const std::uint64_t* by_task,
                                 const std::uint64_t* step, std::uint64_t horizon,
                                 std::uint64_t* status, std::uint64_t* rows) {
    const std::uint64_t last = horizon > 0 ? horizon : std::uint64_t{1} << 62;
    serve<W>(mask, [&]<class Real>(int l, const Real&) SKYBODY_INLINE_LAMBDA {
      using Words = Word<Real>;
      // All ones if the step is not below the last: their difference has no sign bit then.
      const Words over = ((load_words<Real>(step + l) - Words(last)) >> 63) - 1;
      const Words result = (load_words<Real>(by_task + l) & int{kTerminated | kTruncated}) |
                           (over & Words(int{kTruncated}));
      store_words(status + l, result);
      store_words(rows + l, result);
    });
  }
};

}  // namespace

void RowParts::set_pieces() {
  const auto is_source = [this](const ValueRun& run) {
    return std::any_of(copies.begin(), copies.end(), [&run](const ValueCopy& copy) {
      return copy.from < run.first + run.count && run.first < copy.from + copy.count;
    });
  };
  pieces.clear();
  for (const ValueRun& run : written) {
    if (is_source(run)) pieces.push_back({run, {}});
  }
  auto copy = copies.begin();
  for (const ValueRun& run : written) {
    for (; copy != copies.end() && copy->to < run.first; ++copy) pieces.push_back({{}, *copy});
    if (is_source(run)) continue;
    pieces.push_back({run, {}});
    if (copy != copies.end() && copy->to == run.first + run.count) pieces.back().copied = *copy++;
  }
  for (; copy != copies.end(); ++copy) pieces.push_back({{}, *copy});
}

void copy_repeats(const RowParts& parts, float* row) { copy_parts(parts, row); }

RowKernels row_kernels(Isa isa) {
  return {kernel<ReadClippedActions>(isa),
          kernel<Scale>(isa),
          kernel<Copy>(isa),
          kernel<Fill>(isa),
          kernel<Multiples>(isa),
          kernel<Count>(isa),
          kernel<AreFinite>(isa),
          kernel<Write>(isa),
          kernel<WriteParts>(isa),
          kernel<End>(isa)};
}

const RowKernels& row_kernels() {
  static const RowKernels chosen = row_kernels(best_isa());
  return chosen;
}

}  // namespace skybody
