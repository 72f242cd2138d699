// A cache-line-aligned array of fixed size, for values in lanes.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>

namespace skybody {

/// Owns `size` values of a trivially copyable type, initially zero. Movable.
template <class T>
class AlignedArray {
 public:
  static constexpr std::size_t kAlignment = 64;

  AlignedArray() = default;
  explicit AlignedArray(std::size_t size) : size_(size) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (size == 0) return;
    const std::size_t bytes = size * sizeof(T);
    data_.reset(static_cast<T*>(::operator new[](bytes, std::align_val_t{kAlignment})));
    std::memset(static_cast<void*>(data_.get()), 0, bytes);
  }

  void fill_zero() {
    if (size_ > 0) std::memset(static_cast<void*>(data_.get()), 0, size_ * sizeof(T));
  }

  std::size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* p) const {
      ::operator delete[](static_cast<void*>(p), std::align_val_t{kAlignment});
    }
  };
  std::size_t size_ = 0;
  std::unique_ptr<T[], Free> data_;
};

}  // namespace skybody
