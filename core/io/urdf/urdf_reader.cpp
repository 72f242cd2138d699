#include "core/io/urdf/urdf_reader.h"

#include "core/io/files/file.h"
#include "core/io/urdf/urdf_bodies.h"
#include "core/io/urdf/urdf_fixed.h"
#include "core/io/urdf/urdf_links_and_joints.h"
#include "core/io/urdf/urdf_merge.h"

namespace skybody {

std::optional<RobotModel> read_urdf(const std::string& file, const UrdfOptions& options,
                                    Diagnostics& diagnostics) {
  const std::optional<std::string> text = read_file(file, {}, diagnostics);
  if (!text) return std::nullopt;
  return parse_urdf(*text, file, options, diagnostics);
}

std::optional<RobotModel> parse_urdf(const std::string& text, const std::string& file,
                                     const UrdfOptions& options, Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  std::optional<UrdfDocument> document = parse_urdf_document(text, file, diagnostics);
  if (!document) return std::nullopt;
  fix_joints(*document, options.fixed_joints, diagnostics);
  const UrdfGroups groups = merge_fixed_joints(*document, options.repair_inertia, diagnostics);
  RobotModel model;
  model.name = document->name;
  model.urdf_file = file;
  make_bodies(*document, groups, options, model, diagnostics);
  if (model.bodies.empty() && diagnostics.error_count() == errors_before) {
    diagnostics.error({file, 0, 0}, "the robot has no link besides `world`");
  }
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  model.fixed_base = model.bodies[0].joint.type != JointType::kFree;
  derive_limit_springs(model);
  return model;
}

}  // namespace skybody
