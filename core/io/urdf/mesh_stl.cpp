// STL. Binary: 80 bytes of arbitrary text, the number of triangles, and 50 bytes for each. Text:
// "solid NAME facet normal X Y Z outer loop (vertex X Y Z) x 3 endloop endfacet ... endsolid NAME".
// Binary files may also begin with "solid": size and NUL bytes distinguish the two.
#include <array>

#include "core/io/urdf/mesh_bytes.h"
#include "core/io/urdf/mesh_tokenizer.h"

namespace skybody {
namespace {

constexpr std::size_t kHeader = 84, kTriangle = 50, kNormal = 12, kVertex = 12;
constexpr std::size_t kPlaceOfCount = 80;

std::size_t binary_size(const std::string& bytes) {
  return kHeader + kTriangle * read_bytes<std::uint32_t>(bytes.data() + kPlaceOfCount);
}

bool is_binary(const std::string& bytes) {
  return bytes.size() >= kHeader &&
         (bytes.size() == binary_size(bytes) || bytes.find('\0') != bytes.npos);
}

void read_binary(const std::string& bytes, MeshSink& sink) {
  const std::size_t size = binary_size(bytes);
  if (bytes.size() != size) {
    throw MeshError("its header says " + std::to_string((size - kHeader) / kTriangle) +
                    " triangles, which make " + std::to_string(size) + " bytes, and it has " +
                    std::to_string(bytes.size()));
  }
  std::array<Vec3<double>, 3> face;
  for (std::size_t at = kHeader; at < size; at += kTriangle) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const char* const vertex = bytes.data() + at + kNormal + corner * kVertex;
      const auto coordinate = [&](int k) { return double{read_bytes<float>(vertex + 4 * k)}; };
      const Vec3<double> v{coordinate(0), coordinate(1), coordinate(2)};
      if (!is_finite(v)) {
        throw MeshError("triangle " + std::to_string((at - kHeader) / kTriangle + 1) +
                        " has a coordinate that is not finite");
      }
      sink.add_vertex(v);
      face[corner] = v;
    }
    if (sink.wants_faces()) sink.add_face(face);
  }
}

class StlText {
 public:
  StlText(const std::string& text, MeshSink& sink) : words_(text), sink_(sink) {}

  void read() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      if (!is_word(word, "solid")) refuse("solid");
      read_solid();
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& expected) const {
    words_.refuse("`" + expected + "` is missing");
  }
  void expect(const std::string& expected) {
    if (!is_word(words_.next(), expected)) refuse(expected);
  }

  void read_solid() {
    words_.next_line();  // skip the name, which may contain any words
    std::string_view word = words_.next();
    for (; is_word(word, "facet"); word = words_.next()) read_facet();
    if (!is_word(word, "endsolid")) refuse("endsolid");
    words_.next_line();
  }

  void read_facet() {
    expect("normal");
    for (int k = 0; k < 3; ++k)
      words_.next();  // ignored: exporters write arbitrary numbers or none
    expect("outer");
    expect("loop");
    std::array<Vec3<double>, 3> face;
    for (Vec3<double>& corner : face) {
      expect("vertex");
      const double x = words_.coordinate(), y = words_.coordinate(), z = words_.coordinate();
      corner = {x, y, z};
      sink_.add_vertex(corner);
    }
    if (sink_.wants_faces()) sink_.add_face(face);
    expect("endloop");
    expect("endfacet");
  }

  MeshTokenizer words_;
  MeshSink& sink_;
};

}  // namespace

void read_stl(const std::string& bytes, MeshSink& sink) {
  if (is_binary(bytes)) {
    read_binary(bytes, sink);
  } else {
    StlText(bytes, sink).read();
  }
}

}  // namespace skybody
