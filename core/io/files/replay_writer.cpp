#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "core/io/files/hdf5_column.h"
#include "core/io/files/replay_bursts.h"
#include "core/io/files/replay_file.h"

namespace skybody {
namespace {

constexpr std::size_t kFlushBytes = 4 << 20;
constexpr std::size_t kColumnChunkBytes = 1 << 16;  // of a column, unless a row is longer
constexpr std::size_t kStructureBytes = 256 << 10;  // HDF5's metadata of a burst, with a margin

/// Makes HDF5 write the file's metadata only in flushes, not when its cache is full.
void hold_structure_back(const Hdf5Writer& writer, hid_t file) {
  H5AC_cache_config_t config;
  config.version = H5AC__CURR_CACHE_CONFIG_VERSION;
  writer.check(H5Fget_mdc_config(file, &config));
  config.evictions_enabled = false;
  config.incr_mode = H5C_incr__off;
  config.flash_incr_mode = H5C_flash_incr__off;
  config.decr_mode = H5C_decr__off;
  writer.check(H5Fset_mdc_config(file, &config));
}

void write_texts(const Hdf5Writer& writer, hid_t parent, const char* name,
                 const std::vector<std::string>& values) {
  std::size_t width = 1;
  for (const std::string& value : values) width = std::max(width, value.size());
  std::string bytes;
  for (std::string value : values) {
    value.resize(width, '\0');
    bytes += value;
  }
  const Hdf5Id type = hdf5_text_type(width);
  const hsize_t extent = values.size();
  const Hdf5Id space(writer.check(H5Screate_simple(1, &extent, nullptr)), H5Sclose);
  const Hdf5Id set(
      writer.check(H5Dcreate2(parent, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
      H5Dclose);
  if (extent > 0) {
    writer.check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()));
  }
}

Hdf5Id created(const Hdf5Writer& writer, const ReplayHeader& header) {
  Hdf5Id file = writer.create_file();
  hold_structure_back(writer, file);
  writer.write_text(file, "format", "skybody-replay");
  writer.write_attribute(file, "version", std::int64_t{kReplayFormat});
  writer.write_text(file, "skybody_version", header.skybody_version);
  writer.write_text(file, "scenario", header.scenario_name);
  writer.write_text(file, "scenario_file", header.scenario_file);
  writer.write_text(file, "scenario_text", header.scenario_text);
  writer.write_text(file, "scenario_hash", to_hex(header.scenario_hash));
  writer.write_text(file, "seed", std::to_string(header.seed));
  writer.write_text(file, "first_env_id", std::to_string(header.first_env_id));
  writer.write_attribute(file, "envs", static_cast<std::int64_t>(header.envs));
  writer.write_text(file, "autoreset", header.autoreset);
  writer.write_attribute(file, "action_size", static_cast<std::int64_t>(header.action_size));
  write_texts(writer, file, "overrides", header.overrides);
  write_texts(writer, file, "plugin_path", header.plugin_path);
  write_texts(writer, file, "columns", header.columns);
  write_texts(writer, file, "observation_names", header.observation_names);
  write_texts(writer, file, "state_names", header.state_names);
  return file;
}

}  // namespace

struct ReplayWriter::File {
  File(const std::filesystem::path& target, const ReplayHeader& header)
      : place(target),
        writer(target, "replay"),
        file(created(writer, header)),
        events(writer.create_group(file, "events")),
        transitions(writer.create_group(file, "transitions")),
        action_size(static_cast<std::size_t>(header.action_size)),
        observation_size(header.observation_names.size()),
        state_size(header.state_names.size()),
        kind(writer, events, "kind", H5T_NATIVE_UINT8),
        count(writer, events, "count", H5T_NATIVE_UINT64),
        argument(writer, events, "argument", H5T_NATIVE_UINT64),
        env_id(writer, events, "env_id", H5T_NATIVE_INT32),
        action(writer, events, "action", H5T_NATIVE_FLOAT, header.action_size),
        path(writer, events, "path", H5T_NATIVE_UINT8),
        saved(writer, events, "saved", H5T_NATIVE_UINT64),
        row_env(writer, transitions, "env_id", H5T_NATIVE_INT32),
        hash(writer, transitions, "hash", H5T_NATIVE_UINT64),
        episode(writer, transitions, "episode", H5T_NATIVE_UINT64),
        episode_step(writer, transitions, "episode_step", H5T_NATIVE_INT32),
        was_reset(writer, transitions, "was_reset", H5T_NATIVE_UINT8),
        status(writer, transitions, "status", H5T_NATIVE_UINT64),
        reward(writer, transitions, "reward", H5T_NATIVE_FLOAT),
        observation(writer, transitions, "observation", H5T_NATIVE_FLOAT,
                    static_cast<int>(observation_size)),
        state(writer, transitions, "state", H5T_NATIVE_UINT64, static_cast<int>(state_size)),
        bursts(writer, file, "bursts", H5T_NATIVE_UINT64, kReplayBurstWidth),
        chain(replay_chain(header)) {}

