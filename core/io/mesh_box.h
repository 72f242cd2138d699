// The box about a mesh, for contact. Internal to core/io.
#pragma once

#include <string>

#include "core/io/mesh_format.h"

namespace skybody {

/// Largest file of a mesh that is read [bytes].
inline constexpr std::size_t kLargestMesh = 32u << 20;

/// Most files of meshes that are read for one URDF.
inline constexpr std::size_t kMostMeshes = 100;

/// A box along the axes of a mesh.
struct MeshBox {
  Vec3<double> low{0.0, 0.0, 0.0}, high{0.0, 0.0, 0.0};  ///< [m]

  Vec3<double> size() const;  ///< in whole micrometres
  Vec3<double> center() const { return 0.5 * (low + high); }
};

/// Reads the box about the vertices of a mesh file of up to kLargestMesh: those that its faces,
/// lines and points use, or all where the format does not say (PLY) or the file has none of these.
/// Nothing but this one file is read, whatever it names. COLLADA's unit counts, its upward
/// direction does not, as in RViz.
/// @returns why there is no box ("is a folder"), or an empty text
std::string read_mesh_box(const std::string& file, const MeshFormat& format, MeshBox& box);

/// The box about a mesh that is scaled along its axes, rounded to micrometres.
/// @returns why contact cannot do with it ("is flat"), or an empty text
std::string scale_mesh_box(const Vec3<double>& scale, MeshBox& box);

}  // namespace skybody
