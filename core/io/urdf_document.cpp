// Needs: urdfdom for what URDF means, tinyxml2 for lines. urdfdom turns rpy into quaternions by
// libm, whose last bits depend on the processor, so rotations are computed again from the text.
#include "core/io/urdf_document.h"

#include <console_bridge/console.h>
#include <urdf_model/link.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <filesystem>
#include <map>
#include <mutex>

#include "core/io/file.h"
#include "core/io/text.h"
#include "core/io/urdf_xml.h"

namespace skybody {
namespace {

/// Keeps what urdfdom writes to its console.
class Chatter : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) errors.push_back(text);
  }
  std::vector<std::string> errors;
};

/// urdfdom's view of the text. Its console is one for the whole process, hence the lock.
urdf::ModelInterfaceSharedPtr parse_by_urdfdom(const std::string& text, Chatter& chatter) {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  console_bridge::OutputHandler* before = console_bridge::getOutputHandler();
  console_bridge::useOutputHandler(&chatter);
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    chatter.errors.push_back(error.what());
  }
  console_bridge::useOutputHandler(before);
  return model;
}

UrdfJointType type_of(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
      return UrdfJointType::kRevolute;
    case urdf::Joint::CONTINUOUS:
      return UrdfJointType::kContinuous;
    case urdf::Joint::PRISMATIC:
      return UrdfJointType::kPrismatic;
    case urdf::Joint::FLOATING:
      return UrdfJointType::kFloating;
    default:
      return UrdfJointType::kFixed;
  }
}

/// The file that a mesh's name stands for, or empty. package://NAME/REST is looked for in the
/// folders above the URDF, with and without NAME.
std::string find_mesh(const std::string& name, const std::string& urdf_file) {
  namespace fs = std::filesystem;
  const std::string package = "package://", file = "file://";
  std::string rest = name;
  if (rest.rfind(file, 0) == 0) rest = rest.substr(file.size());
  if (rest.rfind(package, 0) != 0) {
    const std::string path = resolve_path(rest, {urdf_file, 0, 0});
    return is_file(path) ? path : "";
  }
  rest = rest.substr(package.size());
  const std::string inner = rest.substr(std::min(rest.find('/'), rest.size() - 1) + 1);
  std::error_code code;
  for (fs::path folder = fs::absolute(urdf_file, code).parent_path(); !folder.empty();
       folder = folder.parent_path()) {
    for (const std::string& tail : {rest, inner}) {
      if (is_file((folder / tail).string())) return (folder / tail).string();
    }
    if (folder == folder.root_path()) break;
  }
  return "";
}

class DocumentBuilder {
 public:
  DocumentBuilder(const UrdfXml& xml, const urdf::ModelInterface& model, const std::string& file,
                  Diagnostics& diagnostics)
      : xml_(xml), model_(model), diagnostics_(diagnostics) {
    document_.name = xml.name;
    document_.file = file;
  }

  UrdfDocument build() {
    for (const XmlNamed& named : xml_.links) add_link(named);
    for (const XmlJoint& named : xml_.joints) add_joint(named);
    document_.root = index_.at(xml_.root);
    return std::move(document_);
  }

 private:
  void add_link(const XmlNamed& named) {
    const urdf::Link& source = *model_.getLink(named.name);
    UrdfLink link;
    link.name = named.name;
    link.line = named.line;
    if (source.inertial) {
      const tinyxml2::XMLElement& inertial = *named.element->FirstChildElement("inertial");
      const Pose pose = xml_origin(inertial);
      const urdf::Inertial& i = *source.inertial;
      const SymMat3<double> tensor{i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz};
      link.has_inertial = true;
      link.mass = {i.mass, pose.position, rotate_inertia(to_mat3(pose.rotation), tensor)};
    }
    const tinyxml2::XMLElement* e = named.element->FirstChildElement("visual");
    for (const auto& visual : source.visual_array) {
      std::optional<Shape> shape = make_shape(*visual->geometry, *e, named.name);
      if (shape && visual->material) {
        const urdf::Color& c = visual->material->color;
        shape->rgba = {c.r, c.g, c.b, c.a};
      }
      if (shape) link.visuals.push_back(*shape);
      e = e->NextSiblingElement("visual");
    }
    e = named.element->FirstChildElement("collision");
    for (const auto& collision : source.collision_array) {
      if (auto shape = make_shape(*collision->geometry, *e, named.name)) {
        link.collisions.push_back(*shape);
      }
      e = e->NextSiblingElement("collision");
    }
    index_[link.name] = static_cast<int>(document_.links.size());
    document_.links.push_back(std::move(link));
  }

