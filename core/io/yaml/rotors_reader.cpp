#include "core/io/yaml/rotors_reader.h"

#include <unordered_set>

#include "core/io/files/file.h"
#include "core/io/files/missing_file.h"
#include "core/io/files/text.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/pose.h"
#include "core/io/yaml/ranges.h"
#include "core/io/yaml/scenario_fields.h"
#include "core/model/model_marks.h"

namespace skybody {
namespace {

constexpr const char* kRotorsRemedy =
    "give its path from this file, `rotors: none` for a robot without rotors, or leave `rotors` "
    "out "
    "for the rotors.yaml beside the URDF";

class RotorsReader {
 public:
  RotorsReader(RobotModel& model, InputBudget& budget, Diagnostics& diagnostics)
      : model_(model), budget_(budget), diagnostics_(diagnostics) {
    if (model.marks) marks_ = *model.marks;
  }

  void read(const ConfigNode& root) {
    const MapReader file(&root, rotors_file_fields(), root.mark, diagnostics_);
    file.text("source");
    const ConfigNode* defaults = file.node("defaults");
    if (defaults != nullptr && !defaults->is_map()) {
      diagnostics_.error(defaults->mark,
                         "`defaults` is " + defaults->describe() + "; allowed: a map");
      defaults = nullptr;
    }
    const ConfigNode* rotors = file.node("rotors");
    if (rotors == nullptr) return;
    if (!rotors->is_sequence() || rotors->items.empty()) {
      const std::string what = rotors->is_sequence() ? "an empty list" : rotors->describe();
      diagnostics_.error(rotors->mark, "`rotors` is " + what +
                                           "; allowed: a list of at least one "
                                           "rotor (a robot without rotors: `rotors: none`)");
      return;
    }
    if (rotors->items.size() > kMostRotors) {
      diagnostics_.error(rotors->mark,
                         too_many_entries("rotors", rotors->items.size(), kMostRotors));
      return;
    }
    if (defaults != nullptr && !take_defaults(*defaults, rotors->items.size())) return;
    if (defaults != nullptr && !has_values(*defaults)) return;
    for (const ConfigNode& item : rotors->items) {
      if (!has_values(item)) continue;
      ConfigNode merged = item;
      if (defaults != nullptr && item.is_map()) {
        merged = *defaults;
        if (!merge_config(merged, item, diagnostics_, "rotors")) continue;
      }
      read_rotor(merged);
    }
    model_.marks = std::make_shared<const ModelMarks>(std::move(marks_));
  }

 private:
  /// Counts the defaults once per rotor, since each rotor gets a copy.
  bool take_defaults(const ConfigNode& defaults, std::size_t rotors) {
    const ConfigCost cost = cost_of(defaults);
    if (budget_.take_values(cost.values * static_cast<long>(rotors), cost.bytes * rotors)) {
      return true;
    }
    diagnostics_.error(defaults.mark, too_many_values());
    return false;
  }

  /// Whether every key has a value. A key without a value would silently remove a default.
  bool has_values(const ConfigNode& rotor) {
    bool good = true;
    for (const ConfigEntry& entry : rotor.entries) {
      if (!entry.value.is_null()) continue;
      diagnostics_.error(entry.value.mark, "`" + entry.key + "` has no value; give it one, or " +
                                               "leave the key out");
      good = false;
    }
    return good;
  }

  void read_rotor(const ConfigNode& node) {
    const MapReader reader(&node, rotor_fields(), node.mark, diagnostics_);
    Rotor rotor;
    rotor.name = reader.text("name");
    rotor.axis = reader.vec3("axis");
    rotor.direction = reader.text("direction") == "ccw" ? 1 : -1;
    rotor.min_speed = reader.real("min_speed");
    read_constants(reader, kRotorConstants, rotor.constants.data());
    check_name(rotor.name, reader.mark("name"));
    check_lag(kTauUp, rotor, reader);
    check_lag(kTauDown, rotor, reader);
    place(reader, rotor);
    model_.rotors.push_back(rotor);
    marks_.rotors.push_back(marks_of(reader));
  }

  static RotorMarks marks_of(const MapReader& reader) {
    RotorMarks marks;
    marks.min_speed = reader.mark("min_speed");
    for (const ConstantRow& row : kRotorConstants) {
      for (int k = 0; k < row.count; ++k) {
        marks.constants[static_cast<std::size_t>(row.place + k)] = reader.mark(row.key);
      }
    }
    return marks;
  }

  void check_lag(RotorParam lag, const Rotor& rotor, const MapReader& reader) {
    const double value = rotor.constants[lag];
    if (kLagRange.has(value)) return;
    const std::string key = row_at(kRotorConstants, lag).key;
    diagnostics_.error(reader.mark(key), "`" + key + "` is " + format_number(value) +
                                             "; allowed: " + kLagRange.text());
  }

  void check_name(const std::string& name, const SourceLocation& mark) {
    if (name.empty() || names_.insert(name).second) return;
    diagnostics_.error(mark, "a second rotor called `" + name + "`; names must differ");
  }

  /// Transforms position and axis from the link's frame to the body's.
  void place(const MapReader& reader, Rotor& rotor) {
    const double length = norm(rotor.axis);
    if (length < kShortestAxis) {
      const std::string least = format_number(kShortestAxis);
      diagnostics_.error(reader.mark("axis"),
                         length == 0.0
                             ? "`axis` is [0, 0, 0]; it must have a direction"
                             : "`axis` is too short; allowed: a length of at least " + least);
      return;
    }
    const std::string name = reader.text("link");
    const int index = name.empty() ? 0 : model_.find_link(name);
    if (index < 0) {
      std::vector<std::string> names;
      for (const Link& link : model_.links) names.push_back(link.name);
      diagnostics_.error(reader.mark("link"), "`link` is `" + name + "`, which " +
                                                  model_.urdf_file +
                                                  " does not have (or only "
                                                  "inside a universal or ball joint)" +
                                                  suggestion(name, names, "links"));
      return;
    }
    // Without a name: the link that defines the base's frame.
    const Link base{"", 0, Pose{}, {0.0, 0.0, 0.0}};
    const Link& link = name.empty() ? base : model_.links[static_cast<std::size_t>(index)];
    rotor.body = link.body;
    rotor.set_position(transform(link.pose, rotor.position()));
    rotor.axis = rotate(link.pose.rotation, rotor.axis / length);
  }

  RobotModel& model_;
  ModelMarks marks_;
  InputBudget& budget_;
  std::unordered_set<std::string> names_;
  Diagnostics& diagnostics_;
};

}  // namespace

bool read_rotors(const std::string& file, const SourceLocation& used_at, RobotModel& model,
                 std::string& text, Diagnostics& diagnostics, InputBudget& budget) {
  const std::string problem = used_at.file.empty() ? "" : missing_file(file, kRotorsRemedy);
  if (!problem.empty()) {
    diagnostics.error(used_at, problem);
    return false;
  }
  if (!is_file(file) && !used_at.file.empty()) {
    read_file(file, used_at, diagnostics);  // reports the reason at the file's name
    return false;
  }
  const std::optional<ConfigNode> root = load_config(file, diagnostics, budget, Quoting::kNo);
  if (!root) return false;
  const int errors_before = diagnostics.error_count();
  text = to_yaml(*root);
  RotorsReader(model, budget, diagnostics).read(*root);
  return diagnostics.error_count() == errors_before;
}

}  // namespace skybody
