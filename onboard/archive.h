// Values to bytes and back. Numbers are little-endian, as both supported processors store them.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/system/error.h"

namespace skybody::onboard {

static_assert(std::endian::native == std::endian::little);

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Appends values to a string. Structures have `template <class A> void visit(A&)`, which both
/// archives call.
class Writer {
 public:
  static constexpr bool kWrites = true;
  const std::string& bytes() const { return bytes_; }

  template <class... Values>
  void operator()(Values&... values) {
    (one(values), ...);
  }
  template <class T>
  void raw(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  template <class T>
  void size(std::vector<T>& values, std::size_t) {
    raw(static_cast<std::uint32_t>(values.size()));
  }

 private:
  template <Plain T>
  void one(const T& value) {
    raw(value);
  }
  void one(const std::string& text) {
    raw(static_cast<std::uint32_t>(text.size()));
    bytes_ += text;
  }
  template <class T>
  void one(std::vector<T>& values) {
    size(values, 1);
    for (T& value : values) one(value);
  }
  template <class T>
  requires requires(T& value, Writer& writer) { value.visit(writer); }
  void one(T& value) { value.visit(*this); }

  std::string bytes_;
};

/// Reads the bytes of a Writer. @throws Error if the bytes end too early
class Reader {
 public:
  static constexpr bool kWrites = false;
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  bool is_at_end() const { return rest_.empty(); }

  template <class... Values>
  void operator()(Values&... values) {
    (one(values), ...);
  }
  template <class T>
  void raw(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
  }
  /// Makes as many values as were written. @param least  bytes of each
  template <class T>
  void size(std::vector<T>& values, std::size_t least) {
    std::uint32_t count = 0;
    raw(count);
    if (count > rest_.size() / least) throw Error("it ends too early");
    values.assign(count, T{});
  }

 private:
  template <Plain T>
  void one(T& value) {
    raw(value);
  }
  void one(std::string& text) {
    std::uint32_t count = 0;
    raw(count);
    text = take(count);
  }
  template <class T>
  void one(std::vector<T>& values) {
    size(values, 1);
    for (T& value : values) one(value);
  }
  template <class T>
  requires requires(T& value, Reader& reader) { value.visit(reader); }
  void one(T& value) { value.visit(*this); }

  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw Error("it ends too early");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  std::string_view rest_;
};

}  // namespace skybody::onboard