  /// In the order of kReplayColumns.
  template <class Visit>
  void each_column(Visit&& visit) {
    visit(kind), visit(count), visit(argument), visit(env_id), visit(action), visit(path),
        visit(saved), visit(row_env), visit(hash), visit(episode), visit(episode_step),
        visit(was_reset), visit(status), visit(reward), visit(observation), visit(state);
  }

  /// Writes the buffered rows, then the row of /bursts, and flushes to the operating system.
  void write_burst() {
    const haddr_t end = reserve();
    broken = true;
    each_column([&](const auto& column) {
      add_burst(chain, column.rows(), column.waiting(), column.waiting_bytes());
      bursts.add(column.rows());
    });
    bursts.add(chain.value());
    each_column([](auto& column) { column.write(); });
    bursts.write();
    writer.check(H5Fflush(file, H5F_SCOPE_LOCAL));
    broken = false;
    give_back(end);
  }

  int descriptor() const {
    void* handle = nullptr;
    writer.check(H5Fget_vfd_handle(file, H5P_DEFAULT, &handle));
    return *static_cast<int*>(handle);
  }

  haddr_t end_of_file() const {
    haddr_t end = 0;
    writer.check(H5Fget_eoa(file, &end));
    return end;
  }

  /// Reserves the space of a burst before writing it. HDF5 cannot undo a partly written burst, and
  /// then cannot read the earlier ones either. Returns the end of the reserved space.
  haddr_t reserve() {
    const std::size_t row = observation_size * 4 + state_size * 8 + action_size * 4;
    std::size_t bytes = kStructureBytes + row + (kReplayColumnCount + 1) * kColumnChunkBytes;
    each_column([&](const auto& column) { bytes += column.waiting_bytes(); });
    const haddr_t end = end_of_file();
    const int error =
        ::posix_fallocate(descriptor(), static_cast<off_t>(end), static_cast<off_t>(bytes));
    if (error == 0) return end + bytes;
    throw Error("cannot write the replay " + place.string() + ": " + std::strerror(error));
  }

  /// Frees the unused part of the reserved space. A longer file is also valid.
  void give_back(haddr_t reserved) {
    const haddr_t end = end_of_file();
    if (end < reserved && ::ftruncate(descriptor(), static_cast<off_t>(end)) != 0) return;
  }