  std::optional<Shape> make_shape(const urdf::Geometry& geometry, const tinyxml2::XMLElement& e,
                                  const std::string& link) {
    Shape shape;
    shape.pose = xml_origin(e);
    if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      shape.type = ShapeType::kBox;
      shape.size = {box->dim.x, box->dim.y, box->dim.z};
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      shape.type = ShapeType::kCylinder;
      shape.radius = cylinder->radius;
      shape.length = cylinder->length;
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      shape.type = ShapeType::kSphere;
      shape.radius = sphere->radius;
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
      shape.type = ShapeType::kMesh;
      shape.size = {mesh->scale.x, mesh->scale.y, mesh->scale.z};
      shape.mesh = mesh->filename;
      if (!keep_mesh(shape.mesh, e, link)) return std::nullopt;
    }
    return shape;
  }

  static bool has_primitive_collision(const tinyxml2::XMLElement& link) {
    for (const auto* e = link.FirstChildElement("collision"); e;
         e = e->NextSiblingElement("collision")) {
      const tinyxml2::XMLElement* geometry = e->FirstChildElement("geometry");
      if (std::string(geometry->FirstChildElement()->Name()) != "mesh") return true;
    }
    return false;
  }

  bool keep_mesh(const std::string& mesh, const tinyxml2::XMLElement& e, const std::string& link) {
    const tinyxml2::XMLElement* element = e.FirstChildElement("geometry")->FirstChildElement();
    const SourceMark mark = document_.mark(element->GetLineNum());
    const bool collision = std::string(e.Name()) == "collision";
    const bool missing = find_mesh(mesh, document_.file).empty();
    if (missing && collision && !has_primitive_collision(*e.Parent()->ToElement())) {
      diagnostics_.error(mark, "the mesh `" + mesh + "` of the link `" + link +
                                   "` does not exist, and the link has no other collision shape; "
                                   "add the file, or a box, cylinder or sphere");
      return false;
    }
    if (missing) {
      diagnostics_.warning(mark, "the mesh `" + mesh + "` of the link `" + link +
                                     "` does not exist; it is left out, primitive shapes remain");
      return false;
    }
    if (collision) {
      diagnostics_.warning(mark, "the mesh `" + mesh + "` of the link `" + link +
                                     "` takes no part in contact; add primitive collision shapes");
    }
    return true;
  }

  void add_joint(const XmlJoint& named) {
    const urdf::Joint& source = *model_.getJoint(named.name);
    UrdfJoint joint;
    joint.name = named.name;
    joint.line = named.line;
    joint.type = type_of(source);
    joint.parent = index_.at(named.parent);
    joint.child = index_.at(named.child);
    joint.origin = xml_origin(*named.element);
    const Vec3<double> axis{source.axis.x, source.axis.y, source.axis.z};
    const double length = norm(axis);
    if (length > 0.0) joint.axis = axis / length;
    const bool limits_count =
        joint.type == UrdfJointType::kRevolute || joint.type == UrdfJointType::kPrismatic;
    if (source.limits && limits_count) {
      joint.limited = true;
      joint.lower = source.limits->lower;
      joint.upper = source.limits->upper;
    }
    if (source.dynamics) joint.damping = source.dynamics->damping;
    const int index = static_cast<int>(document_.joints.size());
    document_.links[static_cast<std::size_t>(joint.parent)].child_joints.push_back(index);
    document_.links[static_cast<std::size_t>(joint.child)].parent_joint = index;
    document_.joints.push_back(joint);
  }

  const UrdfXml& xml_;
  const urdf::ModelInterface& model_;
  Diagnostics& diagnostics_;
  UrdfDocument document_;
  std::map<std::string, int> index_;
};

}  // namespace

std::optional<UrdfDocument> parse_urdf_document(const std::string& text, const std::string& file,
                                                Diagnostics& diagnostics) {
  UrdfXml xml;
  if (!check_urdf_xml(text, file, xml, diagnostics)) return std::nullopt;
  Chatter chatter;
  const urdf::ModelInterfaceSharedPtr model = parse_by_urdfdom(text, chatter);
  if (!model) {
    const std::string reasons =
        chatter.errors.empty() ? "no reason given" : join(chatter.errors, " ");
    diagnostics.error({file, 0, 0}, "urdfdom refuses the file: " + reasons);
    return std::nullopt;
  }
  const int errors_before = diagnostics.error_count();
  UrdfDocument document = DocumentBuilder(xml, *model, file, diagnostics).build();
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return document;
}

}  // namespace skybody
