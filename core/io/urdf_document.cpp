// Needs: a checked XML document (urdf_check.cpp), so that every element and number that is asked
// for here is there. Rotations are computed by core/base, since libm's last bits depend on the
// processor.
#include "core/io/urdf_document.h"

#include <unordered_map>

#include "core/io/text.h"
#include "core/io/urdf_meshes.h"
#include "core/io/urdf_xml.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

UrdfJointType type_called(const std::string& name) {
  if (name == "revolute") return UrdfJointType::kRevolute;
  if (name == "continuous") return UrdfJointType::kContinuous;
  if (name == "prismatic") return UrdfJointType::kPrismatic;
  return name == "floating" ? UrdfJointType::kFloating : UrdfJointType::kFixed;
}

/// The number of an attribute, or `otherwise` where either is absent.
double number_of(const XMLElement* e, const char* attribute, double otherwise) {
  const auto number = e == nullptr ? std::nullopt : xml_numbers(*e, attribute, 1);
  return number ? (*number)[0] : otherwise;
}

Vec3<double> vector_of(const XMLElement* e, const char* attribute, const Vec3<double>& otherwise) {
  const auto list = e == nullptr ? std::nullopt : xml_numbers(*e, attribute, 3);
  return list ? Vec3<double>{(*list)[0], (*list)[1], (*list)[2]} : otherwise;
}

MassProperties mass_of(const XMLElement& inertial) {
  const XMLElement* i = inertial.FirstChildElement("inertia");
  const auto moment = [&](const char* name) { return number_of(i, name, 0.0); };
  const SymMat3<double> tensor{moment("ixx"), moment("iyy"), moment("izz"),
                               moment("ixy"), moment("ixz"), moment("iyz")};
  const Pose pose = xml_origin(inertial);
  return {number_of(inertial.FirstChildElement("mass"), "value", 0.0), pose.position,
          rotate_inertia(to_mat3(pose.rotation), tensor)};
}

Vec3<double> axis_of(const XMLElement& joint) {
  const Vec3<double> axis = vector_of(joint.FirstChildElement("axis"), "xyz", {1.0, 0.0, 0.0});
  return axis / norm(axis);
}

/// The element of the shape itself, such as <box>.
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

/// What is wrong with a mesh, to follow "the mesh `x` of the link `y` ", and what helps.
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
  DocumentBuilder(UrdfXml& xml, const std::string& file, Diagnostics& diagnostics)
      : xml_(xml), meshes_(file), diagnostics_(diagnostics) {
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
    UrdfLink link;
    link.name = named.name;
    link.line = named.line;
    if (const XMLElement* inertial = named.element->FirstChildElement("inertial")) {
      link.has_inertial = true;
      link.mass = mass_of(*inertial);
    }
    primitive_collision_ = has_primitive_collision(*named.element);
    add_shapes(named, "visual", link.visuals);
    add_shapes(named, "collision", link.collisions);
    index_[link.name] = static_cast<int>(document_.links.size());
    document_.links.push_back(std::move(link));
  }

  void add_shapes(const XmlNamed& link, const char* kind, std::vector<Shape>& shapes) {
    for (const auto* e = link.element->FirstChildElement(kind); e != nullptr;
         e = e->NextSiblingElement(kind)) {
      if (auto shape = make_shape(*e, link.name)) shapes.push_back(std::move(*shape));
    }
  }

  std::optional<Shape> make_shape(const XMLElement& e, const std::string& link) {
    const XMLElement* source = shape_element(e);
    if (source == nullptr) return std::nullopt;
    Shape shape;
    shape.pose = xml_origin(e);
    if (std::string(e.Name()) == "visual") {
      if (const auto rgba = xml_.materials.of(e, "the link `" + link + "`")) shape.rgba = *rgba;
    }
    const std::string name = source->Name();
    if (name == "box") {
      shape.type = ShapeType::kBox;
      shape.size = vector_of(source, "size", shape.size);
    } else if (name == "cylinder") {
      shape.type = ShapeType::kCylinder;
      shape.radius = number_of(source, "radius", 0.0);
      shape.length = number_of(source, "length", 0.0);
    } else if (name == "sphere") {
      shape.type = ShapeType::kSphere;
      shape.radius = number_of(source, "radius", 0.0);
    } else {
      shape.type = ShapeType::kMesh;
      shape.size = vector_of(source, "scale", {1.0, 1.0, 1.0});
      shape.mesh = source->Attribute("filename");
      if (!keep_mesh(shape.mesh, e, link)) return std::nullopt;
    }
    return shape;
  }

  bool keep_mesh(const std::string& mesh, const XMLElement& e, const std::string& link) {
    const SourceMark mark = document_.mark(shape_element(e)->GetLineNum());
    const std::string what = "the mesh `" + mesh + "` of the link `" + link + "` ";
    const MeshState state = meshes_.look_up(mesh);
    const MeshProblem problem = problem_of(state);
    const bool collision = std::string(e.Name()) == "collision";
    if (state != MeshState::kFound && collision && !primitive_collision_) {
      diagnostics_.error(mark, what + problem.text +
                                   ", and the link has no other collision shape; " +
                                   problem.remedy + ", or a box, cylinder or sphere");
      return false;
    }
    if (state != MeshState::kFound) {
      diagnostics_.warning(mark, what + problem.text + "; it is left out, primitive shapes remain");
      return false;
    }
    if (collision) {
      diagnostics_.warning(mark, what + "takes no part in contact; add primitive collision shapes");
    }
    return true;
  }

  void add_joint(const XmlJoint& named) {
    const XMLElement& source = *named.element;
    UrdfJoint joint;
    joint.name = named.name;
    joint.line = named.line;
    joint.type = type_called(named.type);
    joint.parent = index_.at(named.parent);
    joint.child = index_.at(named.child);
    joint.origin = xml_origin(source);
    if (joint.turns() || joint.type == UrdfJointType::kPrismatic) joint.axis = axis_of(source);
    const XMLElement* limit = source.FirstChildElement("limit");
    joint.limited = limit != nullptr && (joint.type == UrdfJointType::kRevolute ||
                                         joint.type == UrdfJointType::kPrismatic);
    if (joint.limited) {
      joint.lower = number_of(limit, "lower", 0.0);
      joint.upper = number_of(limit, "upper", 0.0);
    }
    joint.damping = number_of(source.FirstChildElement("dynamics"), "damping", 0.0);
    const int index = static_cast<int>(document_.joints.size());
    document_.links[static_cast<std::size_t>(joint.parent)].child_joints.push_back(index);
    document_.links[static_cast<std::size_t>(joint.child)].parent_joint = index;
    document_.joints.push_back(joint);
  }

  UrdfXml& xml_;
  UrdfMeshes meshes_;
  Diagnostics& diagnostics_;
  UrdfDocument document_;
  std::unordered_map<std::string, int> index_;
  bool primitive_collision_ = false;  ///< of the link at hand
};

}  // namespace

std::optional<UrdfDocument> parse_urdf_document(const std::string& text, const std::string& file,
                                                Diagnostics& diagnostics) {
  UrdfXml xml(file, diagnostics);
  if (!check_urdf_xml(text, file, xml, diagnostics)) return std::nullopt;
  const int errors_before = diagnostics.error_count();
  UrdfDocument document = DocumentBuilder(xml, file, diagnostics).build();
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return document;
}

}  // namespace skybody
