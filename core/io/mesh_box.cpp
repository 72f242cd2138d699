// Needs: assimp, for the formats. Files may be a stranger's, so that assimp gets the text of one
// file of bounded size from memory, a file system that has no other, the one importer that the
// name's ending stands for, and no processing of its own.
#include "core/io/mesh_box.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "core/base/math.h"
#include "core/base/printable.h"
#include "core/io/file.h"
#include "core/io/ranges.h"
#include "core/io/text.h"

namespace skybody {
namespace {

constexpr std::array<const char*, 4> kExtensions = {".stl", ".dae", ".obj", ".ply"};
/// Nodes of a scene in each other: the function that walks them calls itself.
constexpr int kDeepest = 100;

std::string extension_of(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  std::string extension = dot == name.npos ? "" : name.substr(dot);
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

/// A text as a file that is read.
class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(const std::string& text) : text_(text) {}

  std::size_t Read(void* buffer, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (text_.size() - place_) / size);
    std::memcpy(buffer, text_.data() + place_, whole * size);
    place_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t start = origin == aiOrigin_SET   ? 0
                              : origin == aiOrigin_CUR ? place_
                                                       : text_.size();
    if (offset > text_.size() - start) return aiReturn_FAILURE;
    place_ = start + offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return place_; }
  std::size_t FileSize() const override { return text_.size(); }
  void Flush() override {}

 private:
  const std::string& text_;
  std::size_t place_ = 0;
};

/// A file system with one file.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::string& text) : name_(std::move(name)), text_(text) {}

  bool Exists(const char* name) const override { return name == name_; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    return Exists(name) && mode[0] == 'r' ? new MemoryStream(text_) : nullptr;
  }
  void Close(Assimp::IOStream* file) override { delete file; }

 private:
  std::string name_;
  const std::string& text_;
};

/// Leaves an importer nothing but what reads one extension.
void keep_one(Assimp::Importer& importer, const std::string& extension) {
  const Assimp::BaseImporter* kept = importer.GetImporter(extension.c_str());
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    if (importer.GetImporter(i) != kept) others.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
}

/// What assimp says, without a full stop.
std::string reason_of(const Assimp::Importer& importer) {
  std::string reason = importer.GetErrorString();
  while (!reason.empty() && reason.back() == '.') reason.pop_back();
  return printable(shortened(reason, 200));
}

/// The box about the vertices of a scene.
class BoxFinder {
 public:
  explicit BoxFinder(const aiScene& scene) : scene_(scene) { add(*scene.mRootNode, {}, 0); }

  bool is_empty() const { return !(low_.x <= high_.x); }
  bool is_finite() const { return is_finite_; }
  const Vec3<double>& low() const { return low_; }
  const Vec3<double>& high() const { return high_; }

 private:
  void add(const aiNode& node, const aiMatrix4x4& above, int depth) {
    const aiMatrix4x4 placed = above * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] < scene_.mNumMeshes) add(*scene_.mMeshes[node.mMeshes[i]], placed);
    }
    for (unsigned i = 0; i < node.mNumChildren && depth < kDeepest; ++i) {
      add(*node.mChildren[i], placed, depth + 1);
    }
  }
  void add(const aiMesh& mesh, const aiMatrix4x4& placed) {
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D v = placed * mesh.mVertices[i];
      is_finite_ = is_finite_ && std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
      low_ = {min(low_.x, double{v.x}), min(low_.y, double{v.y}), min(low_.z, double{v.z})};
      high_ = {max(high_.x, double{v.x}), max(high_.y, double{v.y}), max(high_.z, double{v.z})};
    }
  }

  const aiScene& scene_;
  bool is_finite_ = true;
  Vec3<double> low_{kInfinity, kInfinity, kInfinity}, high_{-kInfinity, -kInfinity, -kInfinity};
};

/// COLLADA says how long its unit is.
double unit_of(const aiScene& scene) {
  double unit = 1.0;
  if (scene.mMetaData != nullptr && scene.mMetaData->Get("UnitScaleFactor", unit)) return unit;
  return 1.0;
}

/// To micrometres: COLLADA's rotations go through libm, whose last bits depend on the processor.
double rounded(double length) { return round_half_even(length * 1e6) / 1e6; }

/// The largest coordinate of a box's corners, by size.
double farthest(const MeshBox& box) {
  const auto largest = [](const Vec3<double>& v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); };
  return max(largest(box.low), largest(box.high));
}

std::string too_far() { return "has vertices farther off than " + format_number(kFar) + " m"; }

std::string box_of(const aiScene& scene, MeshBox& box) {
  const BoxFinder found(scene);
  if (found.is_empty()) return "has no vertices";
  const double unit = unit_of(scene);
  box = {found.low() * unit, found.high() * unit};
  return found.is_finite() && farthest(box) <= kFar ? "" : too_far();
}

}  // namespace

Vec3<double> MeshBox::size() const {
  const Vec3<double> d = high - low;
  return {rounded(d.x), rounded(d.y), rounded(d.z)};
}

std::string scale_mesh_box(const Vec3<double>& scale, MeshBox& box) {
  const Vec3<double> a = multiply_elements(box.low, scale), b = multiply_elements(box.high, scale);
  box.low = {rounded(min(a.x, b.x)), rounded(min(a.y, b.y)), rounded(min(a.z, b.z))};
  box.high = {rounded(max(a.x, b.x)), rounded(max(a.y, b.y)), rounded(max(a.z, b.z))};
  if (!(farthest(box) <= kFar)) return too_far();
  const Vec3<double> size = box.size();
  if (min(size.x, min(size.y, size.z)) > 0.0) return "";
  return "is flat: it is " + format_number(size.x) + " x " + format_number(size.y) + " x " +
         format_number(size.z) + " m";
}

bool is_readable_mesh(const std::string& name) {
  return std::find(kExtensions.begin(), kExtensions.end(), extension_of(name)) != kExtensions.end();
}

std::string read_mesh_box(const std::string& file, MeshBox& box) {
  std::string text;
  const std::string problem = read_regular_file(file, kLargestMesh, text);
  if (!problem.empty()) return problem;
  const std::string extension = extension_of(file), name = "mesh" + extension;
  Assimp::Importer importer;
  keep_one(importer, extension);
  importer.SetIOHandler(new OneFile(name, text));  // the importer's from here on
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(name, 0);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    return "cannot be read: " + reason_of(importer);
  }
  return box_of(*scene, box);
}

}  // namespace skybody
