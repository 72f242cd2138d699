// Bounding boxes of COLLADA meshes: primitives, accessors, transformations and instances of nodes,
// and damaged documents with the reason of their refusal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files/text.h"
#include "core/io/urdf/mesh_format.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

/// The box in whole micrometres: rotated corners are off by the last bits of a sine.
std::string read(const std::string& text) {
  try {
    VertexBox box;
    read_dae(text, box);
    std::vector<double> values;
    for (const Vec3<double>& v : {box.low(), box.high()}) {
      for (const double x : {v.x, v.y, v.z}) values.push_back(round_half_even(x * 1e6) / 1e6);
    }
    return box.is_empty() ? "empty" : format_numbers(values);
  } catch (const MeshError& error) {
    return error.what();
  }
}

/// A document with one geometry `g` of four corners of the box from 0 to (1, 2, 3), and one
/// outside.
struct Dae {
  std::string unit = "<unit meter=\"1\"/>";
  std::string floats =
      "<float_array id=\"pa\" count=\"15\">0 0 0 1 0 0 0 2 0 0 0 3 9 9 9"
      "</float_array>";
  std::string accessor = "<accessor source=\"#pa\" count=\"5\" stride=\"3\">";
  std::string params = "<param name=\"X\"/><param name=\"Y\"/><param name=\"Z\"/>";
  std::string primitives =
      "<triangles count=\"2\"><input semantic=\"VERTEX\" source=\"#v\" "
      "offset=\"0\"/><p>0 1 2 0 1 3</p></triangles>";
  std::string more = "";  ///< libraries
  std::string nodes = "<node id=\"n\"><instance_geometry url=\"#g\"/></node>";

  std::string text() const {
    return "<?xml version=\"1.0\"?>\n<COLLADA><asset>" + unit +
           "<up_axis>X_UP</up_axis></asset>\n<library_geometries><geometry id=\"g\"><mesh>\n"
           "<source id=\"p\">" +
           floats + "<technique_common>\n" + accessor + params +
           "</accessor></technique_common></source>\n"
           "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\n" +
           primitives + "</mesh></geometry></library_geometries>\n" + more +
           "<library_visual_scenes><visual_scene id=\"s\">\n" + nodes +
           "</visual_scene></library_visual_scenes>"
           "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
  }
};

const char* const kBox = "[0, 0, 0, 1, 2, 3]";

std::string with_nodes(const std::string& nodes, const std::string& more = "") {
  Dae dae;
  dae.nodes = nodes;
  dae.more = more;
  return read(dae.text());
}

std::string with_primitives(const std::string& primitives) {
  Dae dae;
  dae.primitives = primitives;
  return read(dae.text());
}

/// A node with `elements`, then an instance of the geometry.
std::string placed(const std::string& elements) {
  return with_nodes("<node>" + elements + "<instance_geometry url=\"#g\"/></node>");
}

TEST(DaeMeshes, PositionsThatPrimitivesUseCountInTheFilesUnit) {
  EXPECT_EQ(read(Dae().text()), kBox);
  Dae dae;
  dae.unit = "<unit meter=\"0.01\"/>";
  EXPECT_EQ(read(dae.text()), "[0, 0, 0, 0.01, 0.02, 0.03]");
  dae.unit = "";
  EXPECT_EQ(read(dae.text()), kBox);
  dae.accessor = "<accessor source=\"#pa\" offset=\"3\" count=\"3\" stride=\"3\">";
  dae.params = "<param/><param name=\"Y\"/><param name=\"X\"/><param name=\"Z\"/>";
  EXPECT_THAT(read(dae.text()), HasSubstr("`stride` of <accessor> is 3; needed: at least its 4"));
}

TEST(DaeMeshes, AllPrimitivesCount) {
  const std::string input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  for (const char* kind : {"lines", "linestrips", "trifans", "tristrips", "polygons"}) {
    EXPECT_EQ(
        with_primitives("<" + std::string(kind) + ">" + input + "<p>0 1 2 3</p></" + kind + ">"),
        kBox);
  }
  EXPECT_EQ(with_primitives("<polylist count=\"2\">" + input +
                            "<vcount>3 1</vcount>"
                            "<p>0 1 2 3</p></polylist>"),
            kBox);
  EXPECT_EQ(with_primitives("<polygons>" + input +
                            "<p>0 1 2</p><ph><p>2 1 3</p><h>4 4 4</h></ph>"
                            "</polygons>"),
            kBox);
  EXPECT_EQ(with_primitives("<lines><input semantic=\"NORMAL\" source=\"#none\" offset=\"0\"/>"
                            "<input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/>"
                            "<p>77 0 77 1 <!-- and --> 77 2 77 3</p></lines>"),
            kBox);
  EXPECT_EQ(with_primitives("<triangles count=\"0\"/>"), "empty");
}

