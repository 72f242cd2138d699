#include "core/env/mesh_tables.h"

#include "core/io/urdf/triangle_mesh_reader.h"

namespace skybody {

const SkybodyTriangles* MeshTables::point_to(Table& table) {
  table.triangles = {table.mesh.corners.data(), table.mesh.count(), table.problem.c_str()};
  return &table.triangles;
}

const SkybodyTriangles* MeshTables::of_file(const Shape& shape) {
  const MeshFormat& format = *find_mesh_format(shape.mesh);
  const auto [found, is_new] = files_.try_emplace(shape.mesh_file + format.extension);
  Table& table = found->second;
  if (is_new) table.problem = read_triangle_mesh(shape.mesh_file, format, table.mesh);
  return point_to(table);
}

const SkybodyTriangles* MeshTables::of_field(const Shape& shape) {
  const auto [found, is_new] = fields_.try_emplace(&shape);
  Table& table = found->second;
  if (is_new) table.problem = triangulate(*shape.heights, shape.size.x, shape.size.y, table.mesh);
  return point_to(table);
}

}  // namespace skybody
