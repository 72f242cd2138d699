// Named parts of a task's observation and infos. They are declared in configure() and written by
// name, so that authors need not count indices. `skybody check SCENARIO --columns` lists them, and
// research/documents/task_tables.py writes them into the task's README.
#pragma once

#include <skybody/plugin.h>

#include <deque>
#include <string>

namespace skybody::task_kit {

/// Description of a part of an observation.
struct PartSpec {
  std::string name;  ///< such as `velocity`; for teams with the robot's name in front
  std::string unit;  ///< SI; empty for a pure number
  int count = 1;
  std::string doc;          ///< meaning of the values, with their frame
  double low = -kInfinity;  ///< bounds of the values
  double high = kInfinity;
  int robot = -1;           ///< owner; -1: every robot
  bool privileged = false;  ///< for the critic only
};

/// Place of a part's values within its row. By default it has no values. Checked mode reports a
/// write to a part that was not declared, or beyond its end.
class Part {
 public:
  Part() = default;
  /// @param name  for checked mode: a text that lasts as long as the part
  Part(int first, int count, const char* name = "part")
      : first_(first), count_(count), name_(name) {}

  int first() const { return first_; }  ///< index of its first value within the row
  int count() const { return count_; }  ///< number of values

  /// Writes value k, or several values from k on: three of a vector, a quaternion's w x y z, a
  /// matrix's nine row by row.
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Real& value, int k = 0) const {
    if (!is_left(row)) own(row).set(k, value);
  }
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Vec3<Real>& value, int k = 0) const {
    if (!is_left(row)) own(row).set(k, value);
  }
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Quat<Real>& value, int k = 0) const {
    if (!is_left(row)) own(row).set(k, value);
  }
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const Mat3<Real>& value, int k = 0) const {
    if (is_left(row)) return;
    for (int i = 0; i < 3; ++i)
      own(row).set(k + 3 * i, Vec3<Real>{value(i, 0), value(i, 1), value(i, 2)});
  }

 private:
  friend class ObservationParts;

  /// Whether the host copies the values.
  template <class Real>
  SKYBODY_INLINE bool is_left(const Values<Real>&) const {
    return kLeavesRepeats<Real> && repeats_;
  }
  template <class Real>
  SKYBODY_INLINE Values<Real> own(const Values<Real>& row) const {
    return row.part(first_, count_, name_);
  }

  int first_ = 0, count_ = 0;
  bool repeats_ = false;  ///< whether it repeats another part
  const char* name_ = "undeclared part";
};

/// A task's observation, part by part. Make it a member of the task.
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
    const Part part(size_, spec.count, names_.emplace_back(spec.name).c_str());
    size_ += spec.count;
    return part;
  }
  /// Declares that a part always has the values of another one: packs then leave it unwritten.
  static void repeat(const Setup& setup, Part& part, const Part& of) {
    setup.repeat(part.first(), of.first(), part.count());
    part.repeats_ = true;
  }
  int size() const { return size_; }  ///< values so far

 private:
  int size_ = 0;
  std::deque<std::string> names_;  // a deque, because parts point to its elements
};

/// A task's infos. Make it a member of the task.
class InfoParts {
 public:
  /// Declares the next part. @param doc  its meaning
  Part add(const Setup& setup, const std::string& name, const std::string& unit,
           const std::string& doc, int count = 1) {
    setup.info(name, unit, count, doc);
    const Part part(size_, count, names_.emplace_back(name).c_str());
    size_ += count;
    return part;
  }

 private:
  int size_ = 0;
  std::deque<std::string> names_;
};

}  // namespace skybody::task_kit
