// A task's memory of the last few actions or states, in its buffer.
#pragma once

#include <skybody/plugin.h>

#include "plugins/task_kit/parts.h"

namespace skybody::task_kit {

/// Allocates words of a task's buffer one after another. configure() ends with
/// `setup.buffer(plan.size())`.
class BufferPlan {
 public:
  /// @returns the first of `words` words
  int take(int words) {
    const int first = size_;
    size_ += words;
    return first;
  }
  int size() const { return size_; }  ///< words so far

 private:
  int size_ = 0;
};

/// The last `length` entries of `width` values each, the newest first.
class History {
 public:
  History() = default;
  /// Allocates its words from the plan.
  History(BufferPlan& plan, int length, int width)
      : first_(plan.take(length * width)), length_(length), width_(width) {}

  int size() const { return length_ * width_; }  ///< values of all entries

  /// Sets all entries to `entry(k)`, k = 0 .. width - 1.
  template <class Real, class Entry>
  SKYBODY_INLINE void fill(const Values<Real>& buffer, const Entry& entry) const {
    for (int k = 0; k < width_; ++k) {
      const Real value = entry(k);
      for (int age = 0; age < length_; ++age) buffer.set(place(age, k), value);
    }
  }
  /// Where `due` holds, shifts the entries by one: the oldest is dropped, and `entry(k)` becomes
  /// the newest.
  template <class Real, class Entry>
  SKYBODY_INLINE void push(const Values<Real>& buffer, const MaskOf<Real>& due,
                           const Entry& entry) const {
    for (int k = 0; k < width_; ++k) {
      for (int age = length_ - 1; age > 0; --age) {
        buffer.set(place(age, k), choose(due, buffer[place(age - 1, k)], buffer[place(age, k)]));
      }
      buffer.set(place(0, k), choose(due, entry(k), buffer[place(0, k)]));
    }
  }
  /// For evaluate(): push() after a step; fill() at a reset, where there is no past yet.
  template <class Real, class Entry>
  SKYBODY_INLINE void note(const EnvView<Real>& env, const Values<Real>& buffer,
                           const Entry& entry) const {
    note(has_stepped(env), buffer, entry);
  }
  /// The same for tasks with several histories: they call has_stepped() once.
  template <class Real, class Entry>
  SKYBODY_INLINE void note(const MaskOf<Real>& stepped, const Values<Real>& buffer,
                           const Entry& entry) const {
    for (int k = 0; k < width_; ++k) {
      const Real value = entry(k);
      for (int age = length_ - 1; age > 0; --age) {
        buffer.set(place(age, k), choose(stepped, buffer[place(age - 1, k)], value));
      }
      buffer.set(place(0, k), value);
    }
  }
  /// False at a reset.
  template <class Real>
  static SKYBODY_INLINE MaskOf<Real> has_stepped(const EnvView<Real>& env) {
    return env.step() > Word<Real>(0);
  }
  /// Value k of the entry that is `age` entries old.
  template <class Real>
  SKYBODY_INLINE Real at(const Values<Real>& buffer, int age, int k) const {
    return buffer[place(age, k)];
  }
  /// Writes all entries into an observation, the newest first.
  template <class Real>
  SKYBODY_INLINE void observe(const Values<Real>& buffer, const Part& part,
                              const Values<Real>& row) const {
    for (int k = 0; k < size(); ++k) part.set(row, buffer[first_ + k], k);
  }

 private:
  int place(int age, int k) const { return first_ + age * width_ + k; }

  int first_ = 0, length_ = 0, width_ = 0;
};

/// Times ahead at which a task shows its reference: now, and then every `spacing`.
struct Window {
  int count = 0;
  double spacing = 0.0;  ///< [s]

  /// Time i, counted from the reset [s].
  template <class Real>
  SKYBODY_INLINE Real time(const Real& now, int i) const {
    return now + spacing * static_cast<double>(i);
  }
};

}  // namespace skybody::task_kit
