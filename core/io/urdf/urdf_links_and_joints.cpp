// Needs a checked XML document for lines (urdf_check.cpp) and urdfdom's model of it for the
// semantics (urdf_urdfdom.cpp). urdfdom converts rpy into quaternions with libm, whose last bits
// depend on the processor. Rotations are therefore computed again from the text.
#include "core/io/urdf/urdf_links_and_joints.h"

#include <urdf_model/link.h>
#include <urdf_model/model.h>

#include <unordered_map>

#include "core/io/files/text.h"
#include "core/io/urdf/mesh_box.h"
#include "core/io/urdf/triangle_mesh_reader.h"
#include "core/io/urdf/urdf_meshes.h"
#include "core/io/urdf/urdf_urdfdom.h"
#include "core/io/urdf/urdf_xml.h"
#include "core/io/urdf/xml_text.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

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

MassProperties mass_of(const urdf::Inertial& i, const XMLElement& inertial) {
  const SymMat3<double> tensor{i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz};
  const Pose pose = xml_origin(inertial);
  return {i.mass, pose.position, rotate_inertia(to_mat3(pose.rotation), tensor)};
}

/// The shape's own element, such as <box>.
const XMLElement* shape_element(const XMLElement& visual_or_collision) {
  const XMLElement* geometry = visual_or_collision.FirstChildElement("geometry");
  return geometry == nullptr ? nullptr : geometry->FirstChildElement();
}

bool has_primitive_collision(const XMLElement& link) {
  for (const auto* e = link.FirstChildElement("collision"); e != nullptr;
       e = e->NextSiblingElement("collision")) {
    const XMLElement* shape = shape_element(*e);
    if (shape != nullptr && std::string(shape->Name()) != "mesh") return true;
  }
  return false;
}

/// The problem with a mesh, to follow "the mesh `x` of the link `y` ", and its remedy.
struct MeshProblem {
  const char* text;
  const char* remedy;
};
MeshProblem problem_of(MeshState state) {
  if (state == MeshState::kOutside) {
    return {"lies outside the model's folder and the one above it", "put it there"};
  }
  if (state == MeshState::kNoMesh) {
    return {"has no extension of a mesh, such as .stl or .dae", "name a mesh"};
  }
  return {"does not exist", "add the file"};
}

