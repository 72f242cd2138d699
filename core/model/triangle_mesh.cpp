#include "core/model/triangle_mesh.h"

namespace skybody {

std::string too_many_triangles() {
  return "has more than " + std::to_string(kMostMeshTriangles) +
         " triangles, which is the most that is drawn";
}

std::string triangulate(const HeightField& field, double length, double width, TriangleMesh& mesh) {
  const int columns = field.columns(), rows = field.rows();
  if (2L * (columns - 1) * (rows - 1) > kMostMeshTriangles) return too_many_triangles();
  const auto add = [&](int i, int j) {
    const double height = field.heights()[static_cast<std::size_t>(j * columns + i)];
    for (const double x : {length * (static_cast<double>(i) / (columns - 1) - 0.5),
                           width * (static_cast<double>(j) / (rows - 1) - 0.5), height}) {
      mesh.corners.push_back(static_cast<float>(x));
    }
  };
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const int corners[6][2] = {{i, j}, {i + 1, j},     {i + 1, j + 1},
                                 {i, j}, {i + 1, j + 1}, {i, j + 1}};
      for (const auto& [column, row] : corners) add(column, row);
    }
  }
  return "";
}

}  // namespace skybody
