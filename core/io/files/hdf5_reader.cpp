#include "core/io/files/hdf5_reader.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/model/located_error.h"

namespace skybody {
namespace {

constexpr std::size_t kMemoryIncrement = 1 << 16;  // of a file in memory, which does not grow
// HDF5 allocates whole chunks. Skybody's chunks have 64 KiB, or one row if a row is longer.
constexpr std::size_t kLargestChunk = 16 << 20;

}  // namespace

Hdf5Reader::Hdf5Reader(std::filesystem::path path, std::string kind, std::string remedy)
    : path_(std::move(path)), kind_(std::move(kind)), remedy_(std::move(remedy)) {
  check_regular_file(path_);
  std::error_code ignored;
  bytes_ = std::filesystem::file_size(path_, ignored);
  open(path_, Hdf5Id(H5Pcreate(H5P_FILE_ACCESS), H5Pclose));
}

Hdf5Reader::Hdf5Reader(std::filesystem::path path, std::string kind, std::string remedy,
                       const std::string& bytes)
    : path_(std::move(path)),
      kind_(std::move(kind)),
      remedy_(std::move(remedy)),
      bytes_(bytes.size()) {
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, kMemoryIncrement, false);
  // HDF5 copies the bytes and does not write to them.
  H5Pset_file_image(access, const_cast<char*>(bytes.data()), bytes.size());
  open(path_ / "in memory", access);  // HDF5 requires the name of a file that does not exist
}