TEST(DaeMeshes, NodesPlaceGeometries) {
  EXPECT_EQ(placed("<translate>1 -2 0.5</translate>"), "[1, -2, 0.5, 2, 0, 3.5]");
  EXPECT_EQ(placed("<scale>2 -1 1</scale>"), "[0, -2, 0, 2, 0, 3]");
  EXPECT_EQ(placed("<rotate>0 0 5 90</rotate>"), "[-2, 0, 0, 0, 1, 3]");
  EXPECT_EQ(placed("<rotate>0 0 0 0</rotate>"), kBox);
  EXPECT_EQ(placed("<translate>1 0 0</translate><rotate>0 0 1 90</rotate><scale>1 1 2</scale>"),
            "[-1, 0, 0, 1, 1, 6]");
  EXPECT_EQ(placed("<matrix>0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1</matrix>"), "[3, 6, 7, 5, 7, 10]");
  // From (0, 0, 5) down: x right, y up, unchanged.
  EXPECT_EQ(placed("<lookat>0 0 5 0 0 0 0 1 0</lookat>"), "[0, 0, 5, 1, 2, 8]");
  // From the origin along x, z up: the node's x is -y, its y is z and its z is -x.
  EXPECT_EQ(placed("<lookat>0 0 0 1 0 0 0.5 0 1</lookat>"), "[-3, -1, 0, 0, 0, 2]");
  EXPECT_EQ(with_nodes("<node><translate>1 0 0</translate><node><scale>2 2 2</scale>"
                       "<instance_geometry url=\"#g\"/></node></node>"),
            "[1, 0, 0, 3, 4, 6]");
}

TEST(DaeMeshes, NodesStandForOthers) {
  const std::string library =
      "<library_nodes><node id=\"lib\"><translate>0 0 1</translate>"
      "<instance_geometry url=\"#g\"/></node></library_nodes>";
  EXPECT_EQ(with_nodes("<node><instance_node url=\"#lib\"/></node><node><scale>1 1 2</scale>"
                       "<instance_node url=\"#lib\"/></node>",
                       library),
            "[0, 0, 1, 1, 2, 8]");
  const std::string skin =
      "<library_controllers><controller id=\"c\"><skin source=\"#m\"/>"
      "</controller><controller id=\"m\"><morph source=\"#g\"/></controller>"
      "</library_controllers>";
  EXPECT_EQ(with_nodes("<node><instance_controller url=\"#c\"/></node>", skin), kBox);
}

TEST(DaeMeshes, DamagedDocumentsAreRefused) {
  EXPECT_EQ(
      read("no COLLADA\n"),
      "line 1: the text `no COLLADA` stands before the element at the top, where XML allows none; "
      "remove it");
  EXPECT_EQ(read("<robot/>"), "its first element is not <COLLADA>");
  EXPECT_EQ(read("<COLLADA/>"), "line 1: <COLLADA> has no <scene>");
  Dae dae;
  dae.unit = "<unit meter=\"0,01\"/>";
  EXPECT_EQ(read(dae.text()), "line 2: `meter` of <unit> is no number above 0");
}

TEST(DaeMeshes, CountsThatTheDataDoNotHaveAreRefused) {
  Dae dae;
  dae.accessor = "<accessor source=\"#pa\" count=\"6\" stride=\"3\">";
  EXPECT_EQ(read(dae.text()),
            "line 5: <accessor> says 6 positions, which take 18 values, and its <float_array> has "
            "15");
  dae.accessor =
      "<accessor source=\"#pa\" offset=\"4294967295\" count=\"4294967295\" "
      "stride=\"4294967295\">";
  EXPECT_THAT(read(dae.text()), HasSubstr("line 5: <accessor> says 4294967295 positions"));
  dae.accessor = "<accessor source=\"#pa\" count=\"1\" stride=\"3\">";
  EXPECT_EQ(
      read(dae.text()),
      "line 7: <p> names a position that its <accessor> does not have: it has 1, numbered from 0");
  for (const char* count : {"-5", "-0", "16", "4294967296", "x", ""}) {
    Dae damaged;
    damaged.floats = "<float_array id=\"pa\" count=\"" + std::string(count) +
                     "\">0 0 0 1 0 0 0 2 0 0 0 3 9 9 9</float_array>";
    EXPECT_THAT(read(damaged.text()), HasSubstr("line 4: ")) << count;
  }
  Dae infinite;
  infinite.floats = "<float_array id=\"pa\" count=\"3\">0 0 inf</float_array>";
  EXPECT_EQ(read(infinite.text()), "line 4: a number that is not finite, or none at all");
}

