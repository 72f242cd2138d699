// One episode of the flight log: the group /episodes/NNNN with its datasets and events.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/files/flight_log.h"
#include "core/io/files/flight_log_series.h"

namespace skybody {

std::vector<std::string> names_of(const std::vector<LogColumn>& columns);
std::vector<std::string> units_of(const std::vector<LogColumn>& columns);

/// The datasets of one episode. The writer and the group must outlive it.
class FlightLogEpisode {
 public:
  FlightLogEpisode(const Hdf5Writer& writer, Hdf5Id group, const FlightLogHeader& header);

  void add(const FlightLogRow& row);
  /// Adds an event at the last row.
  void event(const std::string& text);
  /// Writes the buffered rows and events.
  void finish();

 private:
  FlightLogSeries make(const char* name, hid_t type, const std::vector<hsize_t>& shape) const;
  FlightLogSeries make_columns(const char* name, const std::vector<LogColumn>& columns,
                               hid_t type) const;
  FlightLogSeries make_items(const char* name, const std::vector<std::string>& items,
                             const std::vector<LogColumn>& columns) const;
  void describe(const FlightLogSeries& series, const std::vector<LogColumn>& columns) const;
  std::array<FlightLogSeries*, 15> all();
  void write_events() const;

  /// One row of the table of events.
  struct Event {
    std::uint64_t row;
    double time;
    std::string text;
  };

  const Hdf5Writer& writer_;
  Hdf5Id group_;
  FlightLogSeries time_, reward_, status_, touching_, bodies_, goal_, q_, u_, rotor_speed_,
      rotor_command_, action_, command_, sensors_, observation_, info_;
  std::vector<Event> events_;
  std::uint64_t rows_ = 0;
  double last_time_ = 0.0;
};

}  // namespace skybody
