#include "core/io/yaml/coupling_reader.h"

#include <algorithm>

#include "core/base/system/suggestion.h"
#include "core/io/files/text.h"
#include "core/io/yaml/field.h"
#include "core/io/yaml/pose.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

class CouplingReader {
 public:
  CouplingReader(const ConfigNode& node, const std::vector<RobotUse>& robots,
                 Diagnostics& diagnostics)
      : reader_(&node, coupling_fields(), node.mark, diagnostics),
        robots_(robots),
        diagnostics_(diagnostics) {}

  std::optional<Coupling> read() {
    const int errors_before = diagnostics_.error_count();
    coupling_.name = reader_.text("name");
    read_kind();
    read_constants(reader_, kCouplingConstants, coupling_.constants.data());
    coupling_.has_length = reader_.node("length") != nullptr;
    coupling_.mark = coupling_.has_length ? reader_.mark("length") : reader_.mark();
    if (is_kind_known_) check_constants();
    read_ends();
    if (diagnostics_.error_count() > errors_before) return std::nullopt;
    return coupling_;
  }

 private:
  void read_kind() {
    kind_ = reader_.text("kind");
    const ConfigNode* written = reader_.node("kind");
    if (written != nullptr && written->scalar != kind_) return;  // rejected: kind_ is the default
    const auto found = std::find(kCouplingNames.begin(), kCouplingNames.end(), kind_);
    if (found == kCouplingNames.end()) return;  // rejected
    coupling_.kind = static_cast<CouplingKind>(found - kCouplingNames.begin());
    is_kind_known_ = true;
  }

  /// Rejects constants that do not apply to the kind, and springs without stiffness and damping.
  void check_constants() {
    if (coupling_.kind == CouplingKind::kSpring && reader_.node("stiffness") == nullptr &&
        reader_.node("damping") == nullptr) {
      diagnostics_.error(reader_.mark(), "the spring `" + coupling_.name +
                                             "` has neither `stiffness` nor `damping`; give one");
    }
    for (const ConstantRow& row : kCouplingConstants) {
      if (row.place < coupling_constant_count(coupling_.kind)) continue;
      if (reader_.node(row.key) == nullptr) continue;
      diagnostics_.error(reader_.mark(row.key), "`" + std::string(row.key) +
                                                    "` does not apply to a " + kind_ +
                                                    "; remove it, or choose another `kind`");
    }
  }

  void read_ends() {
    const ConfigNode* ends = reader_.node("ends");
    if (ends == nullptr) return;
    if (!ends->is_sequence() || ends->items.size() != 2) {
      const std::string what = ends->is_sequence()
                                   ? "a list of " + std::to_string(ends->items.size())
                                   : ends->describe();
      diagnostics_.error(ends->mark, "`ends` is " + what + "; allowed: a list of two maps");
      return;
    }
    bool is_read = true;
    for (std::size_t i = 0; i < 2; ++i) is_read &= read_end(ends->items[i], coupling_.ends[i]);
    if (is_read) check_ends(ends->mark);
  }

  bool read_end(const ConfigNode& node, CouplingEnd& end) {
    const int errors_before = diagnostics_.error_count();
    const MapReader reader(&node, coupling_end_fields(), node.mark, diagnostics_);
    end.point = reader.vec3("point");
    const std::string robot = reader.text("robot"), link = reader.text("link");
    if (!robot.empty()) {
      end.robot = find_robot(robot, reader.mark("robot"));
      if (end.robot >= 0) place(robots_[static_cast<std::size_t>(end.robot)].model, reader, end);
    } else if (!link.empty()) {
      diagnostics_.error(reader.mark("link"),
                         "`link` is `" + link + "`, but no `robot` is named; add it");
    }
    return diagnostics_.error_count() == errors_before;
  }

  int find_robot(const std::string& name, const SourceLocation& mark) {
    std::vector<std::string> names;
    for (const RobotUse& robot : robots_) names.push_back(robot.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<int>(found - names.begin());
    diagnostics_.error(mark, "`" + name + "` is not a robot" + suggestion(name, names, "robots"));
    return -1;
  }

  /// Sets the body that contains the link, and the point in the body's frame.
  void place(const RobotModel& model, const MapReader& reader, CouplingEnd& end) {
    const std::string name = reader.text("link");
    if (name.empty()) return;
    const int index = model.find_link(name);
    if (index < 0) {
      std::vector<std::string> names;
      for (const Link& link : model.links) names.push_back(link.name);
      diagnostics_.error(reader.mark("link"), "`link` is `" + name + "`, which " + model.urdf_file +
                                                  " does not have" +
                                                  suggestion(name, names, "links"));
      return;
    }
    const Link& link = model.links[static_cast<std::size_t>(index)];
    end.body = link.body;
    end.point = transform(link.pose, end.point);
  }

  void check_ends(const SourceLocation& mark) {
    const CouplingEnd &a = coupling_.ends[0], &b = coupling_.ends[1];
    if (a.robot != b.robot || (a.robot >= 0 && a.body != b.body)) {
      if (stands(a) && stands(b)) {
        diagnostics_.error(mark,
                           "both `ends` are of what stands still, so that nothing can give "
                           "way; name a body that moves");
      }
      return;
    }
    diagnostics_.error(mark, a.robot < 0 ? std::string("both `ends` are of the world; name a robot")
                                         : "both `ends` are of one body, `" +
                                               robots_[static_cast<std::size_t>(a.robot)]
                                                   .model.bodies[static_cast<std::size_t>(a.body)]
                                                   .name +
                                               "`; a coupling joins two");
  }

  /// Whether the end cannot move: on the world, or on a base welded to it.
  bool stands(const CouplingEnd& end) const {
    if (end.robot < 0) return true;
    const RobotModel& model = robots_[static_cast<std::size_t>(end.robot)].model;
    return model.bodies[static_cast<std::size_t>(end.body)].joint.type == JointType::kWeld;
  }

  MapReader reader_;
  const std::vector<RobotUse>& robots_;
  Diagnostics& diagnostics_;
  std::string kind_;
  bool is_kind_known_ = false;
  Coupling coupling_;
};

}  // namespace

std::optional<Coupling> read_coupling(const ConfigNode& node, const std::vector<RobotUse>& robots,
                                      Diagnostics& diagnostics) {
  return CouplingReader(node, robots, diagnostics).read();
}

}  // namespace skybody
