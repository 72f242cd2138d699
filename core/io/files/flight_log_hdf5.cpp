#include "core/io/files/flight_log_hdf5.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/base/system/error.h"

namespace skybody {
namespace {

/// Stores the first message of the error stack: the one nearest to the cause.
herr_t take_first(unsigned n, const H5E_error2_t* error, void* text) {
  if (n == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
  return 0;
}

/// The operating system's message if HDF5's text contains an errno, else the text.
std::string shorten(const std::string& text) {
  const std::string key = "error message = '";
  const std::size_t begin = text.find(key);
  if (begin == std::string::npos) return text;
  const std::size_t first = begin + key.size();
  return text.substr(first, text.find('\'', first) - first);
}

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> list;
  list.reserve(texts.size());
  for (const std::string& text : texts) list.push_back(text.c_str());
  return list;
}

}  // namespace

QuietHdf5::QuietHdf5() {
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietHdf5::~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

Hdf5Id hdf5_text_type() {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

Hdf5Id hdf5_text_type(std::size_t size) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(size, 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

Hdf5Id Hdf5Writer::create_file() const {
  const Hdf5Id access(check(H5Pcreate(H5P_FILE_ACCESS)), H5Pclose);
  check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_LATEST));
  check(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG));
  return {check(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access)), H5Fclose};
}

Hdf5Id Hdf5Writer::create_group(hid_t parent, const std::string& name) const {
  return {check(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)), H5Gclose};
}

namespace {

void write_scalar(const Hdf5Writer& writer, hid_t object, const char* name, hid_t type,
                  const void* value) {
  const Hdf5Id space(writer.check(H5Screate(H5S_SCALAR)), H5Sclose);
  const Hdf5Id attribute(
      writer.check(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT)), H5Aclose);
  writer.check(H5Awrite(attribute, type, value));
}

Hdf5Id vector_space(const Hdf5Writer& writer, std::size_t size) {
  const hsize_t extent = size;
  return {writer.check(H5Screate_simple(1, &extent, nullptr)), H5Sclose};
}

void write_vector(const Hdf5Writer& writer, hid_t parent, const char* name, hid_t type,
                  std::size_t size, const void* values) {
  const Hdf5Id space = vector_space(writer, size);
  const Hdf5Id set(
      writer.check(H5Dcreate2(parent, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
      H5Dclose);
  if (size > 0) writer.check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
}

}  // namespace

void Hdf5Writer::write_attribute(hid_t object, const char* name, const std::string& value) const {
  const char* text = value.c_str();
  write_scalar(*this, object, name, hdf5_text_type(), static_cast<const void*>(&text));
}

void Hdf5Writer::write_text(hid_t object, const char* name, const std::string& value) const {
  write_scalar(*this, object, name, hdf5_text_type(value.size()), value.c_str());
}

void Hdf5Writer::write_attribute(hid_t object, const char* name, double value) const {
  write_scalar(*this, object, name, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::write_attribute(hid_t object, const char* name, std::int64_t value) const {
  write_scalar(*this, object, name, H5T_NATIVE_INT64, &value);
}

void Hdf5Writer::write_attribute(hid_t object, const char* name,
                                 const std::vector<std::string>& values) const {
  const Hdf5Id type = hdf5_text_type();
  const Hdf5Id space = vector_space(*this, values.size());
  const Hdf5Id attribute(check(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT)),
                         H5Aclose);
  const std::vector<const char*> texts = pointers(values);
  if (!texts.empty()) check(H5Awrite(attribute, type, static_cast<const void*>(texts.data())));
}

void Hdf5Writer::write_dataset(hid_t parent, const char* name,
                               const std::vector<double>& values) const {
  write_vector(*this, parent, name, H5T_NATIVE_DOUBLE, values.size(), values.data());
}

void Hdf5Writer::write_dataset(hid_t parent, const char* name,
                               const std::vector<std::string>& values) const {
  const std::vector<const char*> texts = pointers(values);
  write_vector(*this, parent, name, hdf5_text_type(), texts.size(),
               static_cast<const void*>(texts.data()));
}

std::string hdf5_reason() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &reason);
  return reason.empty() ? "HDF5 gives no reason" : shorten(reason);
}

void Hdf5Writer::fail() const {
  throw Error("cannot write the " + kind_ + " " + path_.string() + ": " + hdf5_reason());
}

}  // namespace skybody
