// Reads untrusted HDF5 files: every failure is one message with the file's name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/files/flight_log_hdf5.h"

namespace skybody {

/// One file, open for reading. Objects are named by their path within it ("/" is the root). Numbers
/// are converted to the requested type. Every member throws LocatedError with the file's name if an
/// object is missing or of another kind or shape.
///
/// The file may be malicious:
/// - No other file is opened: links other than hard ones, external and virtual storage, and filters
///   other than Fletcher's checksum are rejected.
/// - No memory is allocated for more values than the file's bytes can hold.
/// - Texts of variable length are rejected: HDF5's reader of their heap crashes on some damaged
///   files.
class Hdf5Reader {
 public:
  /// @param kind    kind of file, for messages: "policy"
  /// @param remedy  advice for files of another kind
  Hdf5Reader(std::filesystem::path path, std::string kind, std::string remedy);
  /// Reads the file's bytes from memory; `path` is for messages.
  Hdf5Reader(std::filesystem::path path, std::string kind, std::string remedy,
             const std::string& bytes);

  const std::filesystem::path& path() const { return path_; }
  /// Whether the object exists. @throws LocatedError if the path contains a link that is not hard
  bool has(const std::string& object) const;

  std::string text(const std::string& object, const char* attribute) const;
  std::vector<std::string> texts(const std::string& dataset) const;
  std::int64_t integer(const std::string& object, const char* attribute) const;
  /// Rejects a file whose attributes `format` and `version` are not `skybody-KIND` and `version`.
  /// @param remedy  advice for files of another version
  void check_format(std::int64_t version, const std::string& remedy) const;
  double real(const std::string& object, const char* attribute) const;

  /// Rows and columns; {n, 1} for a vector.
  struct Shape {
    std::size_t rows = 0, columns = 1;
    int rank = 1;
  };
  Shape shape(const std::string& dataset) const;
  /// Reads `count` rows from `first` on, converted to the type of `out`, which must have room.
  void read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                 double* out) const;
  void read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                 float* out) const;
  void read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                 std::uint64_t* out) const;
  void read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                 std::int32_t* out) const;
  void read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                 std::uint8_t* out) const;
  /// A whole dataset.
  template <class T>
  std::vector<T> all(const std::string& dataset) const {
    return rows<T>(dataset, 0, shape(dataset).rows);
  }
  /// `count` rows from `first` on.
  template <class T>
  std::vector<T> rows(const std::string& dataset, std::size_t first, std::size_t count) const {
    const Shape s = shape(dataset);
    check_rows(dataset, s, first, count);
    std::vector<T> values(count * s.columns);
    read_rows(dataset, first, count, values.data());
    return values;
  }

  /// @throws LocatedError with the file's name before the message
  [[noreturn]] void fail(const std::string& message) const;

 private:
  void open(const std::filesystem::path& name, hid_t access);
  void check_storage(const std::string& dataset, hid_t id) const;
  void check_layout(const std::string& dataset, hid_t properties) const;
  void check_chunks(const std::string& dataset, hid_t properties, int rank, std::size_t size) const;
  void check_rows(const std::string& dataset, const Shape& shape, std::size_t first,
                  std::size_t count) const;
  std::size_t check_text_type(const std::string& name, hid_t type) const;
  Shape shape_of(const std::string& dataset, hid_t id) const;
  Hdf5Id open_attribute(const std::string& object, const char* attribute) const;
  Hdf5Id open_dataset(const std::string& dataset) const;
  void read(const std::string& dataset, std::size_t first, std::size_t count, hid_t type,
            void* out) const;
  void read_number(const std::string& object, const char* attribute, hid_t type, void* out) const;

  QuietHdf5 quiet_;
  std::filesystem::path path_;
  std::string kind_, remedy_;
  std::uintmax_t bytes_ = 0;  ///< of the file
  Hdf5Id file_;
};

/// @throws LocatedError unless `file` is a regular file (not a device, pipe or folder)
void check_regular_file(const std::filesystem::path& file);

}  // namespace skybody
