// Triangles that plugins have asked for.
#pragma once

#include <map>
#include <string>

#include "core/model/robot_model.h"
#include "core/model/triangle_mesh.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Reads each mesh file and each height field once. The results are valid as long as this object.
class MeshTables {
 public:
  /// @param shape  a mesh with read_triangles
  const SkybodyTriangles* of_file(const Shape& shape);
  /// @param shape  a height field, which must outlive this object
  const SkybodyTriangles* of_field(const Shape& shape);

 private:
  struct Table {
    TriangleMesh mesh;
    std::string problem;
    SkybodyTriangles triangles{};
  };
  static const SkybodyTriangles* point_to(Table& table);

  std::map<std::string, Table> files_;  ///< by file and name in the URDF
  std::map<const Shape*, Table> fields_;
};

}  // namespace skybody
