// Triangles of a mesh, to draw. C++17.
#pragma once

#include <string>
#include <vector>

#include "core/model/height_field.h"

namespace skybody {

/// Most triangles of a mesh.
inline constexpr int kMostMeshTriangles = 60'000;

/// The corners of triangles: nine numbers each (x, y, z of three corners), in the mesh's frame [m].
struct TriangleMesh {
  std::vector<float> corners;
  /// Coordinates of a texture: six numbers each (u to the right, v up, from 0 to 1, of three
  /// corners). Empty: the mesh has none.
  std::vector<float> texture;

  int count() const { return static_cast<int>(corners.size() / 9); }
};

/// "has more than ... triangles, ...".
std::string too_many_triangles();

/// The surface of a height field, in its frame.
/// @param length, width  extents along x and y [m]
/// @returns the reason if there are too many triangles, or an empty text
std::string triangulate(const HeightField& field, double length, double width, TriangleMesh& mesh);

}  // namespace skybody
