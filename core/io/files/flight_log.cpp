#include "core/io/files/flight_log.h"

#include <array>
#include <cstdio>
#include <optional>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "core/io/files/flight_log_episode.h"
#include "core/io/files/flight_log_hdf5.h"

namespace skybody {

struct FlightLog::File {
  File(const std::filesystem::path& path, const FlightLogHeader& h)
      : writer(path), header(h), file(writer.create_file()) {}

  QuietHdf5 quiet;
  Hdf5Writer writer;
  FlightLogHeader header;
  Hdf5Id file;
  Hdf5Id episodes;
  std::optional<FlightLogEpisode> episode;
  int count = 0;

  void write_header();
  void write_params();
  void finish_episode();
};

void FlightLog::File::write_header() {
  writer.write_attribute(file, "format", std::string("skybody flight log 1"));
  writer.write_attribute(file, "scenario", header.scenario_name);
  writer.write_attribute(file, "scenario_file", header.scenario_file);
  writer.write_attribute(file, "scenario_text", header.scenario_text);
  writer.write_attribute(file, "scenario_hash", to_hex(header.scenario_hash));
  writer.write_attribute(file, "seed", std::to_string(header.seed));
  writer.write_attribute(file, "policy", header.policy);
  writer.write_attribute(file, "dt", header.dt);
  writer.write_attribute(file, "action_repeat", static_cast<std::int64_t>(header.action_repeat));
  writer.write_attribute(file, "bodies", header.bodies);
  writer.write_attribute(file, "references", header.references);
  writer.write_attribute(file, "rotors", names_of(header.rotors));
  const Hdf5Id versions = writer.create_group(file, "versions");
  for (const auto& [component, version] : header.versions) {
    writer.write_attribute(versions, component.c_str(), version);
  }
}

void FlightLog::File::write_params() {
  const Hdf5Id params = writer.create_group(file, "params");
  writer.write_dataset(params, "paths", names_of(header.params));
  writer.write_dataset(params, "units", units_of(header.params));
  writer.write_dataset(params, "nominal", header.nominal_params);
}

void FlightLog::File::finish_episode() {
  if (episode) episode->finish();
  episode.reset();
}

FlightLog::FlightLog(const std::filesystem::path& file, const FlightLogHeader& header)
    : file_(std::make_unique<File>(file, header)) {
  file_->write_header();
  file_->write_params();
  file_->episodes = file_->writer.create_group(file_->file, "episodes");
}

FlightLog::~FlightLog() {
  try {
    close();
  } catch (const Error&) {  // the caller reports its own failure
  }
}

void FlightLog::begin_episode(std::span<const double> params) {
  file_->finish_episode();
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%04d", ++file_->count);
  Hdf5Id group = file_->writer.create_group(file_->episodes, name.data());
  file_->writer.write_dataset(group, "params", std::vector<double>(params.begin(), params.end()));
  file_->episode.emplace(file_->writer, std::move(group), file_->header);
}

void FlightLog::add(const FlightLogRow& row) {
  SKYBODY_DEMAND(file_ && file_->episode, "a row of the flight log outside of an episode");
  file_->episode->add(row);
}

void FlightLog::event(const std::string& text) {
  SKYBODY_DEMAND(file_ && file_->episode, "an event of the flight log outside of an episode");
  file_->episode->event(text);
}

void FlightLog::close() {
  if (!file_) return;
  const std::unique_ptr<File> file = std::move(file_);
  file->finish_episode();
  file->episodes.reset();
  if (!file->file.reset()) file->writer.fail();
}

void skip_hdf5_cleanup_at_exit() { H5dont_atexit(); }

}  // namespace skybody
