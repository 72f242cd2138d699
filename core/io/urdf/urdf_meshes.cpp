#include "core/io/urdf/urdf_meshes.h"

#include <algorithm>
#include <array>

#include "core/io/files/file.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// Extensions of mesh formats in URDFs, in lower case.
constexpr std::array<const char*, 14> kMeshExtensions = {".stl",  ".stlb", ".dae", ".obj", ".ply",
                                                         ".gltf", ".glb",  ".fbx", ".3ds", ".off",
                                                         ".msh",  ".mesh", ".wrl", ".vtk"};

bool is_mesh_name(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return std::find(kMeshExtensions.begin(), kMeshExtensions.end(), extension) !=
         kMeshExtensions.end();
}

fs::path true_path(const fs::path& path) {
  std::error_code code;
  fs::path result = fs::weakly_canonical(path, code);
  return code ? path.lexically_normal() : result;
}

/// Whether `path` lies in `folder`; both canonical.
bool lies_in(const fs::path& path, const fs::path& folder) {
  const auto ends = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return ends.first == folder.end();
}

bool starts_with(const std::string& text, const std::string& start) {
  return text.rfind(start, 0) == 0;
}

}  // namespace

UrdfMeshes::UrdfMeshes(const std::string& urdf_file) {
  std::error_code code;
  folder_ = fs::absolute(urdf_file, code).lexically_normal().parent_path();
  // A symbolic link to a URDF (as colcon installs them): the meshes are next to its target.
  for (const fs::path& folder : {folder_, true_path(urdf_file).parent_path()}) {
    inside_.push_back(true_path(folder));
    // Exclude the root: it contains the whole file system.
    const fs::path above = inside_.back().parent_path();
    if (above != above.root_path()) inside_.push_back(above);
    for (fs::path package = above; package != package.root_path();
         package = package.parent_path()) {
      if (is_file((package / "package.xml").string())) inside_.push_back(package);
    }
  }
}

const MeshFile& UrdfMeshes::look_up(const std::string& name) {
  const auto known = known_.find(name);
  if (known != known_.end()) return known->second;
  return known_[name] = find(name);
}

bool UrdfMeshes::is_inside(const fs::path& path) const {
  return std::any_of(inside_.begin(), inside_.end(),
                     [&](const fs::path& folder) { return lies_in(path, folder); });
}

MeshFile UrdfMeshes::find(const std::string& name) const {
  return is_mesh_name(name) ? find_file(name) : MeshFile{};
}

MeshFile UrdfMeshes::find_file(const std::string& name) const {
  const std::string package = "package://", file = "file://";
  if (starts_with(name, package)) return find_in_package(name.substr(package.size()));
  const fs::path path =
      true_path(folder_ / (starts_with(name, file) ? name.substr(file.size()) : name));
  if (!is_inside(path)) return {MeshState::kOutside, ""};
  return {is_file(path.string()) ? MeshState::kFound : MeshState::kMissing, path.string()};
}

MeshFile UrdfMeshes::find_in_package(const std::string& rest) const {
  const std::size_t slash = std::min(rest.find('/'), rest.size());
  const std::string name = rest.substr(0, slash);
  const fs::path inner = fs::path(rest.substr(slash)).relative_path();
  for (const fs::path& folder : {folder_, folder_.parent_path()}) {
    for (const fs::path& tail : {fs::path(name) / inner, inner}) {
      const fs::path path = true_path(folder / tail);
      if (is_inside(path) && is_file(path.string())) return {MeshState::kFound, path.string()};
    }
  }
  bool outside = false;
  for (fs::path folder = folder_; folder != folder.root_path(); folder = folder.parent_path()) {
    const bool is_package = folder.filename() == name;
    const fs::path root = is_package ? folder : folder / name;
    if (name.empty() || (!is_package && !is_file((root / "package.xml").string()))) continue;
    const fs::path path = true_path(root / inner);
    outside = outside || !lies_in(path, true_path(root));
    if (!outside && is_file(path.string())) return {MeshState::kFound, path.string()};
  }
  const bool is_outside = outside || !is_inside(true_path(folder_ / inner));
  return {is_outside ? MeshState::kOutside : MeshState::kMissing, ""};
}

}  // namespace skybody
