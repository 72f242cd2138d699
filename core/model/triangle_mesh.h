// Triangles of a mesh, to draw.
#pragma once

#include <vector>

namespace skybody {

/// The corners of triangles: nine numbers each (x, y, z of three corners), in the mesh's frame [m].
struct TriangleMesh {
  std::vector<float> corners;

  int count() const { return static_cast<int>(corners.size() / 9); }
};

}  // namespace skybody
