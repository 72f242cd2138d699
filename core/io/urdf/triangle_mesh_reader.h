// Triangles of mesh files and height fields, for cameras.
#pragma once

#include <string>

#include "core/io/urdf/mesh_format.h"
#include "core/model/height_field.h"
#include "core/model/triangle_mesh.h"

namespace skybody {

/// Most triangles of a mesh.
inline constexpr int kMostMeshTriangles = 60'000;

/// Reads the faces of a mesh file, as mesh_box.h does; faces of more corners become fans.
/// @param format  by the name in the URDF: the file may have another one, behind a link
/// @returns the reason if there are no triangles ("is a folder"), or an empty text
std::string read_triangle_mesh(const std::string& file, const MeshFormat& format,
                               TriangleMesh& mesh);

/// The surface of a height field, in its frame.
/// @param length, width  extents along x and y [m]
/// @returns the reason if there are too many triangles, or an empty text
std::string triangulate(const HeightField& field, double length, double width, TriangleMesh& mesh);

}  // namespace skybody
