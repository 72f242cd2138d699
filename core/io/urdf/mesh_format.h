// The supported mesh formats and shared types of their readers. Internal to core/io.
//
// Mesh files may be untrusted. Each reader
// - needs time and memory that are linear in the file's size,
// - opens no other file,
// - checks each declared count against the file's size before using it,
// - rejects inconsistent files.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/base/math/math.h"
#include "core/base/math/vec3.h"
#include "core/base/system/error.h"

namespace skybody {

/// The reason why a mesh is rejected. Readers throw it, read_mesh_box() catches it.
class MeshError : public Error {
 public:
  explicit MeshError(const std::string& reason) : Error(reason) {}
  MeshError(int line, const std::string& reason)
      : Error("line " + std::to_string(line) + ": " + reason) {}
};

/// A point of a texture: u to the right, v up, from 0 to 1.
struct TexturePoint {
  float u = 0.0f, v = 0.0f;
};

/// Receives the content of a mesh file, in metres.
class MeshSink {
 public:
  virtual ~MeshSink() = default;
  /// A vertex. Only those that faces, lines and points use; all if the format has no such reference
  /// (PLY) or the file has no faces, lines and points.
  virtual void add_vertex(const Vec3<double>& v) = 0;
  virtual bool wants_faces() const { return false; }
  /// The corners of a face in order, 3 or more. @throws MeshError if there are too many faces
  virtual void add_face(std::span<const Vec3<double>>) {}
  /// The same, with the points of a texture at the corners.
  virtual void add_textured_face(std::span<const Vec3<double>> corners,
                                 std::span<const TexturePoint>) {
    add_face(corners);
  }
};

/// Faces as lists of corners, kept until all vertices are known.
template <class Index>
class FaceList {
 public:
  void add_corner(Index vertex) { corners_.push_back(vertex); }
  void end_face() { ends_.push_back(corners_.size()); }
  std::size_t corner_count() const { return corners_.size(); }

  /// Passes the faces of 3 and more corners on. @param position  of a vertex
  template <class Position>
  void pass_to(MeshSink& sink, Position&& position) const {
    std::vector<Vec3<double>> face;
    each_face([&](std::span<const Index> corners) {
      face.clear();
      for (const Index& corner : corners) face.push_back(position(corner));
      sink.add_face(face);
    });
  }
  /// The same, with points of a texture. @param point  of a vertex
  template <class Position, class Point>
  void pass_to(MeshSink& sink, Position&& position, Point&& point) const {
    std::vector<Vec3<double>> face;
    std::vector<TexturePoint> texture;
    each_face([&](std::span<const Index> corners) {
      face.clear();
      texture.clear();
      for (const Index& corner : corners) {
        face.push_back(position(corner));
        texture.push_back(point(corner));
      }
      sink.add_textured_face(face, texture);
    });
  }

 private:
  template <class Take>
  void each_face(Take&& take) const {
    std::size_t first = 0;
    for (const std::size_t end : ends_) {
      if (end - first >= 3) take(std::span(corners_).subspan(first, end - first));
      first = end;
    }
  }

  std::vector<Index> corners_;     ///< of all faces
  std::vector<std::size_t> ends_;  ///< where the corners of each face end
};

/// The axis-aligned bounding box of the vertices.
class VertexBox : public MeshSink {
 public:
  void add_vertex(const Vec3<double>& v) override {
    low_ = {min(low_.x, v.x), min(low_.y, v.y), min(low_.z, v.z)};
    high_ = {max(high_.x, v.x), max(high_.y, v.y), max(high_.z, v.z)};
  }

  bool is_empty() const { return !(low_.x <= high_.x); }
  const Vec3<double>& low() const { return low_; }
  const Vec3<double>& high() const { return high_; }

 private:
  Vec3<double> low_{kInfinity, kInfinity, kInfinity}, high_{-kInfinity, -kInfinity, -kInfinity};
};

/// Each reader passes the content of a file's bytes to the sink. @throws MeshError
void read_stl(const std::string& bytes, MeshSink& sink);
void read_dae(const std::string& bytes, MeshSink& sink);
void read_obj(const std::string& bytes, MeshSink& sink);
void read_ply(const std::string& bytes, MeshSink& sink);

struct MeshFormat {
  const char* extension;  ///< in lower case
  void (*read)(const std::string& bytes, MeshSink& sink);
};

/// The format of a file name's extension, in any case; null: not supported.
const MeshFormat* find_mesh_format(const std::string& name);

/// ".stl, .dae, .obj, .ply".
std::string mesh_extensions();

}  // namespace skybody
