// Bounding boxes of meshes: every form of vertices in each format, and damaged files with the
// reason of their refusal.
#include "core/io/urdf/mesh_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "core/io/files/text.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

class MeshBoxes : public ::testing::Test {
 protected:
  /// "low x, y, z, high x, y, z" of the mesh's box in whole micrometres, or the reason why it has
  /// none.
  std::string read(const std::string& name, const std::string& bytes) {
    const std::string file = folder_.write(name, bytes);
    MeshBox box;
    std::string problem = read_mesh_box(file, *find_mesh_format(name), box);
    if (problem.empty()) problem = scale_mesh_box({1.0, 1.0, 1.0}, box);
    if (!problem.empty()) return problem;
    return format_numbers({box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z});
  }

 private:
  TempFolder folder_;
};

const char* const kBox = "[0, 0, 0, 1, 2, 3]";

// --- STL ----------------------------------------------------------------------------------------

template <class Number>
std::string bytes_of(Number number, bool reversed = false) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  if (reversed) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// A binary STL of triangles; each has one zero normal.
std::string binary_stl(std::uint32_t said, const std::vector<std::array<float, 9>>& triangles) {
  std::string bytes = "solid in name alone";
  bytes.resize(80, ' ');
  bytes += bytes_of(said);
  for (const auto& corners : triangles) {
    for (int k = 0; k < 3; ++k) bytes += bytes_of(0.0f);
    for (const float x : corners) bytes += bytes_of(x);
    bytes += bytes_of(std::uint16_t{0});
  }
  return bytes;
}

TEST_F(MeshBoxes, StlsAreBinaryOrText) {
  const std::array<float, 9> one = {0, 0, 0, 1, 0, 0, 0, 2, 0}, two = {0, 0, 0, 1, 0, 0, 0, 0, 3};
  EXPECT_EQ(read("b.stl", binary_stl(2, {one, two})), kBox);
  EXPECT_EQ(read("t.stl",
                 "solid any name facet\n"
                 "FACET NORMAL 0 0 nan OUTER LOOP\n VERTEX 0 0 0\n VERTEX 1 0 0\n"
                 "VERTEX 0 2 0 ENDLOOP ENDFACET\nendsolid\n"
                 "solid\r\nfacet normal 0 0 1\r\nouter loop\r\nvertex 0 0 3\r\n"
                 "vertex 1 0 0\r\nvertex 0 2 0\r\nendloop\r\nendfacet\r\nendsolid any"),
            kBox);
}

