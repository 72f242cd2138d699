// COLLADA (.dae): the scene's nodes place geometries, each with a transformation. Nodes may
// reference other nodes (<instance_node>), so a small file can expand to many: the placed nodes and
// points are counted.
//
// Skins and morphs use their undeformed geometry.
#include <cmath>

#include "core/io/files/text.h"
#include "core/io/urdf/mesh_dae_geometry.h"
#include "core/io/urdf/mesh_dae_transform.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

constexpr int kDeepest = 100;                    // nested nodes: place() is recursive
constexpr int kMostControllers = 10;             // of a geometry
constexpr long kMostNodes = 1'000'000;           // including repetitions by instances
constexpr std::size_t kMostPoints = 50'000'000;  // including repetitions; about 0.3 s

double unit_of(const XMLElement& root) {
  const XMLElement* const asset = root.FirstChildElement("asset");
  const XMLElement* const unit = asset == nullptr ? nullptr : asset->FirstChildElement("unit");
  const char* const text = unit == nullptr ? nullptr : unit->Attribute("meter");
  if (text == nullptr) return 1.0;
  const std::optional<double> meter = parse_number(text);
  if (meter && *meter > 0.0 && std::isfinite(*meter)) return *meter;
  refuse_element(*unit, "`meter` of <unit> is no number above 0");
}

/// The contents of a <node> or <visual_scene>.
struct DaeNode {
  DaeTransform transform;
  std::vector<const DaeGeometry*> geometries;
  std::vector<const XMLElement*> children;
  bool is_read = false;
  bool is_being_placed = false;
};

class DaeScene {
 public:
  DaeScene(const DaeDocument& document, MeshSink& sink)
      : document_(document), sink_(sink), geometries_(document, sink.wants_faces()) {}

  void read() {
    const XMLElement& use =
        dae_child(dae_child(document_.root(), "scene"), "instance_visual_scene");
    DaeTransform unit;
    unit.linear = unit.linear * unit_of(document_.root());
    place(document_.find(use, "url", {"visual_scene"}), unit, 0);
  }

 private:
  /// @param element  <node> or <visual_scene>
  void place(const XMLElement& element, const DaeTransform& above, int depth) {
    DaeNode& node = nodes_[&element];
    if (!node.is_read) read_node(element, node);
    if (node.is_being_placed) refuse_element(element, "a node that is an instance of itself");
    if (depth > kDeepest) {
      refuse_element(element, "nodes in each other, more than " + std::to_string(kDeepest) +
                                  ", which is the most that is allowed");
    }
    if (++node_count_ > kMostNodes) refuse_too_many(element, kMostNodes, "nodes");
    node.is_being_placed = true;
    const DaeTransform placed = above * node.transform;
    for (const DaeGeometry* geometry : node.geometries) add(element, *geometry, placed);
    for (const XMLElement* child : node.children) place(*child, placed, depth + 1);
    node.is_being_placed = false;
  }

  static void refuse_too_many(const XMLElement& element, std::size_t most, const char* noun) {
    refuse_element(element, "more than " + std::to_string(most) + " " + noun +
                                ", with those that instances repeat; take some out");
  }

  void add(const XMLElement& node, const DaeGeometry& geometry, const DaeTransform& placed) {
    for (const DaePart& part : geometry) {
      point_count_ += part.positions.size() + part.faces.corner_count();
      if (point_count_ > kMostPoints) refuse_too_many(node, kMostPoints, "vertices");
      for (const std::uint32_t first : part.positions) {
        const Vec3<double> v = placed * part.position(first);
        if (!is_finite(v)) refuse_element(node, "a node moves a vertex beyond all numbers");
        sink_.add_vertex(v);
      }
      part.faces.pass_to(sink_, [&](std::uint32_t k) { return placed * part.position(k); });
    }
  }

  void read_node(const XMLElement& element, DaeNode& node) {
    node.is_read = true;
    for (const XMLElement* e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string kind = e->Name();
      if (kind == "node") {
        node.children.push_back(e);
      } else if (kind == "instance_node") {
        node.children.push_back(&document_.find(*e, "url", {"node"}));
      } else if (kind == "instance_geometry") {
        node.geometries.push_back(&geometries_.read(document_.find(*e, "url", {"geometry"})));
      } else if (kind == "instance_controller") {
        node.geometries.push_back(&geometries_.read(geometry_of(*e)));
      } else {
        node.transform = node.transform * read_dae_transform(*e);
      }
    }
  }

  /// The geometry of a skin or morph, through its controllers.
  const XMLElement& geometry_of(const XMLElement& instance) const {
    const XMLElement* e = &document_.find(instance, "url", {"controller"});
    for (int k = 0; k < kMostControllers; ++k) {
      const XMLElement* const skin = e->FirstChildElement("skin");
      const XMLElement& user = skin == nullptr ? dae_child(*e, "morph") : *skin;
      e = &document_.find(user, "source", {"geometry", "controller"});
      if (std::string(e->Name()) == "geometry") return *e;
    }
    refuse_element(instance, "controllers of each other, more than " +
                                 std::to_string(kMostControllers) +
                                 ", which is the most that is allowed");
  }

  const DaeDocument& document_;
  MeshSink& sink_;
  DaeGeometries geometries_;
  std::unordered_map<const XMLElement*, DaeNode> nodes_;
  long node_count_ = 0;
  std::size_t point_count_ = 0;
};

}  // namespace

void read_dae(const std::string& bytes, MeshSink& sink) {
  const DaeDocument document(bytes);
  DaeScene(document, sink).read();
}

}  // namespace skybody
