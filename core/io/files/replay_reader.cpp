#include <algorithm>
#include <charconv>
#include <numeric>
#include <type_traits>

#include "core/base/math/hash.h"
#include "core/io/files/hdf5_reader.h"
#include "core/io/files/replay_bursts.h"
#include "core/io/files/replay_file.h"

namespace skybody {
namespace {

constexpr std::int64_t kMostSize = 1 << 24;
constexpr std::size_t kWindow = 4096;  // rows of actions, or of results, read at once
constexpr const char* kRemedy = "give a recording, which `skybody hash --record FILE` writes";

}  // namespace

/// Consecutive rows of the recording.
struct ReplayReader::Block {
  std::size_t first = 0, count = 0;
  std::vector<std::uint64_t> episode;
  std::vector<std::int32_t> episode_step;
  std::vector<std::uint8_t> was_reset;
  std::vector<std::uint64_t> status;
  std::vector<float> reward, observation;
  std::vector<std::uint64_t> state;
};

struct ReplayReader::File {
  using enum ReplayColumnId::Id;

  explicit File(const std::filesystem::path& path) : reader(path, "replay", kRemedy) {
    read_header();
    rows = check_bursts(reader, header);
    read_events();
    read_transitions();
    index_transitions();
  }

  void read_header() {
    reader.check_format(kReplayFormat, "record it anew");
    each_replay_field(header, [this](const char* name, auto& field, int base = 10) {
      using Field = std::remove_cvref_t<decltype(field)>;
      if constexpr (std::is_same_v<Field, std::string>) {
        field = reader.text("/", name);
      } else if constexpr (std::is_same_v<Field, std::uint64_t>) {
        field = number(name, base);
      } else if constexpr (std::is_same_v<Field, int>) {
        field = size(name);
      } else {
        field = reader.texts("/" + std::string(name));
      }
    });
    if (header.autoreset != "next_step" && header.autoreset != "same_step" &&
        header.autoreset != "disabled") {
      reader.fail("`autoreset` is `" + header.autoreset +
                  "`; allowed: next_step, same_step, disabled");
    }
  }

  /// The block that contains a row; caches the last block.
  const Block& block_of(std::size_t place) {
    if (place >= block.first && place - block.first < block.count) return block;
    block.first = place / kWindow * kWindow;
    block.count = std::min(kWindow, hash.size() - block.first);
    read_block(kEpisode, block.episode);
    read_block(kEpisodeStep, block.episode_step);
    read_block(kWasReset, block.was_reset);
    read_block(kStatus, block.status);
    read_block(kReward, block.reward);
    read_block(kObservation, block.observation);
    read_block(kState, block.state);
    return block;
  }

  template <class T>
  void read_block(ReplayColumnId::Id id, std::vector<T>& values) {
    const ReplayColumn& column = kReplayColumns[id];
    if (replay_width(header, column.width) == 0) return;
    values = reader.rows<T>(column.path, block.first, block.count);
  }

  /// A whole column with one value per row.
  template <class T>
  std::vector<T> read_column(ReplayColumnId::Id id) const {
    return reader.rows<T>(kReplayColumns[id].path, 0, rows[id]);
  }

  std::uint64_t number(const char* name, int base) {
    const std::string text = reader.text("/", name);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size()) {
      reader.fail("`" + std::string(name) + "` is `" + text + "`; a whole number is needed");
    }
    return value;
  }

  int size(const char* name) {
    const std::int64_t value = reader.integer("/", name);
    if (value < 0 || value > kMostSize) {
      reader.fail("`" + std::string(name) + "` is " + std::to_string(value) + "; allowed: 0.." +
                  std::to_string(kMostSize));
    }
    return static_cast<int>(value);
  }

  void read_events() {
    kind = read_column<std::uint8_t>(kKind);
    count = read_column<std::uint64_t>(kCount);
    argument = read_column<std::uint64_t>(kArgument);
    env_id = read_column<std::int32_t>(kEventEnv);
    paths = read_column<std::uint8_t>(kPath);
    check_ids(kEventEnv, env_id);
    if (count.size() != kind.size()) wrong_length(kCount);
    if (argument.size() != kind.size()) wrong_length(kArgument);
    if (kind.empty() || !is_restore(0)) damaged("the first event is not a saved state");
    // A saved state has several words per environment.
    if (static_cast<std::size_t>(header.envs) > rows[kSaved]) wrong_length(kSaved);
    check_counts();
  }

