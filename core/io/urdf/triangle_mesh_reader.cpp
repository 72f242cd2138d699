#include "core/io/urdf/triangle_mesh_reader.h"

#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/urdf/mesh_box.h"

namespace skybody {
namespace {

/// Collects faces as fans of triangles.
class TriangleSink : public MeshSink {
 public:
  explicit TriangleSink(TriangleMesh& mesh) : mesh_(mesh) {}

  void add_vertex(const Vec3<double>&) override {}
  bool wants_faces() const override { return true; }
  void add_face(std::span<const Vec3<double>> corners) override {
    for (std::size_t k = 2; k < corners.size(); ++k) {
      if (mesh_.count() >= kMostMeshTriangles) throw MeshError(too_many_triangles());
      add_corner(corners[0]);
      add_corner(corners[k - 1]);
      add_corner(corners[k]);
    }
  }
  void add_textured_face(std::span<const Vec3<double>> corners,
                         std::span<const TexturePoint> texture) override {
    add_face(corners);
    for (std::size_t k = 2; k < texture.size(); ++k) {
      for (const TexturePoint& point : {texture[0], texture[k - 1], texture[k]}) {
        mesh_.texture.push_back(point.u);
        mesh_.texture.push_back(point.v);
      }
    }
  }

 private:
  void add_corner(const Vec3<double>& v) {
    for (const double x : {v.x, v.y, v.z}) mesh_.corners.push_back(static_cast<float>(x));
  }

  TriangleMesh& mesh_;
};

}  // namespace

std::string read_triangle_mesh(const std::string& file, const MeshFormat& format,
                               TriangleMesh& mesh) {
  std::string bytes;
  const std::string problem = read_regular_file(file, kLargestMesh, bytes);
  if (!problem.empty()) return problem;
  TriangleSink sink(mesh);
  try {
    format.read(bytes, sink);
  } catch (const MeshError& error) {
    mesh = {};
    return std::string("cannot be drawn: ") + error.what();
  }
  return mesh.count() > 0 ? "" : "has no faces";
}

}  // namespace skybody
