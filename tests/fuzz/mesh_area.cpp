// Collision meshes. Each input is read as every supported format, since a mutated header of one
// format is unlikely to fit the body of another.
#include "core/io/urdf/urdf_reader.h"
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;

const char* const kFormats[] = {"stl", "obj", "ply", "dae"};

const char* const kStl = R"(solid wedge
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0.2 1e-1
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 3
endloop
endfacet
endsolid wedge
)";

const char* const kObj = R"(# every kind of line
mtllib a.mtl
o a
v 0 0 0
v 1 0 0 1
v 0 1 1 0.5 0.5 0.5
v 0 1 \
2
vt 0 0
vn 0 0 1
vp 1 2
g b
usemtl m
s 1
f 1/1/1 2/1 3//1 4
f -1 -2 -3 -4
l 1 2
p 1
)";

const char* const kPlyHeader = R"(element vertex 4
property float x
property float y
property float z
property uchar red
element face 2
property list uchar int vertex_indices
end_header
)";

const char* const kPlyRows = R"(0 0 0 255
1 0 0 0
0 2 0 7
0 0 3 9
3 0 1 2
4 0 1 2 3
)";

/// Every primitive, transformation and kind of instance.
const char* const kDae = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 100 0 0 0 200 0 0 0 300</float_array>
<technique_common><accessor source="#pa" offset="0" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="1"/><p>0 0 1 0 2 0 0 0 1 0 3 0</p></triangles>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount>
<p>0 1 2 3</p></polylist>
<polygons><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p><ph><p>0 1 3</p></ph></polygons>
<lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 3</p></lines>
</mesh></geometry></library_geometries>
<library_controllers><controller id="c"><skin source="#g"/></controller>
<controller id="m"><morph source="#c"/></controller></library_controllers>
<library_nodes><node id="b0"><instance_geometry url="#g"/></node>
<node id="b1"><instance_node url="#b0"/><instance_node url="#b0"/></node>
<node id="b2"><instance_node url="#b1"/><instance_node url="#b1"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="n">
<matrix>1 0 0 0.5 0 1 0 0 0 0 1 0 0 0 0 1</matrix><translate>1 2 3</translate>
<rotate>0 0 1 90</rotate><scale>1 2 1</scale><lookat>0 0 1 0 0 0 0 1 0</lookat>
<instance_geometry url="#g"/><instance_controller url="#m"/><node><instance_node url="#b2"/></node>
</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes += "\2\0\0\0"s;
  for (int triangle = 0; triangle < 2; ++triangle) {
    bytes.append(12, '\0');
    for (int k = 0; k < 9; ++k) bytes += k % 4 == 0 ? "\0\0\x80\x3f"s : "\0\0\0\0"s;
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string binary_ply(bool big) {
  const std::string order = big ? "big" : "little";
  const std::string one = big ? "\x3f\x80\0\0"s : "\0\0\x80\x3f"s;
  std::string bytes = "ply\nformat binary_" + order + "_endian 1.0\n" + kPlyHeader;
  for (int vertex = 0; vertex < 4; ++vertex) {
    for (int axis = 1; axis <= 3; ++axis) bytes += vertex == axis ? one : std::string(4, '\0');
    bytes += '\7';
  }
  for (int face = 0; face < 2; ++face) {
    bytes += '\3';
    for (int corner = 0; corner < 3; ++corner) {
      const std::string index(1, static_cast<char>(corner + face));
      bytes += big ? "\0\0\0"s + index : index + "\0\0\0"s;
    }
  }
  return bytes;
}

const char* const kWords[] = {"solid",
                              "facet",
                              "vertex",
                              "endsolid",
                              "v",
                              "f",
                              "l",
                              "-1",
                              "1//1",
                              "\\",
                              "ply",
                              "element",
                              "property",
                              "list",
                              "end_header",
                              "uchar",
                              "double",
                              "ascii",
                              "count",
                              "stride",
                              "offset",
                              "url",
                              "source",
                              "#g",
                              "#v",
                              "#n",
                              "#b2",
                              "#c",
                              "nan",
                              "inf",
                              "1e999",
                              "\xff",
                              "-5",
                              "4294967295",
                              "18446744073709551615",
                              "<skew>30 1 0 0 0 1 0</skew>",
                              "<instance_node url=\"#n\"/>",
                              "<p>0 1 2</p>",
                              "<node>",
                              "</node>",
                              "<mesh/>",
                              "binary_big_endian",
                              "lines",
                              "tristrips"};

class MeshArea : public Area {
 public:
  MeshArea() {
    material_.seeds = {kStl,
                       binary_stl(),
                       kObj,
                       "ply\nformat ascii 1.0\n"s + kPlyHeader + kPlyRows,
                       binary_ply(false),
                       binary_ply(true),
                       kDae,
                       kDae};
    material_.words.assign(std::begin(kWords), std::end(kWords));
  }

  void begin(const fs::path& folder) override {
    folder_ = folder;
    for (const std::string format : kFormats) {
      write_bytes(
          folder / (format + ".urdf"),
          "<robot name=\"r\"><link name=\"base\"><inertial><mass value=\"1\"/>"
          "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>"
          "<collision><geometry><mesh filename=\"input." +
              format + "\"/></geometry></collision></link></robot>\n");
    }
  }

  Answer run(const std::string& input, bool thorough) override {
    Answer answer = Answer::kRefused;
    for (const std::string format : kFormats) {
      write_bytes(folder_ / ("input." + format), input);
      const Outcome outcome = read(format);
      if (thorough && read(format) != outcome) wrong_answer("reads differently the second time");
      if (outcome.is_read) answer = Answer::kAccepted;
    }
    return answer;
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  /// The result of reading a mesh; a warning contains its size.
  struct Outcome {
    bool is_read = false;
    std::string messages;
    bool operator==(const Outcome&) const = default;
  };

  Outcome read(const std::string& format) const {
    Diagnostics diagnostics;
    const auto model = read_urdf((folder_ / (format + ".urdf")).string(), {}, diagnostics);
    if (!model) return {false, check_refusal(diagnostics)};
    if (diagnostics.has_errors()) wrong_answer("accepted with errors");
    check_box(model->bodies.at(0).collisions.at(0));
    return {true, diagnostics.to_string()};
  }

  static void check_box(const Shape& shape) {
    for (const double x : {shape.box_size.x, shape.box_size.y, shape.box_size.z}) {
      if (!(x > 0.0 && x <= 2e6)) wrong_answer("a box of no size");
    }
    for (const double x : {shape.box_center.x, shape.box_center.y, shape.box_center.z}) {
      if (!(x >= -1e6 && x <= 1e6)) wrong_answer("a box that is far off");
    }
  }

  fs::path folder_;
};

}  // namespace

std::unique_ptr<Area> make_mesh_area(const AreaOptions&) { return std::make_unique<MeshArea>(); }

}  // namespace skybody::fuzz
