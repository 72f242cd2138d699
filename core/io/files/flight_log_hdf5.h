// A thin wrapper of HDF5's C API: ids that close themselves, failures as Error.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace skybody {

/// Owns an HDF5 id and closes it with the function of its kind.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);

  Hdf5Id() = default;
  Hdf5Id(hid_t id, Close close) : id_(id), close_(close) {}
  Hdf5Id(Hdf5Id&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Id() { reset(); }

  operator hid_t() const { return id_; }
  /// Closes it now. Returns whether closing succeeded.
  bool reset() {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id < 0 || close_(id) >= 0;
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

/// Suppresses HDF5's printed error stack during its lifetime; Skybody reports the errors itself.
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Creates objects inside one file. Every member throws Error with the file's name and HDF5's
/// reason.
class Hdf5Writer {
 public:
  /// @param kind  kind of file, for messages
  explicit Hdf5Writer(std::filesystem::path path, std::string kind = "flight log")
      : path_(std::move(path)), kind_(std::move(kind)) {}

  Hdf5Id create_file() const;
  Hdf5Id create_group(hid_t parent, const std::string& name) const;

  void write_attribute(hid_t object, const char* name, const std::string& value) const;
  /// The same as a text of fixed length, stored inside the object. HDF5 stores texts of variable
  /// length in a heap whose reader crashes on some damaged files.
  void write_text(hid_t object, const char* name, const std::string& value) const;
  void write_attribute(hid_t object, const char* name, double value) const;
  void write_attribute(hid_t object, const char* name, std::int64_t value) const;
  void write_attribute(hid_t object, const char* name,
                       const std::vector<std::string>& values) const;

  void write_dataset(hid_t parent, const char* name, const std::vector<double>& values) const;
  void write_dataset(hid_t parent, const char* name, const std::vector<std::string>& values) const;

  /// The id or status; fails if it is negative.
  template <class Result>
  Result check(Result result) const {
    if (result < 0) fail();
    return result;
  }
  /// @throws Error with HDF5's last message
  [[noreturn]] void fail() const;

 private:
  std::filesystem::path path_;
  std::string kind_;
};

/// HDF5's last message, shortened.
std::string hdf5_reason();

/// HDF5's type of a UTF-8 text of variable length.
Hdf5Id hdf5_text_type();
/// HDF5's type of a UTF-8 text of at most `size` bytes, padded with zeros.
Hdf5Id hdf5_text_type(std::size_t size);

}  // namespace skybody
