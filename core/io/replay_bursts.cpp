#include "core/io/replay_bursts.h"

#include <vector>

#include "core/io/hdf5_reader.h"

namespace skybody {
namespace {

class BurstReader {
 public:
  BurstReader(const Hdf5Reader& reader, const ReplayHeader& header)
      : reader_(reader), header_(header), chain_(replay_chain(header)) {}

  ReplayRows read() {
    for (const ReplayColumn& column : kReplayColumns) check_column(column);
    const Hdf5Reader::Shape shape = reader_.shape(kReplayBursts);
    if (shape.columns != kReplayBurstWidth) damaged();
    const auto bursts = reader_.all<std::uint64_t>(kReplayBursts);
    for (std::size_t k = 0; k < shape.rows; ++k) read_burst(bursts.data() + k * shape.columns);
    return rows_;
  }

 private:
  void check_column(const ReplayColumn& column) const {
    const std::size_t width = replay_width(header_, column.width);
    if (width > 0 && reader_.shape(column.path).columns != width) damaged();
  }

  void read_burst(const std::uint64_t* burst) {
    for (std::size_t k = 0; k < kReplayColumnCount; ++k) {
      if (burst[k] < rows_[k]) damaged();
      const std::size_t first = rows_[k], count = static_cast<std::size_t>(burst[k]) - first;
      rows_[k] += count;
      if (replay_width(header_, kReplayColumns[k].width) > 0) {
        add_column(kReplayColumns[k], first, count);
      }
    }
    if (chain_.value() != burst[kReplayColumnCount]) damaged();
  }

  void add_column(const ReplayColumn& column, std::size_t first, std::size_t count) {
    switch (column.type) {
      case ReplayType::kU8:
        return add_values<std::uint8_t>(column, first, count);
      case ReplayType::kI32:
        return add_values<std::int32_t>(column, first, count);
      case ReplayType::kU64:
        return add_values<std::uint64_t>(column, first, count);
      case ReplayType::kF32:
        return add_values<float>(column, first, count);
    }
  }

  template <class T>
  void add_values(const ReplayColumn& column, std::size_t first, std::size_t count) {
    if (count == 0) return;
    const std::vector<T> values = reader_.rows<T>(column.path, first, count);
    add_burst(chain_, first + count, values.data(), values.size() * sizeof(T));
  }

  [[noreturn]] void damaged() const {
    reader_.fail(
        "this replay is damaged: its values are not those that were recorded; take another copy");
  }

  const Hdf5Reader& reader_;
  const ReplayHeader& header_;
  HashChain chain_;
  ReplayRows rows_{};
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
  for (const std::string* text :
       {&header.skybody_version, &header.scenario_name, &header.scenario_file,
        &header.scenario_text, &header.autoreset}) {
    chain.update(hash_string(*text));
  }
  for (const std::uint64_t number : {header.scenario_hash, header.seed, header.first_env_id}) {
    chain.update(number);
  }
  chain.update(header.envs);
  chain.update(header.action_size);
  for (const auto* texts :
       {&header.overrides, &header.plugin_path, &header.observation_names, &header.state_names}) {
    add_texts(chain, *texts);
  }
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
