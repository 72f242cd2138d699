#include "core/io/files/flight_log_episode.h"

#include <utility>

namespace skybody {
namespace {

/// Names and units of the 13 values of a body.
const std::vector<LogColumn>& body_columns() {
  static const std::vector<LogColumn> columns = {
      {"x", "m"},      {"y", "m"},      {"z", "m"},     {"qw", ""},    {"qx", ""},
      {"qy", ""},      {"qz", ""},      {"vx", "m/s"},  {"vy", "m/s"}, {"vz", "m/s"},
      {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}};
  return columns;
}

const std::vector<LogColumn>& goal_columns() {
  static const std::vector<LogColumn> columns = {
      {"x", "m"}, {"y", "m"}, {"z", "m"}, {"yaw", "rad"}};
  return columns;
}

/// A row of the table of events in HDF5's memory layout.
struct EventRecord {
  std::uint64_t row;
  double time;
  const char* text;
};

}  // namespace

std::vector<std::string> names_of(const std::vector<LogColumn>& columns) {
  std::vector<std::string> names;
  names.reserve(columns.size());
  for (const LogColumn& column : columns) names.push_back(column.name);
  return names;
}

std::vector<std::string> units_of(const std::vector<LogColumn>& columns) {
  std::vector<std::string> units;
  units.reserve(columns.size());
  for (const LogColumn& column : columns) units.push_back(column.unit);
  return units;
}

FlightLogEpisode::FlightLogEpisode(const Hdf5Writer& writer, Hdf5Id group,
                                   const FlightLogHeader& header)
    : writer_(writer),
      group_(std::move(group)),
      time_(make("time", H5T_NATIVE_DOUBLE, {})),
      reward_(make("reward", H5T_NATIVE_FLOAT, {})),
      status_(make("status", H5T_NATIVE_UINT64, {})),
      touching_(make("touching", H5T_NATIVE_UINT8, {})),
      bodies_(make_items("bodies", header.bodies, body_columns())),
      goal_(make_items("goal", header.goals, goal_columns())),
      q_(make_columns("q", header.q, H5T_NATIVE_DOUBLE)),
      u_(make_columns("u", header.u, H5T_NATIVE_DOUBLE)),
      rotor_speed_(make_columns("rotor_speed", header.rotors, H5T_NATIVE_DOUBLE)),
      rotor_command_(make_columns("rotor_command", header.rotors, H5T_NATIVE_DOUBLE)),
      action_(make_columns("action", header.action, H5T_NATIVE_DOUBLE)),
      command_(make_columns("command", header.command, H5T_NATIVE_DOUBLE)),
      sensors_(make_columns("sensors", header.sensors, H5T_NATIVE_DOUBLE)),
      observation_(make_columns("observation", header.observation, H5T_NATIVE_FLOAT)),
      info_(make_columns("info", header.info, H5T_NATIVE_FLOAT)) {
  writer_.write_attribute(time_.dataset(), "unit", std::string("s"));
  writer_.write_attribute(status_.dataset(), "bits",
                          std::string("1 terminated, 2 truncated, 4 fault"));
  writer_.write_attribute(touching_.dataset(), "values",
                          std::string("1 where something touches something"));
}

void FlightLogEpisode::add(const FlightLogRow& row) {
  time_.add(std::span(&row.time, 1));
  reward_.add(std::span(&row.reward, 1));
  status_.add(std::span(&row.status, 1));
  touching_.add(std::span(&row.touching, 1));
  bodies_.add(row.bodies);
  goal_.add(row.goal);
  q_.add(row.q);
  u_.add(row.u);
  rotor_speed_.add(row.rotor_speed);
  rotor_command_.add(row.rotor_command);
  action_.add(row.action);
  command_.add(row.command);
  sensors_.add(row.sensors);
  observation_.add(row.observation);
  info_.add(row.info);
  last_time_ = row.time;
  ++rows_;
}

void FlightLogEpisode::event(const std::string& text) {
  events_.push_back({rows_ == 0 ? 0 : rows_ - 1, last_time_, text});
}

void FlightLogEpisode::finish() {
  for (FlightLogSeries* series : all()) series->flush();
  write_events();
}

FlightLogSeries FlightLogEpisode::make(const char* name, hid_t type,
                                       const std::vector<hsize_t>& shape) const {
  return {writer_, group_, name, type, shape};
}

FlightLogSeries FlightLogEpisode::make_columns(const char* name,
                                               const std::vector<LogColumn>& columns,
                                               hid_t type) const {
  FlightLogSeries series = make(name, type, {columns.size()});
  describe(series, columns);
  return series;
}

FlightLogSeries FlightLogEpisode::make_items(const char* name,
                                             const std::vector<std::string>& items,
                                             const std::vector<LogColumn>& columns) const {
  FlightLogSeries series = make(name, H5T_NATIVE_DOUBLE, {items.size(), columns.size()});
  describe(series, columns);
  if (!series.empty()) writer_.write_attribute(series.dataset(), "items", items);
  return series;
}

void FlightLogEpisode::describe(const FlightLogSeries& series,
                                const std::vector<LogColumn>& columns) const {
  if (series.empty()) return;
  writer_.write_attribute(series.dataset(), "columns", names_of(columns));
  writer_.write_attribute(series.dataset(), "units", units_of(columns));
}

std::array<FlightLogSeries*, 15> FlightLogEpisode::all() {
  return {&time_,   &reward_,  &status_,  &touching_,    &bodies_,
          &goal_,   &q_,       &u_,       &rotor_speed_, &rotor_command_,
          &action_, &command_, &sensors_, &observation_, &info_};
}

void FlightLogEpisode::write_events() const {
  const Hdf5Id text = hdf5_text_type();
  const Hdf5Id type(writer_.check(H5Tcreate(H5T_COMPOUND, sizeof(EventRecord))), H5Tclose);
  writer_.check(H5Tinsert(type, "row", HOFFSET(EventRecord, row), H5T_NATIVE_UINT64));
  writer_.check(H5Tinsert(type, "time", HOFFSET(EventRecord, time), H5T_NATIVE_DOUBLE));
  writer_.check(H5Tinsert(type, "text", HOFFSET(EventRecord, text), text));
  std::vector<EventRecord> records;
  records.reserve(events_.size());
  for (const Event& event : events_) records.push_back({event.row, event.time, event.text.c_str()});
  const hsize_t count = records.size();
  const Hdf5Id space(writer_.check(H5Screate_simple(1, &count, nullptr)), H5Sclose);
  const Hdf5Id set(writer_.check(H5Dcreate2(group_, "events", type, space, H5P_DEFAULT, H5P_DEFAULT,
                                            H5P_DEFAULT)),
                   H5Dclose);
  if (count > 0) writer_.check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, records.data()));
}

}  // namespace skybody
