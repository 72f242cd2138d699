#include "core/io/urdf/mesh_format.h"

#include <array>
#include <vector>

#include "core/io/files/text.h"

namespace skybody {
namespace {

constexpr std::array<MeshFormat, 4> kFormats = {
    {{".stl", read_stl}, {".dae", read_dae}, {".obj", read_obj}, {".ply", read_ply}}};

std::string extension_of(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  std::string extension = dot == name.npos ? "" : name.substr(dot);
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

}  // namespace

const MeshFormat* find_mesh_format(const std::string& name) {
  const std::string extension = extension_of(name);
  for (const MeshFormat& format : kFormats) {
    if (extension == format.extension) return &format;
  }
  return nullptr;
}

std::string mesh_extensions() {
  std::vector<std::string> extensions;
  for (const MeshFormat& format : kFormats) extensions.emplace_back(format.extension);
  return join(extensions);
}

}  // namespace skybody
