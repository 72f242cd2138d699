// Locations of the meshes and textures of a URDF. Internal to core/io's URDF reader.
//
// Meshes of visuals are read when a camera draws them (triangle_mesh_reader.h); of collision meshes
// the bounding box is read (mesh_box.h). A name is valid if it is a regular file in one of these
// folders:
// - the URDF's own folder
// - the folder above it (a package with the folders `urdf` and `meshes`)
// - any folder above that contains a package.xml
// - for package://NAME/REST: the folder NAME above the URDF, or next to a folder above it, if it is
//   a ROS package (it contains a package.xml)
// No other folder is searched.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace skybody {

enum class MeshState { kFound, kMissing, kOutside, kNoMesh };

/// The result of looking up a mesh's name.
struct MeshFile {
  MeshState state = MeshState::kNoMesh;
  std::string path;  ///< its file, with symbolic links resolved
};

class UrdfMeshes {
 public:
  explicit UrdfMeshes(const std::string& urdf_file);

  /// Looks up a mesh's name as written in the URDF.
  const MeshFile& look_up(const std::string& name);
  /// Looks up the name of a texture, in the same folders. It is never kNoMesh.
  MeshFile look_up_texture(const std::string& name) const { return find_file(name); }

 private:
  MeshFile find(const std::string& name) const;
  MeshFile find_file(const std::string& name) const;
  MeshFile find_in_package(const std::string& rest) const;
  bool is_inside(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> inside_;  ///< canonical folders that may contain meshes
  std::map<std::string, MeshFile> known_;
};

}  // namespace skybody