class DocumentBuilder {
 public:
  DocumentBuilder(const UrdfXml& xml, const urdf::ModelInterface& model, const std::string& file,
                  Diagnostics& diagnostics)
      : xml_(xml), model_(model), meshes_(file), diagnostics_(diagnostics) {
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
  SourceLocation mark_of(const XMLElement& e) const { return xml_mark(document_.file, e); }

  void add_link(const XmlNamed& named) {
    const urdf::Link& source = *model_.getLink(named.name);
    UrdfLink link;
    link.name = named.name;
    link.mark = link.mass_mark = link.inertia_mark = named.mark;
    if (source.inertial) {
      const XMLElement& inertial = *named.element->FirstChildElement("inertial");
      link.has_inertial = true;
      link.mass = mass_of(*source.inertial, inertial);
      link.mass_mark = mark_of(*inertial.FirstChildElement("mass"));
      link.inertia_mark = mark_of(*inertial.FirstChildElement("inertia"));
    }
    primitive_collision_ = has_primitive_collision(*named.element);
    std::vector<SourceLocation> ignored;
    add_shapes(named, "visual", source.visual_array, link.visuals, ignored);
    add_shapes(named, "collision", source.collision_array, link.collisions, link.collision_marks);
    index_[link.name] = static_cast<int>(document_.links.size());
    document_.links.push_back(std::move(link));
  }

  /// @param sources  urdfdom's visuals or collisions, one for each element
  template <class Sources>
  void add_shapes(const XmlNamed& link, const char* kind, const Sources& sources,
                  std::vector<Shape>& shapes, std::vector<SourceLocation>& marks) {
    const XMLElement* e = link.element->FirstChildElement(kind);
    for (const auto& source : sources) {
      std::optional<Shape> shape = make_shape(*source->geometry, *e, link.name);
      if (shape) paint(*source, *e, link.name, *shape);
      if (shape) {
        shapes.push_back(std::move(*shape));
        marks.push_back(mark_of(*shape_element(*e)));
      }
      e = e->NextSiblingElement(kind);
    }
  }

  void paint(const urdf::Collision&, const XMLElement&, const std::string&, Shape&) {}
  /// @param link  for messages
  void paint(const urdf::Visual& visual, const XMLElement& e, const std::string& link,
             Shape& shape) {
    if (!visual.material) return;
    const std::string& texture = visual.material->texture_filename;
    const urdf::Color& c = visual.material->color;
    // urdfdom's colour of a material without one is black.
    const bool has_color = texture.empty() || c.r != 0.0f || c.g != 0.0f || c.b != 0.0f;
    if (has_color) shape.rgba = {c.r, c.g, c.b, c.a};
    if (!texture.empty()) add_texture(texture, mark_of(e), link, shape);
  }

  void add_texture(const std::string& name, const SourceLocation& mark, const std::string& link,
                   Shape& shape) {
    const MeshFile file = meshes_.look_up_texture(name);
    if (file.state == MeshState::kFound) {
      shape.texture_file = file.path;
    } else {
      diagnostics_.warning(mark, "the texture `" + name + "` of the link `" + link + "` " +
                                     problem_of(file.state).text + "; its colour remains");
    }
  }

  std::optional<Shape> make_shape(const urdf::Geometry& geometry, const XMLElement& e,
                                  const std::string& link) {
    Shape shape;
    shape.pose = xml_origin(e);
    if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      shape.type = ShapeType::kBox;
      shape.size = {box->dim.x, box->dim.y, box->dim.z};
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      const bool is_capsule = std::string(shape_element(e)->Name()) == "capsule";
      shape.type = is_capsule ? ShapeType::kCapsule : ShapeType::kCylinder;
      shape.radius = cylinder->radius;
      shape.length = cylinder->length;
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      shape.type = ShapeType::kSphere;
      shape.radius = sphere->radius;
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
      shape.type = ShapeType::kMesh;
      shape.size = {mesh->scale.x, mesh->scale.y, mesh->scale.z};
      shape.mesh = mesh->filename;
      if (!keep_mesh(shape, e, link)) return std::nullopt;
    }
    return shape;
  }

  bool keep_mesh(Shape& shape, const XMLElement& e, const std::string& link) {
    const SourceLocation mark = mark_of(*shape_element(e));
    const std::string subject = "the mesh `" + shape.mesh + "` of the link `" + link + "` ";
    const MeshFile& file = meshes_.look_up(shape.mesh);
    const MeshState state = file.state;
    const MeshProblem problem = problem_of(state);
    const bool collision = std::string(e.Name()) == "collision";
    if (state != MeshState::kFound && collision && !primitive_collision_) {
      diagnostics_.error(mark, subject + problem.text +
                                   ", and the link has no other collision shape; " +
                                   problem.remedy + ", or a box, cylinder, sphere or capsule");
      return false;
    }
    if (state != MeshState::kFound) {
      diagnostics_.warning(mark,
                           subject + problem.text + "; it is left out, primitive shapes remain");
      return false;
    }
    shape.mesh_file = file.path;
    if (const MeshFormat* const format = find_mesh_format(shape.mesh)) {
      shape.read_triangles = [path = file.path, format](TriangleMesh& mesh) {
        return read_triangle_mesh(path, *format, mesh);
      };
    }
    return !collision || take_box(file.path, subject, mark, shape);
  }

