#include "tests/integration/flight_file.h"

#include <stdexcept>

namespace skybody::test {
namespace {

template <class Id>
Id check(Id id, const std::string& what) {
  if (id < 0) throw std::runtime_error("HDF5 cannot read " + what);
  return id;
}

/// Closes HDF5 ids in order of destruction.
struct Id {
  hid_t id;
  herr_t (*close)(hid_t);
  ~Id() { close(id); }
  operator hid_t() const { return id; }
};

hid_t text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

/// Copies texts that HDF5 allocated, and frees them.
std::vector<std::string> take(std::vector<char*>& raw) {
  std::vector<std::string> texts;
  for (char* text : raw) {
    texts.emplace_back(text);
    H5free_memory(text);
  }
  return texts;
}

}  // namespace

FlightFile::FlightFile(const std::filesystem::path& path)
    : file_(check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), path.string())) {}

FlightFile::~FlightFile() { H5Fclose(file_); }

bool FlightFile::has(const std::string& object) const {
  return H5Lexists(file_, object.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> FlightFile::names(const std::string& group) const {
  const Id id{check(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), group), H5Gclose};
  std::vector<std::string> names;
  const auto note = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  check(H5Literate(id, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &names), group);
  return names;
}

std::vector<std::size_t> FlightFile::shape(const std::string& dataset) const {
  const Id set{check(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), dataset), H5Dclose};
  const Id space{H5Dget_space(set), H5Sclose};
  std::vector<hsize_t> extent(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  return {extent.begin(), extent.end()};
}

std::vector<double> FlightFile::values(const std::string& dataset) const {
  std::size_t size = 1;
  for (const std::size_t n : shape(dataset)) size *= n;
  std::vector<double> values(size);
  const Id set{check(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), dataset), H5Dclose};
  check(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), dataset);
  return values;
}

std::vector<std::string> FlightFile::texts(const std::string& dataset) const {
  std::vector<char*> raw(shape(dataset).at(0));
  const Id set{check(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), dataset), H5Dclose};
  const Id type{text_type(), H5Tclose};
  check(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(raw.data())), dataset);
  return take(raw);
}

std::string FlightFile::text_attribute(const std::string& object, const char* name) const {
  const Id attribute{
      check(H5Aopen_by_name(file_, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), name),
      H5Aclose};
  const Id type{text_type(), H5Tclose};
  std::vector<char*> raw(1);
  check(H5Aread(attribute, type, static_cast<void*>(raw.data())), name);
  return take(raw).front();
}

std::vector<std::string> FlightFile::texts_attribute(const std::string& object,
                                                     const char* name) const {
  const Id attribute{
      check(H5Aopen_by_name(file_, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), name),
      H5Aclose};
  const Id space{check(H5Aget_space(attribute), name), H5Sclose};
  const Id type{text_type(), H5Tclose};
  std::vector<char*> raw(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  check(H5Aread(attribute, type, static_cast<void*>(raw.data())), name);
  return take(raw);
}

double FlightFile::number_attribute(const std::string& object, const char* name) const {
  const Id attribute{
      check(H5Aopen_by_name(file_, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), name),
      H5Aclose};
  double value = 0.0;
  check(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), name);
  return value;
}

std::vector<std::string> FlightFile::events(const std::string& episode) const {
  const std::string path = episode + "/events";
  std::vector<char*> raw(shape(path).at(0));
  const Id set{check(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), path), H5Dclose};
  const Id text{text_type(), H5Tclose};
  const Id part{H5Tcreate(H5T_COMPOUND, sizeof(char*)), H5Tclose};
  H5Tinsert(part, "text", 0, text);
  check(H5Dread(set, part, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(raw.data())), path);
  return take(raw);
}

}  // namespace skybody::test