  /// Leaves the file in its state after the last complete burst. HDF5's remaining writes at closing
  /// are redirected into a temporary memory file: the reader could not use a partial burst.
  void let_go_of_file() {
    void* handle = nullptr;
    const int nowhere = ::memfd_create("skybody replay", MFD_CLOEXEC);
    if (nowhere < 0) return;
    if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) >= 0) {
      ::dup2(nowhere, *static_cast<int*>(handle));
    }
    ::close(nowhere);
  }

  std::filesystem::path place;
  QuietHdf5 quiet;
  Hdf5Writer writer;
  Hdf5Id file, events, transitions;
  std::size_t action_size, observation_size, state_size;
  Hdf5Column<std::uint8_t> kind;
  Hdf5Column<std::uint64_t> count, argument;
  Hdf5Column<std::int32_t> env_id;
  Hdf5Column<float> action;
  Hdf5Column<std::uint8_t> path;
  Hdf5Column<std::uint64_t> saved;
  Hdf5Column<std::int32_t> row_env;
  Hdf5Column<std::uint64_t> hash, episode;
  Hdf5Column<std::int32_t> episode_step;
  Hdf5Column<std::uint8_t> was_reset;
  Hdf5Column<std::uint64_t> status;
  Hdf5Column<float> reward, observation;
  Hdf5Column<std::uint64_t> state, bursts;
  HashChain chain;
  bool broken = false;  ///< a burst was begun and not completed
};

ReplayWriter::ReplayWriter(const std::filesystem::path& file, const ReplayHeader& header)
    : file_(std::make_unique<File>(file, header)) {}

ReplayWriter::~ReplayWriter() {
  try {
    close();
  } catch (const Error&) {  // the caller reports its own failure
  }
}

void ReplayWriter::add(const ReplayEvent& event) {
  SKYBODY_DEMAND(file_, "an event for a closed replay");
  const bool has_path = has_path_text(event.kind);
  const std::size_t count =
      event.kind == ReplayEventKind::kRestore ? event.saved.size() : event.env_ids.size();
  file_->kind.add(static_cast<std::uint8_t>(event.kind));
  file_->count.add(static_cast<std::uint64_t>(count));
  file_->argument.add(event.argument);
  file_->env_id.add(event.env_ids.data(), event.env_ids.size());
  file_->saved.add(event.saved.data(), event.saved.size());
  file_->action.add(event.actions.data(), event.actions.size());
  if (has_path) {
    file_->path.add(reinterpret_cast<const std::uint8_t*>(event.path.c_str()),
                    event.path.size() + 1);
  }
  flush_if_full();
}

void ReplayWriter::add(ReplayEventKind kind, std::span<const std::int32_t> env_ids,
                       std::span<const float> actions) {
  SKYBODY_DEMAND(file_, "an event for a closed replay");
  file_->kind.add(static_cast<std::uint8_t>(kind));
  file_->count.add(static_cast<std::uint64_t>(env_ids.size()));
  file_->argument.add(std::uint64_t{0});
  file_->env_id.add(env_ids.data(), env_ids.size());
  file_->action.add(actions.data(), actions.size());
  flush_if_full();
}

void ReplayWriter::add(const ReplayRow& row) {
  SKYBODY_DEMAND(file_ && row.observation.size() == file_->observation_size &&
                     row.state.size() == file_->state_size,
                 "a replay's row has the wrong width");
  file_->row_env.add(row.env);
  file_->hash.add(row.hash);
  file_->episode.add(row.episode);
  file_->episode_step.add(row.episode_step);
  file_->was_reset.add(row.was_reset ? std::uint8_t{1} : std::uint8_t{0});
  file_->status.add(row.status);
  file_->reward.add(row.reward);
  file_->observation.add(row.observation.data(), row.observation.size());
  file_->state.add(row.state.data(), row.state.size());
  flush_if_full();
}

void ReplayWriter::flush_if_full() {
  std::size_t waiting = 0;
  file_->each_column([&](const auto& column) { waiting += column.waiting_bytes(); });
  if (waiting >= kFlushBytes) flush();
}

void ReplayWriter::flush() {
  SKYBODY_DEMAND(file_, "flush() of a closed replay");
  file_->write_burst();
}

void ReplayWriter::close() {
  if (!file_) return;
  const std::unique_ptr<File> file = std::move(file_);
  try {
    if (!file->broken) file->write_burst();
  } catch (...) {
    file->let_go_of_file();
    throw;
  }
  if (file->broken) file->let_go_of_file();
}

}  // namespace skybody
