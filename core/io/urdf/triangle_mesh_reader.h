// Triangles of mesh files, for cameras.
#pragma once

#include <string>

#include "core/io/urdf/mesh_format.h"
#include "core/model/triangle_mesh.h"

namespace skybody {

/// Reads the faces of a mesh file, as mesh_box.h does; faces of more corners become fans.
/// @param format  by the name in the URDF: the file may have another one, behind a link
/// @returns the reason if there are no triangles ("is a folder"), or an empty text
std::string read_triangle_mesh(const std::string& file, const MeshFormat& format,
                               TriangleMesh& mesh);

}  // namespace skybody
