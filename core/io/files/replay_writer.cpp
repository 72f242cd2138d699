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

/// Writes a field of the header by its type. Numbers of 64 bits are texts: HDF5's are signed.
struct FieldWriter {
  const Hdf5Writer& writer;
  hid_t file;

  void operator()(const char* name, const std::string& text) const {
    writer.write_text(file, name, text);
  }
  void operator()(const char* name, std::uint64_t number, int base = 10) const {
    writer.write_text(file, name, base == 16 ? to_hex(number) : std::to_string(number));
  }
  void operator()(const char* name, int number) const {
    writer.write_attribute(file, name, std::int64_t{number});
  }
  void operator()(const char* name, const std::vector<std::string>& values) const {
    write_texts(writer, file, name, values);
  }
};

/// HDF5's type of a column, in the order of ReplayType.
hid_t type_of(ReplayType type) {
  const hid_t types[] = {H5T_NATIVE_UINT8, H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_FLOAT};
  return types[static_cast<int>(type)];
}

Hdf5Id created(const Hdf5Writer& writer, const ReplayHeader& header) {
  Hdf5Id file = writer.create_file();
  hold_structure_back(writer, file);
  writer.write_text(file, "format", "skybody-replay");
  writer.write_attribute(file, "version", std::int64_t{kReplayFormat});
  each_replay_field(header, FieldWriter{writer, file});
  return file;
}

}  // namespace

struct ReplayWriter::File {
  using enum ReplayColumnId::Id;

  File(const std::filesystem::path& target, const ReplayHeader& header)
      : place(target),
        writer(target, "replay"),
        file(created(writer, header)),
        events(writer.create_group(file, "events")),
        transitions(writer.create_group(file, "transitions")),
        bursts(writer, file, "bursts", H5T_NATIVE_UINT64, kReplayBurstWidth),
        chain(replay_chain(header)) {
    for (const ReplayColumn& column : kReplayColumns) {
      const std::size_t width = replay_width(header, column.width);
      columns.emplace_back(writer, file, column.path, type_of(column.type), width);
    }
    const std::size_t action = replay_width(header, ReplayWidth::kAction);
    observation_size = replay_width(header, ReplayWidth::kObservation);
    state_size = replay_width(header, ReplayWidth::kState);
    row_bytes = observation_size * 4 + state_size * 8 + action * 4;
  }

  /// Buffers values of a column.
  template <class... Values>
  void add(ReplayColumnId::Id column, Values... values) {
    columns[column].add(values...);
  }

  /// Writes the buffered rows, then the row of /bursts, and flushes to the operating system.
  void write_burst() {
    const haddr_t end = reserve();
    broken = true;
    for (const Hdf5Column& column : columns) {
      add_burst(chain, column.rows(), column.waiting(), column.waiting_bytes());
      bursts.add(column.rows());
    }
    bursts.add(chain.value());
    for (Hdf5Column& column : columns) column.write();
    bursts.write();
    writer.check(H5Fflush(file, H5F_SCOPE_LOCAL));
    broken = false;
    give_back(end);
  }

  std::size_t waiting_bytes() const {
    std::size_t bytes = 0;
    for (const Hdf5Column& column : columns) bytes += column.waiting_bytes();
    return bytes;
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
    const std::size_t bytes = kStructureBytes + row_bytes +
                              (kReplayColumnCount + 1) * kColumnChunkBytes + waiting_bytes();
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
  std::vector<Hdf5Column> columns;  ///< in the order of kReplayColumns
  Hdf5Column bursts;
  std::size_t observation_size = 0, state_size = 0;
  std::size_t row_bytes = 0;  ///< of all columns with several values
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
  File& f = *file_;
  const std::size_t count =
      event.kind == ReplayEventKind::kRestore ? event.saved.size() : event.env_ids.size();
  f.add(File::kKind, static_cast<std::uint8_t>(event.kind));
  f.add(File::kCount, static_cast<std::uint64_t>(count));
  f.add(File::kArgument, event.argument);
  f.add(File::kEventEnv, event.env_ids.data(), event.env_ids.size());
  f.add(File::kSaved, event.saved.data(), event.saved.size());
  f.add(File::kAction, event.actions.data(), event.actions.size());
  if (has_path_text(event.kind)) f.add(File::kPath, event.path.c_str(), event.path.size() + 1);
  flush_if_full();
}

void ReplayWriter::add(ReplayEventKind kind, std::span<const std::int32_t> env_ids,
                       std::span<const float> actions) {
  SKYBODY_DEMAND(file_, "an event for a closed replay");
  file_->add(File::kKind, static_cast<std::uint8_t>(kind));
  file_->add(File::kCount, static_cast<std::uint64_t>(env_ids.size()));
  file_->add(File::kArgument, std::uint64_t{0});
  file_->add(File::kEventEnv, env_ids.data(), env_ids.size());
  file_->add(File::kAction, actions.data(), actions.size());
  flush_if_full();
}

void ReplayWriter::add(const ReplayRow& row) {
  SKYBODY_DEMAND(file_ && row.observation.size() == file_->observation_size &&
                     row.state.size() == file_->state_size,
                 "a replay's row has the wrong width");
  File& f = *file_;
  f.add(File::kRowEnv, std::int32_t{row.env});
  f.add(File::kHash, row.hash);
  f.add(File::kEpisode, row.episode);
  f.add(File::kEpisodeStep, row.episode_step);
  f.add(File::kWasReset, row.was_reset ? std::uint8_t{1} : std::uint8_t{0});
  f.add(File::kStatus, row.status);
  f.add(File::kReward, row.reward);
  f.add(File::kObservation, row.observation.data(), row.observation.size());
  f.add(File::kState, row.state.data(), row.state.size());
  flush_if_full();
}

void ReplayWriter::flush_if_full() {
  if (file_->waiting_bytes() >= kFlushBytes) flush();
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