void Hdf5Reader::open(const std::filesystem::path& name, hid_t access) {
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  file_ = Hdf5Id(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (file_ < 0) fail("not a " + kind_ + " file, or cut short: " + hdf5_reason() + "; " + remedy_);
}

void check_regular_file(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(file, ignored);
  const auto fail = [&](const char* message) {
    throw LocatedError({file.string(), 0, 0}, message);
  };
  if (!std::filesystem::exists(status)) fail("the file does not exist");
  if (std::filesystem::is_directory(status)) fail("this is a folder; give a file");
  if (!std::filesystem::is_regular_file(status)) fail("this is not a regular file");
}

void Hdf5Reader::fail(const std::string& message) const {
  throw LocatedError({path_.string(), 0, 0}, message);
}

void Hdf5Reader::check_format(std::int64_t version, const std::string& remedy) const {
  const Hdf5Id type(H5Aget_type(open_attribute("/", "format")), H5Tclose);
  if (H5Tis_variable_str(type) > 0) {
    fail("not a " + kind_ + ": its format is a text of variable length, as no " + kind_ + " has; " +
         remedy_);
  }
  const std::string wanted = "skybody-" + kind_, found = text("/", "format");
  if (found != wanted) {
    fail("not a " + kind_ + ": its format is `" + found + "`; allowed: `" + wanted + "`; " +
         remedy_);
  }
  const std::int64_t number = integer("/", "version");
  if (number != version) {
    fail(kind_ + " format " + std::to_string(number) + "; this Skybody reads format " +
         std::to_string(version) + ": " + remedy);
  }
}

bool Hdf5Reader::has(const std::string& object) const {
  if (object == "/") return true;
  for (std::size_t at = object.find('/', 1);; at = object.find('/', at + 1)) {
    const std::string link = object.substr(0, at);
    if (H5Lexists(file_, link.c_str(), H5P_DEFAULT) <= 0) return false;
    H5L_info_t info;
    if (H5Lget_info(file_, link.c_str(), &info, H5P_DEFAULT) < 0 || info.type != H5L_TYPE_HARD) {
      fail("`" + link + "` is a link to another place; a " + kind_ + " holds its values itself");
    }
    if (at == std::string::npos) return true;
  }
}

Hdf5Id Hdf5Reader::open_attribute(const std::string& object, const char* attribute) const {
  if (!has(object)) fail("`" + object + "` is missing in this " + kind_ + " file");
  Hdf5Id id(H5Aopen_by_name(file_, object.c_str(), attribute, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (id < 0) {
    fail("the attribute `" + std::string(attribute) + "` of `" + object + "` is missing in this " +
         kind_ + " file");
  }
  return id;
}

Hdf5Id Hdf5Reader::open_dataset(const std::string& dataset) const {
  if (!has(dataset)) fail("`" + dataset + "` is missing in this " + kind_ + " file");
  Hdf5Id id(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (id < 0) fail("`" + dataset + "` cannot be read: " + hdf5_reason());
  check_storage(dataset, id);
  return id;
}

/// Rejects storage that reads other files, runs other filters or needs unbounded memory.
void Hdf5Reader::check_storage(const std::string& dataset, hid_t id) const {
  const Hdf5Id properties(H5Dget_create_plist(id), H5Pclose);
  const Hdf5Id type(H5Dget_type(id), H5Tclose);
  const std::size_t size = std::max<std::size_t>(H5Tget_size(type), 1);
  const Shape shape = shape_of(dataset, id);
  check_layout(dataset, properties);
  if (shape.columns != 0 && shape.rows > bytes_ / size / shape.columns) {
    fail("`" + dataset + "` claims more values than the file has bytes for: the file is damaged");
  }
  if (H5Pget_layout(properties) == H5D_CHUNKED) check_chunks(dataset, properties, shape.rank, size);
}

void Hdf5Reader::check_layout(const std::string& dataset, hid_t properties) const {
  const H5D_layout_t layout = H5Pget_layout(properties);
  const bool within = layout == H5D_COMPACT || layout == H5D_CONTIGUOUS || layout == H5D_CHUNKED;
  if (!within || H5Pget_external_count(properties) != 0) {
    fail("`" + dataset + "` is stored in other files; a " + kind_ + " holds its values itself");
  }
  for (int k = 0; k < H5Pget_nfilters(properties); ++k) {
    std::size_t values = 0;
    unsigned flags = 0, config = 0;
    const H5Z_filter_t filter = H5Pget_filter2(properties, static_cast<unsigned>(k), &flags,
                                               &values, nullptr, 0, nullptr, &config);
    if (filter == H5Z_FILTER_FLETCHER32) continue;
    fail("`" + dataset + "` is compressed or filtered; allowed: fletcher32");
  }
}

void Hdf5Reader::check_chunks(const std::string& dataset, hid_t properties, int rank,
                              std::size_t size) const {
  hsize_t chunk[2] = {1, 1};
  if (H5Pget_chunk(properties, rank, chunk) < 0) fail(hdf5_reason());
  if (chunk[0] <= kLargestChunk / size / std::max<hsize_t>(chunk[1], 1)) return;
  fail("`" + dataset + "` has chunks of more than " + std::to_string(kLargestChunk >> 20) + " MiB");
}

void Hdf5Reader::check_rows(const std::string& dataset, const Shape& shape, std::size_t first,
                            std::size_t count) const {
  if (first <= shape.rows && count <= shape.rows - first) return;
  fail("`" + dataset + "` ends too early: it has " + std::to_string(shape.rows) + " rows, " +
       std::to_string(count) + " are needed from row " + std::to_string(first) + " on");
}

/// The length of texts of `type`, which must be fixed.
std::size_t Hdf5Reader::check_text_type(const std::string& name, hid_t type) const {
  if (H5Tget_class(type) != H5T_STRING) fail(name + " is not a text");
  if (H5Tis_variable_str(type) != 0) {
    fail(name + " is a text of variable length; allowed: texts of fixed length");
  }
  const std::size_t size = H5Tget_size(type);
  if (size > bytes_) fail(name + " claims to be longer than the file: the file is damaged");
  return size;
}

std::string Hdf5Reader::text(const std::string& object, const char* attribute) const {
  const Hdf5Id id = open_attribute(object, attribute);
  const Hdf5Id type(H5Aget_type(id), H5Tclose);
  const Hdf5Id space(H5Aget_space(id), H5Sclose);
  const std::string name = "the attribute `" + std::string(attribute) + "` of `" + object + "`";
  std::string bytes(check_text_type(name, type), '\0');
  if (H5Sget_simple_extent_npoints(space) != 1) fail(name + " is not a text");
  if (H5Aread(id, type, bytes.data()) < 0) fail(hdf5_reason());
  return bytes.substr(0, bytes.find('\0'));
}

std::vector<std::string> Hdf5Reader::texts(const std::string& dataset) const {
  const Hdf5Id id = open_dataset(dataset);
  const Hdf5Id type(H5Dget_type(id), H5Tclose);
  const std::size_t size = check_text_type("`" + dataset + "`", type);
  const Shape shape = shape_of(dataset, id);
  std::string bytes(shape.rows * shape.columns * size, '\0');
  if (!bytes.empty() && H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) {
    fail("`" + dataset + "` cannot be read: " + hdf5_reason());
  }
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < bytes.size(); at += size) {
    const std::string text = bytes.substr(at, size);
    texts.push_back(text.substr(0, text.find('\0')));
  }
  return texts;
}

void Hdf5Reader::read_number(const std::string& object, const char* attribute, hid_t type,
                             void* out) const {
  const Hdf5Id id = open_attribute(object, attribute);
  const Hdf5Id stored(H5Aget_type(id), H5Tclose);
  const Hdf5Id space(H5Aget_space(id), H5Sclose);
  const H5T_class_t kind = H5Tget_class(stored);
  const bool whole = H5Tget_class(type) == H5T_INTEGER;
  if ((kind != H5T_INTEGER && (whole || kind != H5T_FLOAT)) ||
      H5Sget_simple_extent_npoints(space) != 1) {
    fail("the attribute `" + std::string(attribute) + "` of `" + object + "` is not a " +
         (whole ? "whole number" : "number"));
  }
  if (H5Aread(id, type, out) < 0) fail(hdf5_reason());
}

std::int64_t Hdf5Reader::integer(const std::string& object, const char* attribute) const {
  std::int64_t value = 0;
  read_number(object, attribute, H5T_NATIVE_INT64, &value);
  return value;
}

double Hdf5Reader::real(const std::string& object, const char* attribute) const {
  double value = 0.0;
  read_number(object, attribute, H5T_NATIVE_DOUBLE, &value);
  return value;
}

Hdf5Reader::Shape Hdf5Reader::shape(const std::string& dataset) const {
  return shape_of(dataset, open_dataset(dataset));
}

Hdf5Reader::Shape Hdf5Reader::shape_of(const std::string& dataset, hid_t id) const {
  const Hdf5Id space(H5Dget_space(id), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  hsize_t extent[2] = {0, 1};
  if (rank < 1 || rank > 2) fail("`" + dataset + "` is not a vector or a matrix");
  H5Sget_simple_extent_dims(space, extent, nullptr);
  return {static_cast<std::size_t>(extent[0]), static_cast<std::size_t>(extent[1]), rank};
}

void Hdf5Reader::read(const std::string& dataset, std::size_t first, std::size_t count, hid_t type,
                      void* out) const {
  if (count == 0) return;
  const Hdf5Id id = open_dataset(dataset);
  const Shape s = shape_of(dataset, id);
  check_rows(dataset, s, first, count);
  const Hdf5Id stored(H5Dget_type(id), H5Tclose);
  const H5T_class_t kind = H5Tget_class(stored);
  if (kind != H5T_INTEGER && kind != H5T_FLOAT) fail("`" + dataset + "` does not hold numbers");
  const Hdf5Id space(H5Dget_space(id), H5Sclose);
  const hsize_t start[2] = {first, 0}, extent[2] = {count, s.columns};
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, extent, nullptr);
  const Hdf5Id memory(H5Screate_simple(s.rank, extent, nullptr), H5Sclose);
  if (H5Dread(id, type, memory, space, H5P_DEFAULT, out) < 0) {
    fail("`" + dataset + "` cannot be read: " + hdf5_reason());
  }
}

void Hdf5Reader::read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                           double* out) const {
  read(dataset, first, count, H5T_NATIVE_DOUBLE, out);
}
void Hdf5Reader::read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                           float* out) const {
  read(dataset, first, count, H5T_NATIVE_FLOAT, out);
}
void Hdf5Reader::read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                           std::uint64_t* out) const {
  read(dataset, first, count, H5T_NATIVE_UINT64, out);
}
void Hdf5Reader::read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                           std::int32_t* out) const {
  read(dataset, first, count, H5T_NATIVE_INT32, out);
}
void Hdf5Reader::read_rows(const std::string& dataset, std::size_t first, std::size_t count,
                           std::uint8_t* out) const {
  read(dataset, first, count, H5T_NATIVE_UINT8, out);
}

}  // namespace skybody
