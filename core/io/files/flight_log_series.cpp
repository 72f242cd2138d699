#include "core/io/files/flight_log_series.h"

#include <algorithm>

#include "core/base/system/error.h"

namespace skybody {
namespace {

constexpr std::size_t kChunkBytes = 1 << 18;
constexpr std::size_t kMostChunkRows = 1024;
constexpr unsigned kGzipLevel = 4;

}  // namespace

FlightLogSeries::FlightLogSeries(const Hdf5Writer& writer, hid_t parent, const char* name,
                                 hid_t type, const std::vector<hsize_t>& shape)
    : writer_(&writer), type_(type), extent_{0} {
  row_bytes_ = H5Tget_size(type);
  for (const hsize_t size : shape) {
    extent_.push_back(size);
    row_bytes_ *= size;
  }
  if (empty()) return;
  chunk_rows_ = std::clamp<std::size_t>(kChunkBytes / row_bytes_, 1, kMostChunkRows);
  buffer_.reserve(chunk_rows_ * row_bytes_);
  create(parent, name);
}

void FlightLogSeries::create(hid_t parent, const char* name) {
  std::vector<hsize_t> most = extent_, chunk = extent_;
  most[0] = H5S_UNLIMITED;
  chunk[0] = chunk_rows_;
  const int rank = static_cast<int>(extent_.size());
  const Hdf5Id space(writer_->check(H5Screate_simple(rank, extent_.data(), most.data())), H5Sclose);
  const Hdf5Id properties(writer_->check(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  writer_->check(H5Pset_chunk(properties, rank, chunk.data()));
  writer_->check(H5Pset_shuffle(properties));
  writer_->check(H5Pset_deflate(properties, kGzipLevel));
  dataset_ = Hdf5Id(
      writer_->check(H5Dcreate2(parent, name, type_, space, H5P_DEFAULT, properties, H5P_DEFAULT)),
      H5Dclose);
}

void FlightLogSeries::add_bytes(const void* values, std::size_t size) {
  SKYBODY_DEMAND(size == row_bytes_, "a row of the flight log has the wrong width");
  if (empty()) return;
  const std::byte* bytes = static_cast<const std::byte*>(values);
  buffer_.insert(buffer_.end(), bytes, bytes + size);
  if (buffer_.size() >= chunk_rows_ * row_bytes_) flush();
}

void FlightLogSeries::flush() {
  if (buffer_.empty()) return;
  std::vector<hsize_t> start(extent_.size(), 0), count = extent_;
  start[0] = extent_[0];
  count[0] = buffer_.size() / row_bytes_;
  extent_[0] += count[0];
  writer_->check(H5Dset_extent(dataset_, extent_.data()));
  const Hdf5Id file_space(writer_->check(H5Dget_space(dataset_)), H5Sclose);
  writer_->check(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr,
                                     count.data(), nullptr));
  const Hdf5Id memory(
      writer_->check(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr)),
      H5Sclose);
  writer_->check(H5Dwrite(dataset_, type_, memory, file_space, H5P_DEFAULT, buffer_.data()));
  buffer_.clear();
}

}  // namespace skybody
