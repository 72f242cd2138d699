// Meshes: depths, ids and normals against triangles in double, closed surfaces without holes.
#include "render/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/render/scenes.h"

namespace skybody::testing {
namespace {

using ::testing::Each;
using ::testing::Lt;

/// Hash of the images of AllKernelsGiveTheSameBits. It changes with the renderer's arithmetic only.
constexpr std::uint64_t kPinned = 2485669622093505392u;

using Corners = std::vector<float>;

void add(Corners& corners, const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c) {
  for (const Vec3<double>& v : {a, b, c}) {
    for (const double x : {v.x, v.y, v.z}) corners.push_back(static_cast<float>(x));
  }
}

/// A sphere of radius 1 of rings and columns.
Corners sphere(int rings, int columns) {
  const auto point = [&](int ring, int column) {
    const SinCos<double> fall = sincos(kPi * ring / rings);
    const SinCos<double> turn = sincos(kTwoPi * column / columns);
    return Vec3<double>{fall.sin * turn.cos, fall.sin * turn.sin, fall.cos};
  };
  Corners corners;
  for (int r = 0; r < rings; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (r > 0) add(corners, point(r, c), point(r + 1, c), point(r, c + 1));
      if (r + 1 < rings) add(corners, point(r, c + 1), point(r + 1, c), point(r + 1, c + 1));
    }
  }
  return corners;
}

/// A box of half edges 1.
Corners box() {
  Corners corners;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      const auto point = [&](double u, double v) {
        const double values[3] = {side, u, v};
        return Vec3<double>{values[(3 - axis) % 3], values[(4 - axis) % 3], values[(5 - axis) % 3]};
      };
      add(corners, point(-1, -1), point(1, -1), point(1, 1));
      add(corners, point(-1, -1), point(1, 1), point(-1, 1));
    }
  }
  return corners;
}

PlacedShape mesh_at(const Mesh& mesh, const Vec3<double>& position, const Mat3<double>& axes) {
  PlacedShape shape = shape_at(Solid::kMesh, position, {}, axes);
  shape.mesh = &mesh;
  return shape;
}

/// Depth of the nearest triangle in the direction (x, y, 1), in double: T. Moeller and B. Trumbore,
/// 1997. Infinite if there is none; `edge` is the least barycentric coordinate there.
double depth_of(const Corners& corners, const PlacedShape& shape, const Eye& eye, double x,
                double y, double& edge) {
  const Vec3<double> from = transpose_times(shape.axes, eye.position - shape.position);
  const Vec3<double> along = transpose_times(shape.axes, eye.axes * Vec3<double>{x, y, 1.0});
  double nearest = HUGE_VAL;
  for (std::size_t i = 0; i + 9 <= corners.size(); i += 9) {
    const auto corner = [&](std::size_t k) {
      return Vec3<double>{corners[i + 3 * k], corners[i + 3 * k + 1], corners[i + 3 * k + 2]};
    };
    const Vec3<double> ab = corner(1) - corner(0), ac = corner(2) - corner(0);
    const Vec3<double> p = cross(along, ac), s = from - corner(0), q = cross(s, ab);
    const double determinant = dot(ab, p);
    const double u = dot(s, p) / determinant, v = dot(along, q) / determinant;
    const double t = dot(ac, q) / determinant;
    const double inside = std::min(std::min(u, v), 1.0 - u - v);
    if (inside >= 0.0 && t > 0.0 && t < nearest) {
      nearest = t;
      edge = inside;
    }
  }
  return nearest;
}

TEST(MeshTest, DepthsAreThoseOfTrianglesInDouble) {
  const Corners corners = sphere(14, 20);
  const Mesh mesh(corners, {1.0, 1.0, 1.0});
  Camera camera(square_of(32), Capacity(4, mesh.count()));
  RandomScenes scenes(31);
  int compared = 0, hits_of_nothing = 0;
  for (int k = 0; k < 60; ++k) {
    const Vec3<double> turn = scenes.angles();
    const PlacedShape shape = mesh_at(mesh, scenes.point(1.0), turned(turn.x, turn.y, turn.z));
    const Eye eye = scenes.eye(4.0);
    camera.draw(eye, {shape});
    camera.each_pixel([&](std::size_t i, double x, double y) {
      double edge = 1.0;
      const double depth = depth_of(corners, shape, eye, x, y, edge);
      if (depth == HUGE_VAL) {
        // At the silhouette float may see the mesh.
        hits_of_nothing += camera.instance[i] != 0 ? 1 : 0;
        return;
      }
      if (edge < 1e-3) return;
      ++compared;
      // Steep triangles multiply the error of a direction in float.
      ASSERT_NEAR(camera.depth[i], depth, 5e-5 * depth) << "scene " << k << ", pixel " << i;
      ASSERT_EQ(camera.instance[i], 1);
    });
  }
  EXPECT_GT(compared, 1000);
  EXPECT_LT(hits_of_nothing, 3);
}

