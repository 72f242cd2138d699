#include "core/io/hdf5_reader.h"

#include <system_error>
#include <utility>

#include "core/model/marked_error.h"

namespace skybody {
namespace {

/// Texts of any kind: of fixed length, padded, or of any length.
std::vector<std::string> decode(const std::vector<char>& bytes, std::size_t size) {
  std::vector<std::string> texts;
  for (std::size_t at = 0; at + size <= bytes.size(); at += size) {
    std::string text(bytes.data() + at, size);
    texts.push_back(text.substr(0, text.find('\0')));
  }
  return texts;
}

}  // namespace

Hdf5Reader::Hdf5Reader(std::filesystem::path path, std::string what)
    : path_(std::move(path)), what_(std::move(what)) {
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored)) fail("the file does not exist");
  if (std::filesystem::is_directory(path_, ignored)) fail("this is a folder; give a file");
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  file_ = Hdf5Id(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (file_ < 0) fail("not a " + what_ + " file, or cut short: " + hdf5_reason());
}

void Hdf5Reader::fail(const std::string& message) const {
  throw MarkedError({path_.string(), 0, 0}, message);
}

void Hdf5Reader::check_format(std::int64_t version, const std::string& remedy) const {
  const std::string wanted = "skybody-" + what_, found = text("/", "format");
  if (found != wanted) {
    fail("not a " + what_ + ": its format is `" + found + "`; allowed: `" + wanted + "`");
  }
  const std::int64_t number = integer("/", "version");
  if (number != version) {
    fail(what_ + " format " + std::to_string(number) + "; this Skybody reads format " +
         std::to_string(version) + ": " + remedy);
  }
}

bool Hdf5Reader::has(const std::string& object) const {
  if (object == "/") return true;
  for (std::size_t at = object.find('/', 1);; at = object.find('/', at + 1)) {
    if (H5Lexists(file_, object.substr(0, at).c_str(), H5P_DEFAULT) <= 0) return false;
    if (at == std::string::npos) return true;
  }
}

Hdf5Id Hdf5Reader::open_attribute(const std::string& object, const char* attribute) const {
  if (!has(object)) fail("`" + object + "` is missing in this " + what_ + " file");
  Hdf5Id id(H5Aopen_by_name(file_, object.c_str(), attribute, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (id < 0) {
    fail("the attribute `" + std::string(attribute) + "` of `" + object + "` is missing in this " +
         what_ + " file");
  }
  return id;
}

Hdf5Id Hdf5Reader::open_dataset(const std::string& dataset) const {
  if (!has(dataset)) fail("`" + dataset + "` is missing in this " + what_ + " file");
  Hdf5Id id(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (id < 0) fail("`" + dataset + "` cannot be read: " + hdf5_reason());
  return id;
}

std::string Hdf5Reader::text(const std::string& object, const char* attribute) const {
  const Hdf5Id id = open_attribute(object, attribute);
  const Hdf5Id type(H5Aget_type(id), H5Tclose);
  const Hdf5Id space(H5Aget_space(id), H5Sclose);
  if (H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1) {
    fail("the attribute `" + std::string(attribute) + "` of `" + object + "` is not a text");
  }
  if (H5Tis_variable_str(type) > 0) {
    const Hdf5Id memory = hdf5_text_type();
    H5Tset_cset(memory, H5Tget_cset(type));
    char* characters = nullptr;
    if (H5Aread(id, memory, static_cast<void*>(&characters)) < 0) fail(hdf5_reason());
    const std::string value(characters == nullptr ? "" : characters);
    H5free_memory(characters);
    return value;
  }
  std::vector<char> bytes(H5Tget_size(type));
  if (H5Aread(id, type, bytes.data()) < 0) fail(hdf5_reason());
  return decode(bytes, bytes.size()).at(0);
}

std::vector<std::string> Hdf5Reader::texts(const std::string& dataset) const {
  const Hdf5Id id = open_dataset(dataset);
  const Hdf5Id type(H5Dget_type(id), H5Tclose);
  const Hdf5Id space(H5Dget_space(id), H5Sclose);
  if (H5Tget_class(type) != H5T_STRING) fail("`" + dataset + "` does not hold texts");
  const auto count = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
  if (H5Tis_variable_str(type) <= 0) {
    const std::size_t size = H5Tget_size(type);
    std::vector<char> bytes(count * size);
    if (count > 0 && H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) {
      fail("`" + dataset + "` cannot be read: " + hdf5_reason());
    }
    return decode(bytes, size);
  }
  std::vector<char*> list(count);
  std::vector<std::string> values;
  if (list.empty()) return values;
  const Hdf5Id memory = hdf5_text_type();
  H5Tset_cset(memory, H5Tget_cset(type));
  if (H5Dread(id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(list.data())) < 0) {
    fail("`" + dataset + "` cannot be read: " + hdf5_reason());
  }
  for (const char* characters : list) values.emplace_back(characters == nullptr ? "" : characters);
  H5Dvlen_reclaim(memory, space, H5P_DEFAULT, static_cast<void*>(list.data()));
  return values;
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
  const Hdf5Id id = open_dataset(dataset);
  const Hdf5Id space(H5Dget_space(id), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  hsize_t extent[2] = {0, 1};
  if (rank < 1 || rank > 2) fail("`" + dataset + "` is not a vector or a matrix");
  H5Sget_simple_extent_dims(space, extent, nullptr);
  return {extent[0], extent[1], rank};
}

void Hdf5Reader::read(const std::string& dataset, std::size_t first, std::size_t count, hid_t type,
                      void* out) const {
  if (count == 0) return;
  const Shape s = shape(dataset);
  if (first + count > s.rows) {
    fail("`" + dataset + "` ends too early: it has " + std::to_string(s.rows) + " rows, " +
         std::to_string(first + count) + " are needed");
  }
  const Hdf5Id id = open_dataset(dataset);
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
