#include "core/io/urdf/triangle_mesh_reader.h"

#include <array>

#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/urdf/mesh_box.h"

namespace skybody {
namespace {

std::string too_many() {
  return "has more than " + std::to_string(kMostMeshTriangles) +
         " triangles, which is the most that is drawn";
}

/// Collects faces as fans of triangles.
class TriangleSink : public MeshSink {
 public:
  explicit TriangleSink(TriangleMesh& mesh) : mesh_(mesh) {}

  void add_vertex(const Vec3<double>&) override {}
  bool wants_faces() const override { return true; }
  void add_face(std::span<const Vec3<double>> corners) override {
    for (std::size_t k = 2; k < corners.size(); ++k) {
      if (mesh_.count() >= kMostMeshTriangles) throw MeshError(too_many());
      add_corner(corners[0]);
      add_corner(corners[k - 1]);
      add_corner(corners[k]);
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
    mesh.corners.clear();
    return std::string("cannot be drawn: ") + error.what();
  }
  return mesh.count() > 0 ? "" : "has no faces";
}

std::string triangulate(const HeightField& field, double length, double width, TriangleMesh& mesh) {
  const int columns = field.columns(), rows = field.rows();
  if (2L * (columns - 1) * (rows - 1) > kMostMeshTriangles) return too_many();
  TriangleSink sink(mesh);
  const auto corner = [&](int i, int j) {
    return Vec3<double>{length * (static_cast<double>(i) / (columns - 1) - 0.5),
                        width * (static_cast<double>(j) / (rows - 1) - 0.5),
                        field.heights()[static_cast<std::size_t>(j * columns + i)]};
  };
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const Vec3<double> low = corner(i, j), high = corner(i + 1, j + 1);
      sink.add_face(std::array<Vec3<double>, 3>{low, corner(i + 1, j), high});
      sink.add_face(std::array<Vec3<double>, 3>{low, high, corner(i, j + 1)});
    }
  }
  return "";
}

}  // namespace skybody