  /// Reads the bounding box that represents a mesh in contact.
  /// @param subject  subject of messages: "the mesh `x` of the link `y` "
  bool take_box(const std::string& file, const std::string& subject, const SourceLocation& mark,
                Shape& shape) {
    const std::string remedy = ", and contact needs the box about it; ";
    const MeshFormat* const format = find_mesh_format(shape.mesh);
    if (format == nullptr) {
      diagnostics_.error(mark, subject + "is of a format that is not read (" + mesh_extensions() +
                                   " are)" + remedy +
                                   "convert it (Blender, MeshLab and Python's trimesh do), or "
                                   "write a box, cylinder, sphere or capsule");
      return false;
    }
    const ReadMesh& read = read_mesh(file, *format);
    MeshBox box = read.box;
    const std::string problem =
        read.problem.empty() ? scale_mesh_box(shape.size, box) : read.problem;
    if (!problem.empty()) {
      diagnostics_.error(mark, subject + problem + remedy +
                                   "mend it, or write a box, cylinder, sphere or capsule");
      return false;
    }
    shape.box_size = box.size();
    shape.box_center = box.center();
    diagnostics_.warning(mark, subject + "counts in contact as the box about it, " +
                                   format_number(shape.box_size.x) + " x " +
                                   format_number(shape.box_size.y) + " x " +
                                   format_number(shape.box_size.z) +
                                   " m; boxes, cylinders, spheres and capsules in its place would "
                                   "follow its form");
    return true;
  }

  /// The file of a collision mesh; each file is read once.
  struct ReadMesh {
    MeshBox box;
    std::string problem;
  };
  const ReadMesh& read_mesh(const std::string& file, const MeshFormat& format) {
    const auto [found, is_new] = read_meshes_.try_emplace(file + format.extension);
    ReadMesh& mesh = found->second;
    if (!is_new) return mesh;
    mesh.problem = read_meshes_.size() > kMostMeshes
                       ? "is not read: the model has more than " + std::to_string(kMostMeshes) +
                             " meshes that are collision shapes"
                       : read_mesh_box(file, format, mesh.box);
    return mesh;
  }

  void add_joint(const XmlJoint& named) {
    const urdf::Joint& source = *model_.getJoint(named.name);
    UrdfJoint joint;
    joint.name = named.name;
    joint.mark = named.mark;
    joint.type = type_of(source);
    joint.parent = index_.at(named.parent);
    joint.child = index_.at(named.child);
    joint.origin = xml_origin(*named.element);
    const Vec3<double> axis{source.axis.x, source.axis.y, source.axis.z};
    const double length = norm(axis);
    if (length > 0.0) joint.axis = axis / length;
    joint.limited = source.limits && (joint.type == UrdfJointType::kRevolute ||
                                      joint.type == UrdfJointType::kPrismatic);
    if (joint.limited) {
      joint.lower = source.limits->lower;
      joint.upper = source.limits->upper;
    }
    if (source.dynamics) {
      joint.damping = source.dynamics->damping;
      joint.damping_mark = mark_of(*named.element->FirstChildElement("dynamics"));
    }
    const int index = static_cast<int>(document_.joints.size());
    document_.links[static_cast<std::size_t>(joint.parent)].child_joints.push_back(index);
    document_.links[static_cast<std::size_t>(joint.child)].parent_joint = index;
    document_.joints.push_back(joint);
  }

  const UrdfXml& xml_;
  const urdf::ModelInterface& model_;
  UrdfMeshes meshes_;
  Diagnostics& diagnostics_;
  UrdfDocument document_;
  std::unordered_map<std::string, int> index_;
  std::unordered_map<std::string, ReadMesh> read_meshes_;  ///< by file and format
  bool primitive_collision_ = false;                       ///< of the current link
};

}  // namespace

std::optional<UrdfDocument> parse_urdf_document(const std::string& text, const std::string& file,
                                                Diagnostics& diagnostics) {
  UrdfXml xml;
  if (!check_urdf_xml(text, file, xml, diagnostics)) return std::nullopt;
  const urdf::ModelInterfaceSharedPtr model = read_by_urdfdom(xml, file, diagnostics);
  if (!model) return std::nullopt;
  const int errors_before = diagnostics.error_count();
  UrdfDocument document = DocumentBuilder(xml, *model, file, diagnostics).build();
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return document;
}

}  // namespace skybody
