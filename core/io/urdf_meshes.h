// Where the meshes of a URDF may lie. Internal to core/io's URDF reader.
//
// Meshes are only named, for pictures; nothing reads them. A name counts if it is a regular file in
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

class UrdfMeshes {
 public:
  explicit UrdfMeshes(const std::string& urdf_file);

  /// What the name, as the URDF has it, stands for.
  MeshState look_up(const std::string& name);

 private:
  MeshState find(const std::string& name) const;
  MeshState find_in_package(const std::string& rest) const;
  bool is_inside(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> inside_;  ///< canonical folders that meshes may lie in
  std::map<std::string, MeshState> known_;
};

}  // namespace skybody
