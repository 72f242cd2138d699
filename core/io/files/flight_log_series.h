// One dataset of the flight log that grows by one row per step, buffered by chunks.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/io/files/flight_log_hdf5.h"

namespace skybody {

/// Appends rows of a fixed shape. A series of zero width stores nothing and creates no dataset.
class FlightLogSeries {
 public:
  /// @param type        HDF5's native type of one value
  /// @param shape       of one row; empty: a scalar
  FlightLogSeries(const Hdf5Writer& writer, hid_t parent, const char* name, hid_t type,
                  const std::vector<hsize_t>& shape);

  /// Adds one row.
  template <class T>
  void add(std::span<const T> values) {
    add_bytes(values.data(), values.size_bytes());
  }
  /// Writes the buffered rows.
  void flush();

  bool empty() const { return row_bytes_ == 0; }
  hid_t dataset() const { return dataset_; }

 private:
  void create(hid_t parent, const char* name);
  void add_bytes(const void* values, std::size_t size);

  const Hdf5Writer* writer_;
  hid_t type_;
  std::vector<hsize_t> extent_;  ///< rows on disk, then the shape of a row
  std::size_t row_bytes_ = 0;
  std::size_t chunk_rows_ = 0;
  std::vector<std::byte> buffer_;
  Hdf5Id dataset_;
};

}  // namespace skybody
