// PLY: a header of lines, then the rows of its elements, as words or as bytes in either order. All
// rows are read, to detect missing or invalid ones. The box includes all vertices of `vertex`.
#include <array>
#include <cmath>
#include <vector>

#include "core/io/urdf/mesh_bytes.h"
#include "core/io/urdf/mesh_ply_header.h"
#include "core/io/urdf/mesh_tokenizer.h"

namespace skybody {
namespace {

/// Reads values written as words.
class TextValues {
 public:
  TextValues(const std::string& bytes, const PlyHeader& header)
      : words_(std::string_view(bytes).substr(header.size), header.lines + 1) {}

  double coordinate(const PlyType&) { return words_.coordinate(); }
  std::int64_t integer(const PlyType&) {
    const auto number = parse_integer<std::int64_t>(words_.next());
    if (!number) refuse("a count or number of a vertex is no whole number");
    return *number;
  }
  void skip(const PlyType&) {
    if (words_.next().empty()) refuse("the file ends before its last row");
  }
  bool is_at_end() { return words_.next().empty(); }
  [[noreturn]] void refuse(const std::string& reason) const { words_.refuse(reason); }

 private:
  MeshTokenizer words_;
};

/// Reads values stored as bytes.
class BinaryValues {
 public:
  BinaryValues(const std::string& bytes, const PlyHeader& header)
      : bytes_(bytes),
        at_(header.size),
        order_(header.order == PlyOrder::kBigEndian ? std::endian::big : std::endian::little) {}

  double coordinate(const PlyType& type) {
    const double number =
        type.kind == PlyType::kReal ? real(type) : static_cast<double>(integer(type));
    if (!std::isfinite(number)) refuse("a coordinate that is not finite");
    return number;
  }
  std::int64_t integer(const PlyType& type) {
    if (type.kind == PlyType::kReal)
      refuse("the number of a vertex is of a type of no whole numbers");
    const bool has_sign = type.kind == PlyType::kSigned;
    const char* const at = take(type);
    if (type.size == 1) {
      return has_sign ? read_bytes<std::int8_t>(at) : read_bytes<std::uint8_t>(at);
    }
    if (type.size == 2) {
      return has_sign ? read_bytes<std::int16_t>(at, order_)
                      : read_bytes<std::uint16_t>(at, order_);
    }
    return has_sign ? read_bytes<std::int32_t>(at, order_)
                    : std::int64_t{read_bytes<std::uint32_t>(at, order_)};
  }
  void skip(const PlyType& type) { take(type); }
  bool is_at_end() const { return bytes_.find_first_not_of(" \r\n", at_) == bytes_.npos; }
  [[noreturn]] void refuse(const std::string& reason) const { throw MeshError(reason); }

 private:
  double real(const PlyType& type) {
    const char* const at = take(type);
    return type.size == 4 ? double{read_bytes<float>(at, order_)} : read_bytes<double>(at, order_);
  }
  const char* take(const PlyType& type) {
    if (bytes_.size() - at_ < type.size) refuse("the file ends before its last row");
    at_ += type.size;
    return bytes_.data() + at_ - type.size;
  }

  const std::string& bytes_;
  std::size_t at_;
  std::endian order_;
};

/// Indices of x, y and z among the properties of the element `vertex`.
std::array<int, 3> find_coordinates(const PlyElement& vertex) {
  std::array<int, 3> places{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    places[axis] = vertex.find(name);
    if (places[axis] < 0) throw MeshError("the element `vertex` has no property `" + name + "`");
  }
  return places;
}

template <class Values>
class PlyBody {
 public:
  PlyBody(const std::string& bytes, const PlyHeader& header, MeshSink& sink)
      : header_(header), sink_(sink), values_(bytes, header) {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex") vertex_count_ = element.count;
    }
  }

  void read() {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex") {
        read_vertices(element);
      } else {
        read_others(element);
      }
    }
    if (!values_.is_at_end()) values_.refuse("more follows than its header says");
    // Faces may precede the vertices in the file.
    faces_.pass_to(sink_, [this](std::size_t k) { return vertices_[k]; });
  }

 private:
  void read_vertices(const PlyElement& element) {
    const std::array<int, 3> places = find_coordinates(element);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      Vec3<double> v{0.0, 0.0, 0.0};
      for (int k = 0; k < static_cast<int>(element.properties.size()); ++k) {
        const PlyProperty& property = element.properties[static_cast<std::size_t>(k)];
        if (k == places[0]) {
          v.x = values_.coordinate(*property.type);
        } else if (k == places[1]) {
          v.y = values_.coordinate(*property.type);
        } else if (k == places[2]) {
          v.z = values_.coordinate(*property.type);
        } else {
          pass(property);
        }
      }
      sink_.add_vertex(v);
      if (sink_.wants_faces()) vertices_.push_back(v);
    }
  }

  void read_others(const PlyElement& element) {
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : element.properties) {
        const bool is_corners =
            element.name == "face" && property.count_type != nullptr &&
            (property.name == "vertex_indices" || property.name == "vertex_index");
        is_corners ? check_corners(property) : pass(property);
      }
    }
  }

  std::int64_t count_of(const PlyProperty& list) {
    const std::int64_t count = values_.integer(*list.count_type);
    if (count < 0) values_.refuse("the count of a list is negative");
    return count;
  }

  void pass(const PlyProperty& property) {
    const std::int64_t count = property.count_type == nullptr ? 1 : count_of(property);
    for (std::int64_t k = 0; k < count; ++k) values_.skip(*property.type);
  }

  void check_corners(const PlyProperty& list) {
    const std::int64_t count = count_of(list);
    for (std::int64_t k = 0; k < count; ++k) {
      const std::int64_t vertex = values_.integer(*list.type);
      if (vertex < 0 || static_cast<std::uint64_t>(vertex) >= vertex_count_) {
        values_.refuse("a face names vertex " + std::to_string(vertex) + "; the file has " +
                       std::to_string(vertex_count_) + ", numbered from 0");
      }
      if (sink_.wants_faces()) faces_.add_corner(static_cast<std::size_t>(vertex));
    }
    if (sink_.wants_faces()) faces_.end_face();
  }

  const PlyHeader& header_;
  MeshSink& sink_;
  Values values_;
  std::vector<Vec3<double>> vertices_;
  FaceList<std::size_t> faces_;
  std::uint64_t vertex_count_ = 0;
};

}  // namespace

void read_ply(const std::string& bytes, MeshSink& sink) {
  const PlyHeader header = read_ply_header(bytes);
  if (header.order == PlyOrder::kText) {
    PlyBody<TextValues>(bytes, header, sink).read();
  } else {
    PlyBody<BinaryValues>(bytes, header, sink).read();
  }
}

}  // namespace skybody
