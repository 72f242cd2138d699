// A growing dataset of rows, written in bursts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "core/io/files/flight_log_hdf5.h"

namespace skybody {

/// Buffers rows until write(). Written data is never changed, so the dataset is not compressed: a
/// compressed chunk moves when it grows. Between two bursts the file is not accessed. A flush after
/// each burst therefore leaves a valid file, even if the program ends abnormally.
class Hdf5Column {
 public:
  /// @param type   HDF5's type of a value
  /// @param width  values per row; 0: the column does not exist
  Hdf5Column(const Hdf5Writer& writer, hid_t parent, const char* name, hid_t type,
             std::size_t width = 1)
      : writer_(&writer), type_(type), size_(H5Tget_size(type)), width_(width) {
    if (width > 0) create(parent, name);
  }

  /// Buffers values of the column's type.
  template <class T>
  void add(const T* values, std::size_t count) {
    SKYBODY_DEMAND(sizeof(T) == size_, "a value of another size than its column's");
    const auto* bytes = reinterpret_cast<const unsigned char*>(values);
    buffer_.insert(buffer_.end(), bytes, bytes + count * sizeof(T));
  }
  template <class T>
  void add(T value) {
    add(&value, 1);
  }
  std::size_t waiting_bytes() const { return buffer_.size(); }
  const void* waiting() const { return buffer_.data(); }
  /// Number of rows, written and buffered.
  std::uint64_t rows() const { return rows_ + waiting_rows(); }

  /// Writes the buffered rows to the file.
  void write() {
    if (buffer_.empty() || width_ == 0) return;
    const hsize_t count[2] = {waiting_rows(), width_}, start[2] = {rows_, 0};
    const hsize_t extent[2] = {rows_ + count[0], width_};
    const int rank = width_ == 1 ? 1 : 2;
    writer_->check(H5Dset_extent(dataset_, extent));
    const Hdf5Id space(writer_->check(H5Dget_space(dataset_)), H5Sclose);
    writer_->check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr));
    const Hdf5Id memory(writer_->check(H5Screate_simple(rank, count, nullptr)), H5Sclose);
    writer_->check(H5Dwrite(dataset_, type_, memory, space, H5P_DEFAULT, buffer_.data()));
    rows_ = extent[0];
    buffer_.clear();
  }

 private:
  hsize_t waiting_rows() const { return width_ == 0 ? 0 : buffer_.size() / (size_ * width_); }

  void create(hid_t parent, const char* name) {
    constexpr hsize_t kChunkBytes = 1 << 16;
    const int rank = width_ == 1 ? 1 : 2;
    const hsize_t none[2] = {0, width_}, most[2] = {H5S_UNLIMITED, width_};
    const hsize_t rows = kChunkBytes / (width_ * size_);
    const hsize_t chunk[2] = {rows > 0 ? rows : 1, width_};
    const Hdf5Id space(writer_->check(H5Screate_simple(rank, none, most)), H5Sclose);
    const Hdf5Id properties(writer_->check(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
    writer_->check(H5Pset_chunk(properties, rank, chunk));
    dataset_ = Hdf5Id(writer_->check(H5Dcreate2(parent, name, type_, space, H5P_DEFAULT, properties,
                                                H5P_DEFAULT)),
                      H5Dclose);
  }

  const Hdf5Writer* writer_;
  hid_t type_;
  std::size_t size_;  ///< of a value [bytes]
  hsize_t width_, rows_ = 0;
  Hdf5Id dataset_;
  std::vector<unsigned char> buffer_;
};

}  // namespace skybody