  /// The events must use all rows of the other columns; a count may be any 64-bit number.
  void check_counts() const {
    std::size_t ids = env_id.size(), words = rows[kSaved], actions = rows[kAction];
    std::size_t event = 0;
    const auto take = [this, &event](std::size_t& left, std::uint64_t taken) {
      if (taken > left) damaged_event(event);
      left -= static_cast<std::size_t>(taken);
    };
    for (; event < kind.size(); ++event) {
      const std::size_t k = event;
      if (kind[k] > static_cast<std::uint8_t>(ReplayEventKind::kRequest)) damaged_event(k);
      take(is_restore(k) ? words : ids, count[k]);
      if (kind_of(k) == ReplayEventKind::kSend && header.action_size > 0) take(actions, count[k]);
    }
    if (ids != 0) wrong_length(kEventEnv);
    if (words != 0) wrong_length(kSaved);
    if (actions != 0) wrong_length(kAction);
  }

  void read_transitions() {
    row_env = read_column<std::int32_t>(kRowEnv);
    hash = read_column<std::uint64_t>(kHash);
    check_ids(kRowEnv, row_env);
    if (row_env.empty()) {
      reader.fail("this replay has no transitions: there is nothing to compare; record a reset");
    }
    for (const ReplayColumnId::Id id :
         {kHash, kEpisode, kEpisodeStep, kWasReset, kStatus, kReward}) {
      if (rows[id] != row_env.size()) wrong_length(id);
    }
    for (const ReplayColumnId::Id id : {kObservation, kState}) {
      const bool has = replay_width(header, kReplayColumns[id].width) > 0;
      if (has && rows[id] != row_env.size()) wrong_length(id);
    }
  }

  /// Finds the transitions of each environment, and the action row of each transition.
  void index_transitions() {
    places.resize(static_cast<std::size_t>(header.envs));
    for (std::size_t k = 0; k < row_env.size(); ++k) {
      places[static_cast<std::size_t>(row_env[k])].push_back(k);
    }
    sent.resize(places.size());
    std::size_t at = 0;
    std::int64_t action_row = 0;
    // Each reset, action or reseeding gives a transition, except those unfinished at the end.
    std::size_t left = row_env.size() + places.size();
    for (std::size_t k = 0; k < kind.size(); ++k) {
      if (is_restore(k)) continue;
      const bool is_send = kind_of(k) == ReplayEventKind::kSend;
      const bool is_reset = kind_of(k) == ReplayEventKind::kReset;
      for (std::uint64_t n = 0; n < count[k]; ++n, ++at) {
        if (is_send || is_reset) {
          sent[static_cast<std::size_t>(env_id[at])].push_back(is_send ? action_row++ : -1);
        }
      }
      if (kind_of(k) != ReplayEventKind::kReseed) continue;
      if (places.size() > left) damaged_event(k);
      left -= places.size();
      for (auto& list : sent) list.push_back(-1);
    }
    for (std::size_t env = 0; env < places.size(); ++env) {
      if (places[env].size() > sent[env].size()) {
        damaged("environment " + std::to_string(env) + " has more transitions than events");
      }
    }
  }

  void check_ids(ReplayColumnId::Id column, const std::vector<std::int32_t>& ids) const {
    for (const std::int32_t id : ids) {
      if (id >= 0 && id < header.envs) continue;
      damaged(name_of(column) + " has environment " + std::to_string(id) + " of " +
              std::to_string(header.envs));
    }
  }

  static std::string name_of(ReplayColumnId::Id id) {
    return "`" + std::string(kReplayColumns[id].path) + "`";
  }

  [[noreturn]] void wrong_length(ReplayColumnId::Id id) const {
    damaged(name_of(id) + " has a wrong number of rows: " + std::to_string(rows[id]));
  }

  [[noreturn]] void damaged_event(std::size_t event) const {
    damaged("event " + std::to_string(event) + " is of no known kind, or takes more than there is");
  }

  [[noreturn]] void damaged(const std::string& what) const {
    reader.fail("this replay is damaged: its events and transitions do not fit together: " + what);
  }

  ReplayEventKind kind_of(std::size_t k) const { return static_cast<ReplayEventKind>(kind[k]); }
  bool is_restore(std::size_t k) const { return kind_of(k) == ReplayEventKind::kRestore; }

  void read_path(std::string& path) {
    path.clear();
    for (; next_path < paths.size() && paths[next_path] != 0; ++next_path) {
      path += static_cast<char>(paths[next_path]);
    }
    ++next_path;
  }

