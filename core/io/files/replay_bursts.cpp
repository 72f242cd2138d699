#include "core/io/files/replay_bursts.h"

#include <algorithm>
#include <array>
#include <string>
#include <type_traits>
#include <vector>

#include "core/io/files/hdf5_reader.h"

namespace skybody {
namespace {

constexpr std::size_t kWindowBytes = 1 << 20;  // of a column; more if one burst is larger

/// Cached rows of one column. Opening a dataset takes far longer than reading a small burst.
struct Window {
  std::size_t rows_in_file = 0, first = 0, count = 0;
  std::vector<unsigned char> bytes;

  bool has(std::size_t from, std::size_t rows) const {
    return from >= first && from - first <= count && rows <= count - (from - first);
  }
};

class BurstReader {
 public:
  BurstReader(const Hdf5Reader& reader, const ReplayHeader& header)
      : reader_(reader), header_(header), chain_(replay_chain(header)) {}

  ReplayRows read() {
    for (std::size_t k = 0; k < kReplayColumnCount; ++k) check_column(k);
    const Hdf5Reader::Shape shape = reader_.shape(kReplayBursts);
    check_width(kReplayBursts, shape.columns, kReplayBurstWidth);
    const auto bursts = reader_.all<std::uint64_t>(kReplayBursts);
    for (std::size_t k = 0; k < shape.rows; ++k) read_burst(k, bursts.data() + k * shape.columns);
    return rows_;
  }

 private:
  void check_column(std::size_t k) {
    const ReplayColumn& column = kReplayColumns[k];
    const std::size_t width = replay_width(header_, column.width);
    if (width == 0) return;
    const Hdf5Reader::Shape shape = reader_.shape(column.path);
    check_width(column.path, shape.columns, width);
    windows_[k].rows_in_file = shape.rows;
  }

  void check_width(const char* path, std::size_t found, std::size_t wanted) const {
    if (found == wanted) return;
    damaged("a row of `" + std::string(path) + "` has " + std::to_string(found) +
            " values, not the " + std::to_string(wanted) + " that were recorded");
  }

  void read_burst(std::size_t number, const std::uint64_t* burst) {
    for (std::size_t k = 0; k < kReplayColumnCount; ++k) {
      if (burst[k] < rows_[k]) {
        damaged("burst " + std::to_string(number) + " counts fewer rows of `" +
                kReplayColumns[k].path + "` than the one before it");
      }
      const std::size_t first = rows_[k], count = static_cast<std::size_t>(burst[k]) - first;
      rows_[k] += count;
      if (replay_width(header_, kReplayColumns[k].width) > 0) {
        add_column(k, first, count);
      }
    }
    if (chain_.value() == burst[kReplayColumnCount]) return;
    damaged("the values of burst " + std::to_string(number) + " are not those that were recorded");
  }

  void add_column(std::size_t k, std::size_t first, std::size_t count) {
    switch (kReplayColumns[k].type) {
      case ReplayType::kU8:
        return add_values<std::uint8_t>(k, first, count);
      case ReplayType::kI32:
        return add_values<std::int32_t>(k, first, count);
      case ReplayType::kU64:
        return add_values<std::uint64_t>(k, first, count);
      case ReplayType::kF32:
        return add_values<float>(k, first, count);
    }
  }

  template <class T>
  void add_values(std::size_t k, std::size_t first, std::size_t count) {
    if (count == 0) return;
    const std::size_t row_bytes = replay_width(header_, kReplayColumns[k].width) * sizeof(T);
    if (!windows_[k].has(first, count)) slide<T>(k, first, count, row_bytes);
    const Window& window = windows_[k];
    add_burst(chain_, first + count, window.bytes.data() + (first - window.first) * row_bytes,
              count * row_bytes);
  }

  /// Moves the window to `first`. Rows beyond the end of the file are rejected before reading.
  template <class T>
  void slide(std::size_t k, std::size_t first, std::size_t count, std::size_t row_bytes) {
    Window& window = windows_[k];
    const std::size_t left = window.rows_in_file - std::min(first, window.rows_in_file);
    window.first = first;
    window.count = std::max(count, std::min(left, kWindowBytes / row_bytes));
    const auto values = reader_.rows<T>(kReplayColumns[k].path, first, window.count);
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    window.bytes.assign(bytes, bytes + values.size() * sizeof(T));
  }

  [[noreturn]] void damaged(const std::string& what) const {
    reader_.fail("this replay is damaged: " + what + "; take another copy");
  }

  const Hdf5Reader& reader_;
  const ReplayHeader& header_;
  HashChain chain_;
  ReplayRows rows_{};
  std::array<Window, kReplayColumnCount> windows_;
};

void add_texts(HashChain& chain, const std::vector<std::string>& texts) {
  chain.update(texts.size());
  for (const std::string& text : texts) chain.update(hash_string(text));
}

}  // namespace

std::size_t replay_width(const ReplayHeader& header, ReplayWidth width) {
  switch (width) {
    case ReplayWidth::kOne:
      break;
    case ReplayWidth::kAction:
      return static_cast<std::size_t>(header.action_size);
    case ReplayWidth::kObservation:
      return header.observation_names.size();
    case ReplayWidth::kState:
      return header.state_names.size();
  }
  return 1;
}

HashChain replay_chain(const ReplayHeader& header) {
  HashChain chain;
  each_replay_field(header, [&](const char*, const auto& field, int = 10) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (std::is_same_v<Field, std::string>) {
      chain.update(hash_string(field));
    } else if constexpr (std::is_integral_v<Field>) {
      chain.update(field);
    } else {
      add_texts(chain, field);
    }
  });
  return chain;
}

void add_burst(HashChain& chain, std::uint64_t rows, const void* values, std::size_t bytes) {
  if (bytes == 0) return;
  chain.update(rows);
  chain.update(hash_bytes(values, bytes));
}

ReplayRows check_bursts(const Hdf5Reader& reader, const ReplayHeader& header) {
  return BurstReader(reader, header).read();
}

}  // namespace skybody
