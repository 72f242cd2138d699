// The world that a task was configured in, as a value that can be written to a mission and read.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "core/plugin_abi/abi.h"
#include "onboard/archive.h"

namespace skybody::onboard {

/// A parameter's value of a SkybodySetup.
struct SetupValue {
  std::string name;  ///< of the parameter
  std::vector<double> numbers;
  std::vector<std::string> texts;
  std::vector<std::string> contents;  ///< of files: their bytes, one for each text; else empty
  std::int32_t env_param = -1;
  std::uint32_t is_given = 0;
  bool is_file() const { return !contents.empty(); }

  template <class Archive>
  void visit(Archive& a) {
    a(name, numbers, texts, contents, env_param, is_given);
  }
};

/// Owns the tables of a SkybodySetup of a task, except for things to draw.
class SetupCopy {
 public:
  SetupCopy() = default;
  SetupCopy(const SetupCopy& other);
  SetupCopy(SetupCopy&&) = default;
  SetupCopy& operator=(const SetupCopy&) = delete;
  SetupCopy& operator=(SetupCopy&&) = default;
  /// Copies a setup. @param values  its parameters, with their names
  SetupCopy(const SkybodySetup& setup, std::vector<SetupValue> values);

  const SkybodySetup& setup() const { return setup_; }
  std::vector<SetupValue>& values() { return values_; }
  const std::vector<SetupValue>& values() const { return values_; }
  const std::vector<SkybodyRobotInfo>& robots() const { return robots_; }
  const std::vector<SkybodyBodyInfo>& bodies() const { return bodies_; }
  const std::vector<SkybodyRotorInfo>& rotors() const { return rotors_; }
  const std::vector<SkybodySensorInfo>& sensors() const { return sensors_; }
  const std::vector<SkybodyChainInfo>& chains() const { return chains_; }
  const std::vector<SkybodyShapeInfo>& shapes() const { return shapes_; }
  const std::vector<SkybodyEnvParamInfo>& params() const { return params_; }

  /// Replaces the obstacles of kind `gate`: those that have a place keep their parameters, others
  /// get new ones at the end of params(). @param gates  position [m], quaternion w x y z, width,
  ///   height, thickness [m] of each, in the order of the race
  void set_gates(const std::vector<std::vector<double>>& gates);

  /// Sets the pointers of setup(); call it after a change, and before the first use.
  void link();

  template <class Archive>
  void visit(Archive& a) {
    a.raw(scalars_);
    a(instance_, values_);
    rows(a, robots_, [](auto& r, auto& text) { text(r.name); });
    rows(a, bodies_, [](auto& r, auto& text) { text(r.name), text(r.joint_name); });
    rows(a, links_, [](auto& r, auto& text) { text(r.name); });
    rows(a, rotors_, [](auto& r, auto& text) { text(r.name); });
    rows(a, sensors_, [](auto& r, auto& text) { text(r.name), text(r.channel); });
    rows(a, chains_, [](auto&, auto&) {});
    rows(a, shapes_, [](auto& r, auto& text) { text(r.name), text(r.mesh); });
    rows(a, params_, [](auto& r, auto& text) { text(r.path), text(r.alias); });
  }
  /// A number that differs between builds whose structures differ.
  static std::uint64_t layout();

 private:
  /// The numbers of a SkybodySetup that belong to no table.
  struct Scalars {
    double dt = 0.0;
    std::int32_t action_repeat = 1, horizon = 0;
    double gravity[3] = {};
    std::int32_t first_world_param = 0, unused = 0;
  };

  /// A table: the rows' bytes, then their texts.
  template <class Archive, class Row, class Texts>
  void rows(Archive& a, std::vector<Row>& table, const Texts& texts) {
    a.size(table, sizeof(Row));
    for (Row& row : table) {
      if constexpr (Archive::kWrites) {
        Row numbers = row;  // without addresses, which differ between two runs
        const auto none = [](const char*& pointer) { pointer = nullptr; };
        texts(numbers, none);
        a.raw(numbers);
        const auto text = [&a](const char*& pointer) {
          std::string value = pointer;
          a(value);
        };
        texts(row, text);
      } else {
        a.raw(row);
        const auto text = [&](const char*& pointer) {
          std::string value;
          a(value);
          pointer = keep(value);
        };
        texts(row, text);
      }
    }
  }
  template <class Row, class Texts>
  void copy(std::vector<Row>& to, const Row* from, int count, const Texts& texts);
  const char* keep(const std::string& text) { return texts_.emplace_back(text).c_str(); }

  Scalars scalars_;
  std::string instance_;
  std::vector<SetupValue> values_;
  std::vector<SkybodyRobotInfo> robots_;
  std::vector<SkybodyBodyInfo> bodies_;
  std::vector<SkybodyLinkInfo> links_;
  std::vector<SkybodyRotorInfo> rotors_;
  std::vector<SkybodySensorInfo> sensors_;
  std::vector<SkybodyChainInfo> chains_;
  std::vector<SkybodyShapeInfo> shapes_;
  std::vector<SkybodyEnvParamInfo> params_;
  std::deque<std::string> texts_;  ///< of the tables
  std::vector<std::vector<const char*>> value_texts_;
  std::vector<SkybodyValue> value_rows_;
  SkybodySetup setup_{};
};

}  // namespace skybody::onboard