TEST_F(MeshBoxes, DamagedStlsAreRefused) {
  const std::array<float, 9> one = {0, 0, 0, 1, 0, 0, 0, 2, 0};
  EXPECT_EQ(read("short.stl", binary_stl(3, {one, one})),
            "cannot be read: its header says 3 triangles, which make 234 bytes, and it has 184");
  EXPECT_THAT(read("many.stl", binary_stl(0xffffffffu, {one})), HasSubstr("4294967295 triangles"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(read("nan.stl", binary_stl(2, {one, {0, 0, 0, 1, nan, 0, 0, 2, 0}})),
            "cannot be read: triangle 2 has a coordinate that is not finite");
  EXPECT_EQ(read("none.stl", binary_stl(0, {})), "has no vertices");
  EXPECT_EQ(read("empty.stl", ""), "has no vertices");
  EXPECT_EQ(read("other.stl", "ply\n"), "cannot be read: line 1: `solid` is missing");
  const std::string facet = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
  EXPECT_EQ(read("cut.stl", facet + "vertex 1 0"), "cannot be read: line 5: a number is missing");
  EXPECT_EQ(read("word.stl", facet + "vertex 1 0 O\n"),
            "cannot be read: line 5: a number that is not finite, or none at all");
  EXPECT_EQ(read("inf.stl", facet + "vertex 1 inf 0\n"),
            "cannot be read: line 5: a number that is not finite, or none at all");
  EXPECT_EQ(read("two.stl", facet + "vertex 1 0 0\nendloop\n"),
            "cannot be read: line 6: `vertex` is missing");
  EXPECT_EQ(read("open.stl", facet + "vertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n"),
            "cannot be read: line 9: `endsolid` is missing");
}

// --- OBJ ----------------------------------------------------------------------------------------

TEST_F(MeshBoxes, ObjsHaveVerticesThatFacesLinesAndPointsUse) {
  const std::string vertices = "v 0 0 0\nv 1 0 0 # right hand side\nv 0 2 0\nv 0 0 3\nv 9 9 9\n";
  EXPECT_EQ(read("f.obj", "mtllib no.mtl\no a\n" + vertices + "g b\nf 1 2/7 3//8 4/1/2\n"), kBox);
  EXPECT_EQ(read("n.obj", vertices + "f -5 -4 -3\nf -5 -4 -2\nv 8 8 8\n"), kBox);
  EXPECT_EQ(read("l.obj", "l 1 2 3\n" + vertices + "p 4\n"), kBox);
  EXPECT_EQ(read("none.obj", vertices), "[0, 0, 0, 9, 9, 9]");
  EXPECT_EQ(read("c.obj", "v 0 0 \\\r\n 0 1\nv 2 0 0 2\nv 0 2 0 1 1 1\nv 0 0 3\nf 1 2 \\\n3 4\n"),
            kBox);
  EXPECT_EQ(read("mac.obj", "v 0 0 0\rv 1 0 0\rv 0 2 0\rv 0 0 3\rf 1 2 3 4"), kBox);
}

TEST_F(MeshBoxes, DamagedObjsAreRefused) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 2 0\n";
  const std::string none = "names a vertex that the file does not have";
  EXPECT_EQ(read("a.obj", "f 1 2 4\n" + vertices), "cannot be read: line 1: " + none);
  EXPECT_EQ(read("b.obj", vertices + "f 1 2 99999999999\n"), "cannot be read: line 4: " + none);
  EXPECT_EQ(read("c.obj", vertices + "f 1 2 -4\n"), "cannot be read: line 4: " + none);
  EXPECT_THAT(read("d.obj", vertices + "f 1 2 0\n"), HasSubstr("line 4: the number of a vertex"));
  EXPECT_THAT(read("e.obj", vertices + "f 1 2 x\n"), HasSubstr("line 4: the number of a vertex"));
  EXPECT_EQ(read("f.obj", "v 1 2\nv 1 2 3\n"), "cannot be read: line 1: a number is missing");
  EXPECT_EQ(read("g.obj", "v 1 2 3 4 5\n"),
            "cannot be read: line 1: a vertex of 5 numbers; allowed: 3, 4 with a weight, 6 with a "
            "colour");
  EXPECT_EQ(read("h.obj", "v 1 2 3 0\n"), "cannot be read: line 1: the weight of a vertex is 0");
  EXPECT_THAT(read("i.obj", "v 1 nan 3\n"), HasSubstr("not finite"));
}

TEST_F(MeshBoxes, ManyGroupsTakeLinearTime) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\n";
  for (int k = 0; k < 200'000; ++k) {
    text += "g " + std::to_string(k) + "\nusemtl m" + std::to_string(k) + "\nf 1 2 3 4\n";
  }
  EXPECT_EQ(read("groups.obj", text), kBox);
}

// --- PLY ----------------------------------------------------------------------------------------

const char* const kPlyText =
    "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement material 1\r\nproperty uchar red\r\n"
    "element vertex 4\r\nproperty float nx\r\nproperty float x\r\nproperty float32 y\r\n"
    "property double z\r\nelement face 2\r\nproperty list uchar int vertex_indices\r\n"
    "property list int8 float other\r\nend_header\r\n7\r\nnan 0 0 0\r\n0 1 0 0\r\n0 0 2 0\r\n"
    "0 0 0 3\r\n3 0 1 2 0\r\n3 0 1 3 2 5 6\r\n";

