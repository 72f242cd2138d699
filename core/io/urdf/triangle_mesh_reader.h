// Triangles of mesh files and height fields, for cameras.
#pragma once

#include <string>

#include "core/model/height_field.h"
#include "core/model/triangle_mesh.h"

namespace skybody {

/// Most triangles of a mesh.
inline constexpr int kMostTriangles = 60'000;

/// Whether a file of that name is of a format that read_triangle_mesh() reads.
bool is_readable_mesh(const std::string& name);

/// Reads the faces of a mesh file, as mesh_box.h does; faces of more corners become fans.
/// @returns the reason if there are no triangles ("is a folder"), or an empty text
std::string read_triangle_mesh(const std::string& file, TriangleMesh& mesh);

/// The surface of a height field, in its frame.
/// @param length, width  extents along x and y [m]
/// @returns the reason if there are too many triangles, or an empty text
std::string triangulate(const HeightField& field, double length, double width, TriangleMesh& mesh);

}  // namespace skybody