TEST(DaeMeshes, PrimitivesThatDoNotFitAreRefused) {
  const std::string input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  EXPECT_EQ(with_primitives("<triangles count=\"3\">" + input + "<p>0 1 2 0 1 3</p></triangles>"),
            "line 7: <triangles> says 9 corners, and has 6");
  EXPECT_EQ(with_primitives("<polylist>" + input + "<vcount>3 4</vcount><p>0 1 2</p></polylist>"),
            "line 7: <polylist> says 7 corners, and has 3");
  EXPECT_THAT(
      with_primitives("<lines>" + input + "<p>0 1e9</p></lines>"),
      HasSubstr("line 7: <p> names a position that its <accessor> does not have: it has 5"));
  EXPECT_EQ(with_primitives("<lines><input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/>"
                            "<p>0 0 0</p></lines>"),
            "line 7: <p> has 3 numbers; needed: a multiple of 2, one for each offset");
  EXPECT_EQ(with_primitives("<lines><p>0 1</p></lines>"),
            "line 7: no <input> of the semantic VERTEX");
  EXPECT_EQ(with_primitives("<lines><input semantic=\"VERTEX\" source=\"o.dae#v\"/></lines>"),
            "line 7: <input> names `o.dae#v`; allowed: # and an id of this file, as no other is "
            "opened");
  EXPECT_EQ(with_primitives("<lines><input semantic=\"VERTEX\" source=\"#w\"/></lines>"),
            "line 7: <input> names `#w`, and no <vertices> has this id");
}

TEST(DaeMeshes, TransformationsThatPlaceNothingAreRefused) {
  EXPECT_EQ(placed("<skew>30 1 0 0 0 0 1</skew>"),
            "line 9: <skew> is not read; write it as a <matrix>");
  EXPECT_EQ(placed("<rotate>0 0 0 9</rotate>"), "line 9: <rotate> has an axis without a direction");
  EXPECT_EQ(placed("<translate>0 0</translate>"), "line 9: <translate> has 2 numbers; needed: 3");
  EXPECT_EQ(placed("<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1</matrix>"),
            "line 9: the last row of <matrix> is not 0 0 0 1");
  EXPECT_EQ(placed("<lookat>0 0 0 0 0 1 0 0 1</lookat>"),
            "line 9: <lookat> has an axis without a direction");
  EXPECT_EQ(placed("<scale>1e200 1 1</scale><scale>1e200 1 1</scale>"),
            "line 9: a node moves a vertex beyond all numbers");
}

TEST(DaeMeshes, InstancesWithoutEndAreRefused) {
  EXPECT_EQ(with_nodes("<node id=\"n\"><instance_node url=\"#n\"/></node>"),
            "line 9: a node that is an instance of itself");
  EXPECT_EQ(with_nodes("<node id=\"a\"><node id=\"b\"><instance_node url=\"#a\"/></node></node>"),
            "line 9: a node that is an instance of itself");
  EXPECT_EQ(with_nodes("<node><instance_node url=\"#a\"/></node>",
                       "<library_nodes><node id=\"a\"/><node id=\"a\"/></library_nodes>"),
            "line 9: <instance_node> names `#a`, and several <node> have this id; give them "
            "different ones");
  EXPECT_THAT(with_nodes("<node><instance_controller url=\"#c\"/></node>",
                         "<library_controllers><controller id=\"c\"><skin source=\"#c\"/>"
                         "</controller></library_controllers>"),
              HasSubstr("line 9: controllers of each other, more than 10"));
  std::string library, chain;
  for (int k = 0; k < 40; ++k) {
    const std::string id = std::to_string(k), next = std::to_string(k + 1);
    const std::string instance = "<instance_node url=\"#b" + next + "\"/>";
    library += "<node id=\"b" + id + "\">" + instance + instance + "</node>\n";
  }
  library = "<library_nodes>" + library + "<node id=\"b40\"/></library_nodes>";
  EXPECT_THAT(with_nodes("<node><instance_node url=\"#b0\"/></node>", library),
              HasSubstr("more than 1000000 nodes, with those that instances repeat"));
  for (int k = 0; k < 200; ++k) {
    chain += "<node id=\"c" + std::to_string(k) + "\"><instance_node url=\"#c" +
             std::to_string(k + 1) + "\"/></node>";
  }
  EXPECT_THAT(with_nodes("<node><instance_node url=\"#c0\"/></node>",
                         "<library_nodes>" + chain + "<node id=\"c200\"/></library_nodes>"),
              HasSubstr("nodes in each other, more than 100"));
}

TEST(DaeMeshes, MoreTagsThanAnyMeshHasAreRefused) {
  std::string text = "<COLLADA>";
  for (int k = 0; k < 1'000'001; ++k) text += "<a/>";
  EXPECT_THAT(read(text + "</COLLADA>"), HasSubstr("more than 1000000 tags and attributes"));
}

}  // namespace
}  // namespace skybody
