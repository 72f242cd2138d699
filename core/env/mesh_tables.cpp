#include "core/env/mesh_tables.h"

namespace skybody {

const SkybodyTriangles* MeshTables::point_to(Table& table) {
  const std::vector<float>& texture = table.mesh.texture;
  table.triangles = {table.mesh.corners.data(), texture.empty() ? nullptr : texture.data(),
                     table.mesh.count(), table.problem.c_str()};
  return &table.triangles;
}

const SkybodyTriangles* MeshTables::of_file(const Shape& shape) {
  // The name in the URDF gives the format.
  const auto [found, is_new] = files_.try_emplace(shape.mesh_file + '\n' + shape.mesh);
  Table& table = found->second;
  if (is_new) table.problem = shape.read_triangles(table.mesh);
  return point_to(table);
}

const SkybodyTriangles* MeshTables::of_field(const Shape& shape) {
  const auto [found, is_new] = fields_.try_emplace(&shape);
  Table& table = found->second;
  if (is_new) table.problem = triangulate(*shape.heights, shape.size.x, shape.size.y, table.mesh);
  return point_to(table);
}

}  // namespace skybody