TEST(MeshTest, ABoxOfTrianglesLooksLikeABox) {
  const Mesh mesh(box(), {0.5, 0.3, 0.4});
  Camera of_mesh(square_of(48), Capacity(4, mesh.count())), of_box(square_of(48));
  RandomScenes scenes(32);
  int compared = 0, others = 0;
  for (int k = 0; k < 80; ++k) {
    const Vec3<double> turn = scenes.angles();
    const Mat3<double> axes = turned(turn.x, turn.y, turn.z);
    const Vec3<double> position = scenes.point(1.0);
    const Eye eye = scenes.eye(3.0);
    const PlacedShape solid = shape_at(Solid::kBox, position, {0.5, 0.3, 0.4}, axes);
    if (contains(solid, eye.position)) continue;
    of_mesh.draw(eye, {mesh_at(mesh, position, axes)});
    of_box.draw(eye, {solid});
    for (std::size_t i = 0; i < of_box.pixels(); ++i) {
      if (of_mesh.instance[i] != of_box.instance[i]) {
        ++others;
        continue;
      }
      if (of_box.instance[i] == 0) continue;
      ++compared;
      EXPECT_NEAR(of_mesh.depth[i], of_box.depth[i], 2e-5f * of_box.depth[i]);
    }
  }
  EXPECT_GT(compared, 2500);
  EXPECT_LT(others, 5);  // at the silhouette
}

TEST(MeshTest, AClosedMeshHasNoHoles) {
  const Corners corners = sphere(40, 60);
  const Mesh mesh(corners, {1.0, 1.0, 1.0});
  Camera camera(square_of(64), Capacity(4, mesh.count()));
  for (int k = 0; k < 60; ++k) {
    const SinCos<double> turn = sincos(0.1 * k);
    // Close by, so that the sphere of triangles is all that the camera sees.
    camera.draw({{1.05 * turn.cos, 1.05 * turn.sin, 0.0}, looking(0.0, 0.0, 0.1 * k + kPi)},
                {mesh_at(mesh, {0.0, 0.0, 0.0}, turned(0.2 * k, 0.1 * k, 0.0))});
    EXPECT_THAT(camera.instance, Each(1)) << "step " << k;
    EXPECT_THAT(camera.depth, Each(Lt(0.4f))) << "step " << k;  // not the far side
  }
}

TEST(MeshTest, ADenseMeshFarOffHasNoHoles) {
  const Mesh mesh(sphere(120, 180), {0.25, 0.25, 0.25});
  for (const double distance : {20.0, 60.0, 150.0}) {
    // A telephoto lens: 64 pixels of a much wider image, 10 pixels per triangle or fewer.
    const double focal = 40.0 * distance;
    Camera camera({64, 64, focal, focal, 32.0, 32.0}, Capacity(4, mesh.count()), 1000.0);
    camera.draw({{-distance, 0.0, 0.0}, looking(0.0, 0.0, 0.0)},
                {mesh_at(mesh, {0.0, 0.0, 0.0}, turned(0.3, 0.2, 0.1))});
    int seen = 0;
    camera.each_pixel([&](std::size_t i, double x, double y) {
      if (std::sqrt(x * x + y * y) * distance > 0.24) return;
      ++seen;
      EXPECT_EQ(camera.instance[i], 1) << "distance " << distance << ", pixel " << i;
      EXPECT_LT(camera.depth[i], distance) << "distance " << distance << ", pixel " << i;
    });
    EXPECT_GT(seen, 250);
  }
}

