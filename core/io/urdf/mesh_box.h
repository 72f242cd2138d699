// The bounding box of a mesh, for contact. Internal to core/io.
#pragma once

#include <string>

#include "core/io/urdf/mesh_format.h"

namespace skybody {

/// Size limit of a mesh file [bytes].
inline constexpr std::size_t kLargestMesh = 32u << 20;

/// Largest number of mesh files that are read for one URDF.
inline constexpr std::size_t kMostMeshes = 100;

/// A box along the axes of a mesh.
struct MeshBox {
  Vec3<double> low{0.0, 0.0, 0.0}, high{0.0, 0.0, 0.0};  ///< [m]

  Vec3<double> size() const;  ///< in whole micrometres
  Vec3<double> center() const { return 0.5 * (low + high); }
};

/// Reads the bounding box of the vertices of a mesh file of up to kLargestMesh. Only vertices used
/// by faces, lines and points count; all vertices count if the format has no such reference (PLY)
/// or the file has no faces, lines and points. No other file is read, even if this file names one.
/// COLLADA's unit is applied; its upward direction is ignored, as in RViz.
/// @returns the reason if there is no box ("is a folder"), or an empty text
std::string read_mesh_box(const std::string& file, const MeshFormat& format, MeshBox& box);

/// Scales the box along the mesh's axes and rounds it to micrometres.
/// @returns the reason if contact cannot use the box ("is flat"), or an empty text
std::string scale_mesh_box(const Vec3<double>& scale, MeshBox& box);

}  // namespace skybody