  /// Reads the next rows of actions, through a window that slides over the file.
  void read_actions(std::size_t wanted, std::vector<float>& out) {
    const auto width = static_cast<std::size_t>(header.action_size);
    out.clear();
    if (width == 0) return;
    for (; wanted > 0; --wanted, ++next_action) {
      if (next_action >= window_end) slide_window();
      const float* row = window.data() + (next_action - window_begin) * width;
      out.insert(out.end(), row, row + width);
    }
  }

  void slide_window() {
    if (next_action >= rows[kAction]) wrong_length(kAction);
    window_begin = next_action;
    window_end = std::min(rows[kAction], next_action + kWindow);
    window =
        reader.rows<float>(kReplayColumns[kAction].path, window_begin, window_end - window_begin);
  }

  Hdf5Reader reader;
  Block block;  ///< the last block read
  ReplayHeader header;
  ReplayRows rows{};  ///< of complete bursts
  std::vector<std::uint8_t> kind, paths;
  std::vector<std::int32_t> env_id, row_env;
  std::vector<std::uint64_t> count, argument, hash;
  std::vector<std::vector<std::size_t>> places;  ///< per environment
  std::vector<std::vector<std::int64_t>> sent;   ///< per environment: action row, -1: a reset

  std::size_t next_event = 0, next_id = 0, next_path = 0, next_action = 0, next_saved = 0;
  std::vector<float> window;
  std::size_t window_begin = 0, window_end = 0;
};

ReplayReader::ReplayReader(const std::filesystem::path& file)
    : file_(std::make_unique<File>(file)) {}
ReplayReader::~ReplayReader() = default;

const ReplayHeader& ReplayReader::header() const { return file_->header; }
const std::filesystem::path& ReplayReader::file() const { return file_->reader.path(); }

bool ReplayReader::next(ReplayEvent& event) {
  File& f = *file_;
  if (f.next_event == f.kind.size()) return false;
  const std::size_t k = f.next_event++;
  const auto count = static_cast<std::size_t>(f.count[k]);
  event.kind = f.kind_of(k);
  event.argument = f.argument[k];
  event.env_ids.clear();
  if (f.is_restore(k)) {
    event.saved =
        f.reader.rows<std::uint64_t>(kReplayColumns[File::kSaved].path, f.next_saved, count);
    f.next_saved += count;
    return true;
  }
  const auto first = f.env_id.begin() + static_cast<std::ptrdiff_t>(f.next_id);
  event.env_ids.assign(first, first + static_cast<std::ptrdiff_t>(count));
  f.next_id += count;
  if (event.kind == ReplayEventKind::kSend) f.read_actions(count, event.actions);
  if (has_path_text(event.kind)) f.read_path(event.path);
  const bool needs_one = event.kind == ReplayEventKind::kFork || has_path_text(event.kind);
  if (needs_one && count == 0) f.damaged_event(k);
  return true;
}

std::size_t ReplayReader::transitions() const { return file_->row_env.size(); }
std::size_t ReplayReader::transitions(int env) const {
  return file_->places[static_cast<std::size_t>(env)].size();
}
std::size_t ReplayReader::place(int env, std::size_t k) const {
  return file_->places[static_cast<std::size_t>(env)][k];
}
std::uint64_t ReplayReader::hash(std::size_t place) const { return file_->hash[place]; }

/// Reads rows in blocks: a replay reads all of them, nearly in order.
ReplayRow ReplayReader::row(std::size_t place) const {
  const Block& block = file_->block_of(place);
  const std::size_t k = place - block.first;
  const auto values_of = [k](const auto& all, std::size_t width) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(k * width);
    return std::vector(first, first + static_cast<std::ptrdiff_t>(width));
  };
  ReplayRow row;
  row.env = file_->row_env[place];
  row.hash = file_->hash[place];
  row.episode = block.episode[k];
  row.episode_step = block.episode_step[k];
  row.was_reset = block.was_reset[k] != 0;
  row.status = block.status[k];
  row.reward = block.reward[k];
  row.observation = values_of(block.observation, header().observation_names.size());
  row.state = values_of(block.state, header().state_names.size());
  return row;
}

std::vector<float> ReplayReader::action(int env, std::size_t k) const {
  const std::int64_t at = file_->sent[static_cast<std::size_t>(env)][k];
  if (at < 0) return {};
  if (header().action_size == 0) return {};
  return file_->reader.rows<float>(kReplayColumns[File::kAction].path, static_cast<std::size_t>(at),
                                   1);
}

}  // namespace skybody