TEST(MeshTest, NoPixelOfAWideImageIsLeftOut) {
  // Triangles of a wall, smaller than a pixel, each of which holds the centre of one pixel.
  constexpr int kWidth = 1280;
  const Pinhole pinhole{kWidth, 4, 500.0, 500.0, 640.0, 2.0};
  Corners corners;
  for (int column = 0; column < kWidth; ++column) {
    const double x = (column + 0.5 - 640.0) / 500.0, y = -0.5 / 500.0, r = 0.3 / 500.0;
    add(corners, {x - r, y - r, 1.0}, {x + r, y - r, 1.0}, {x, y + r, 1.0});
  }
  const Mesh mesh(corners, {1.0, 1.0, 1.0});
  Camera camera(pinhole, Capacity(4, mesh.count()));
  camera.draw({{0.0, 0.0, 0.0}, Mat3<double>{{1, 0, 0, 0, 1, 0, 0, 0, 1}}},
              {mesh_at(mesh, {0.0, 0.0, 0.0}, Mat3<double>{{1, 0, 0, 0, 1, 0, 0, 0, 1}})});
  for (std::size_t column = 0; column < kWidth; ++column) {
    EXPECT_EQ(camera.instance[kWidth + column], 1) << "column " << column;
  }
}

TEST(MeshTest, NormalsAreTowardsTheEyeAndOrthogonalToTheTriangle) {
  const Mesh mesh(sphere(60, 80), {1.0, 1.0, 1.0});
  Camera camera(square_of(32), Capacity(4, mesh.count()));
  const Eye eye{{3.0, 0.4, 0.2}, looking(0.0, 0.0, kPi)};
  camera.draw(eye, {mesh_at(mesh, {0.0, 0.0, 0.0}, turned(0.0, 0.0, 0.0))});
  int compared = 0;
  camera.each_pixel([&](std::size_t i, double x, double y) {
    if (camera.instance[i] == 0) return;
    ++compared;
    const Vec3<double> point =
        eye.position + eye.axes * Vec3<double>{x, y, 1.0} * static_cast<double>(camera.depth[i]);
    const Vec3<double> out = transpose_times(eye.axes, point / norm(point));
    const Vec3<double> normal{camera.normal[3 * i], camera.normal[3 * i + 1],
                              camera.normal[3 * i + 2]};
    EXPECT_NEAR(norm(normal), 1.0, 1e-5);
    EXPECT_GT(dot(normal, out), std::cos(0.06));  // the angle between triangles is 0.08
  });
  EXPECT_GT(compared, 100);
}

TEST(MeshTest, RaysInAllDirectionsSeeIt) {
  RayImage rays{60, 30, {}};
  for (int row = 0; row < rays.height; ++row) {
    const SinCos<double> rise = sincos(kPi * ((row + 0.5) / rays.height - 0.5));
    for (int column = 0; column < rays.width; ++column) {
      const SinCos<double> turn = sincos(kTwoPi * column / rays.width);
      rays.directions.push_back({rise.cos * turn.sin, rise.sin, rise.cos * turn.cos});
    }
  }
  const Mesh mesh(sphere(60, 80), {2.0, 2.0, 2.0});
  Camera camera(rays, Capacity(4, mesh.count()));
  // From inside: the radius, but for the flatness of triangles.
  camera.draw({{0.0, 0.0, 0.0}, looking(0.1, 0.2, 0.3)},
              {mesh_at(mesh, {0.0, 0.0, 0.0}, turned(0.0, 0.0, 0.0))});
  EXPECT_THAT(camera.instance, Each(1));
  EXPECT_THAT(camera.range, Each(::testing::FloatNear(2.0f, 0.004f)));
}

TEST(MeshTest, AllKernelsGiveTheSameBits) {
  const Mesh mesh(sphere(9, 11), {1.0, 0.7, 1.3});
  std::vector<std::uint64_t> hashes;
  for (const KernelTable* table : all_kernels()) {
    RandomScenes scenes(33);
    Camera camera({75, 50, 40.0, 41.0, 37.0, 24.0}, Capacity(64, 3 * mesh.count()), 30.0, *table);
    HashChain chain(1);
    for (int k = 0; k < 40; ++k) {
      std::vector<PlacedShape> shapes = scenes.scene(10);
      for (int m = 0; m < 3; ++m) {
        const Vec3<double> turn = scenes.angles();
        shapes.push_back(mesh_at(mesh, scenes.point(4.0), turned(turn.x, turn.y, turn.z)));
      }
      camera.draw(scenes.eye(k % 2 == 0 ? 5.0 : 1.0), shapes);
      camera.add_to(chain);
    }
    hashes.push_back(chain.value());
  }
  EXPECT_THAT(hashes, Each(kPinned));
}

}  // namespace
}  // namespace skybody::testing