std::string binary_ply(bool big, std::uint32_t vertices, std::int32_t corner) {
  std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\nelement vertex " + std::to_string(vertices) +
                      "\nproperty double x\nproperty float y\nproperty short z\n"
                      "element face 1\nproperty list ushort int vertex_index\nend_header\n";
  const auto add = [&](auto number) { bytes += bytes_of(number, big); };
  const int places[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  for (const auto& v : places) {
    add(static_cast<double>(v[0]));
    add(static_cast<float>(v[1]));
    add(static_cast<std::int16_t>(v[2]));
  }
  add(std::uint16_t{3});
  for (const std::int32_t k : {0, 1, corner}) add(k);
  return bytes;
}

TEST_F(MeshBoxes, PlysAreTextOrBytesInEitherOrder) {
  EXPECT_EQ(read("t.ply", kPlyText), kBox);
  EXPECT_EQ(read("l.ply", binary_ply(false, 4, 3)), kBox);
  EXPECT_EQ(read("b.ply", binary_ply(true, 4, 3)), kBox);
}

TEST_F(MeshBoxes, DamagedPlysAreRefused) {
  const auto header = [](const std::string& lines) {
    return "ply\nformat ascii 1.0\n" + lines + "end_header\n";
  };
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(read("a.ply", "solid"), "cannot be read: line 1: `ply` is missing");
  EXPECT_THAT(read("b.ply", "ply\nformat binary_bM"), HasSubstr("line 2: `format` is missing"));
  EXPECT_EQ(read("c.ply", "ply\nformat ascii 1.0\nelement vertex 3\n"),
            "cannot be read: line 4: `end_header` is missing");
  EXPECT_THAT(read("d.ply", header("element vertex -5\n" + xyz)),
              HasSubstr("line 3: the count of an element is no whole number from 0 on"));
  EXPECT_THAT(read("e.ply", header("element vertex 65535e9\n" + xyz)), HasSubstr("line 3"));
  EXPECT_EQ(read("f.ply", header("element vertex 1000000000000\n" + xyz) + "0 0 0\n"),
            "cannot be read: the element `vertex` says 1000000000000 rows of at least 6 bytes, and "
            "6 bytes follow the header");
  EXPECT_EQ(read("g.ply", header("element vertex 99999999999\n")),
            "cannot be read: the element `vertex` has no properties");
  EXPECT_EQ(read("h.ply", header("element vertex 1\nproperty float x\nproperty float y\n") + "0 0"),
            "cannot be read: the element `vertex` has no property `z`");
  EXPECT_THAT(read("i.ply", header("element vertex 1\nproperty flaot x\n")), HasSubstr("line 4"));
  EXPECT_EQ(read("j.ply", header("property float x\n")),
            "cannot be read: line 3: a property before any element");
  EXPECT_THAT(read("k.ply", header("element vertex 1\nproperty list float int x\n")),
              HasSubstr("line 4: the count of a list is of a type of no whole numbers"));
  EXPECT_THAT(read("l.ply", binary_ply(false, 5, 3)), HasSubstr("cannot be read"));
  EXPECT_EQ(read("m.ply", binary_ply(true, 4, 4)),
            "cannot be read: a face names vertex 4; the file has 4, numbered from 0");
  EXPECT_EQ(read("n.ply", binary_ply(true, 4, 3) + "more"),
            "cannot be read: more follows than its header says");
  std::string cut = binary_ply(true, 4, 3);
  cut.pop_back();
  EXPECT_EQ(read("o.ply", cut), "cannot be read: the file ends before its last row");
  const std::string vertices = header("element vertex 2\n" + xyz);
  EXPECT_EQ(read("p.ply", vertices + "0 0 0\n1 2 .nan\n"),
            "cannot be read: line 9: a number that is not finite, or none at all");
  EXPECT_EQ(read("q.ply", header("element face 1\nproperty list char int vertex_indices\n") + "-1"),
            "cannot be read: line 6: the count of a list is negative");
  EXPECT_EQ(read("r.ply",
                 header("element face 1\nproperty list int int vertex_indices\n") + "2000000000 0"),
            "cannot be read: line 6: a face names vertex 0; the file has 0, numbered from 0");
}

}  // namespace
}  // namespace skybody
