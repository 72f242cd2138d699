// Where the meshes of a URDF may lie. Internal to core/io's URDF reader.
//
// Meshes of visuals are only named, for pictures; of those of collisions the box about them is read
// (mesh_box.h). A name counts if it is a regular file in
// the URDF's own folder, in the folder above it (a package with the folders `urdf` and `meshes`),
// in any folder above that has a package.xml, or, for package://NAME/REST, in the folder NAME above
// the URDF or beside a folder above it, if that is a ROS package (it has a package.xml). No other
// place is looked at.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace skybody {

enum class MeshState { kFound, kMissing, kOutside, kNoMesh };

/// What the name of a mesh stands for.
struct MeshFile {
  MeshState state = MeshState::kNoMesh;
  std::string path;  ///< where it was found, without links
};

class UrdfMeshes {
 public:
  explicit UrdfMeshes(const std::string& urdf_file);

  /// What the name, as the URDF has it, stands for.
  const MeshFile& look_up(const std::string& name);

 private:
  MeshFile find(const std::string& name) const;
  MeshFile find_in_package(const std::string& rest) const;
  bool is_inside(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> inside_;  ///< canonical folders that meshes may lie in
  std::map<std::string, MeshFile> known_;
};

}  // namespace skybody
