// Named parts of a task's observation and infos: declared in configure() and written by name, so
// that nobody counts indices. What is declared, `skybody check SCENARIO --columns` lists, and
// scripts/task_tables.py writes into the task's README.
#pragma once

#include <skybody/plugin.h>

#include <string>

namespace skybody::task_kit {

/// What a part of an observation is.
struct PartSpec {
  std::string name;  ///< such as `velocity`; of teams with the robot's name in front
  std::string unit;  ///< SI; empty for a pure number
  int count = 1;
  std::string doc;          ///< what the values are, with their frame
  double low = -kInfinity;  ///< bounds of the values
  double high = kInfinity;
  int robot = -1;           ///< whose own it is; -1: every robot's
  bool privileged = false;  ///< for a critic alone
};

/// Where a part's values lie within its row. Default: nowhere, with no values.
class Part {
 public:
  Part() = default;
  Part(int first, int count) : first_(first), count_(count) {}

  int first() const { return first_; }  ///< index of its first value within the row
  int count() const { return count_; }

  /// Writes value k, or those from k on: a vector's three, a quaternion's w x y z, a matrix's nine
  /// row by row.
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Real& value, int k = 0) const {
    row.set(first_ + k, value);
  }
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Vec3<Real>& value, int k = 0) const {
    row.set(first_ + k, value);
  }
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Quat<Real>& value, int k = 0) const {
    row.set(first_ + k, value);
  }
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Mat3<Real>& value, int k = 0) const {
    for (int i = 0; i < 3; ++i)
      row.set(first_ + k + 3 * i, Vec3<Real>{value(i, 0), value(i, 1), value(i, 2)});
  }

 private:
  int first_ = 0, count_ = 0;
};

/// A task's observation, part after part. A member of the task.
class ObservationParts {
 public:
  /// Declares the next part.
  Part add(const Setup& setup, const PartSpec& spec) {
    if (spec.privileged) {
      setup.privileged_channel(spec.name, spec.unit, spec.count, spec.low, spec.high, spec.robot,
                               spec.doc);
    } else {
      setup.channel(spec.name, spec.unit, spec.count, spec.low, spec.high, spec.robot, spec.doc);
    }
    const Part part(size_, spec.count);
    size_ += spec.count;
    return part;
  }
  int size() const { return size_; }  ///< values so far

 private:
  int size_ = 0;
};

/// A task's infos, likewise.
class InfoParts {
 public:
  Part add(const Setup& setup, const std::string& name, const std::string& unit,
           const std::string& doc, int count = 1) {
    setup.info(name, unit, count, doc);
    const Part part(size_, count);
    size_ += count;
    return part;
  }

 private:
  int size_ = 0;
};

}  // namespace skybody::task_kit
