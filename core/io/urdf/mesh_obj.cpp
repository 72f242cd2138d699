// OBJ: lines of words. `v` defines a vertex; `f`, `l` and `p` reference vertices by their numbers,
// from 1 or, if negative, back from the latest vertex. `vt` defines a point of a texture; `f`
// references it behind a slash. All other lines are skipped.
#include <algorithm>
#include <array>
#include <vector>

#include "core/io/urdf/mesh_tokenizer.h"

namespace skybody {
namespace {

/// Length of the shortest vertex line, "v 0 0 0" with its line end: bounds the number of vertices
/// in a file.
constexpr std::size_t kShortestVertex = 8;

class ObjReader {
 public:
  ObjReader(const std::string& text, MeshSink& sink)
      : words_(text), sink_(sink), used_((text.size() + 1) / kShortestVertex + 1) {}

  void read() {
    do {
      take_line();
    } while (words_.next_line());
    if (largest_ > vertices_.size()) throw MeshError(line_of_largest_, no_such_vertex());
    for (std::size_t k = 0; k < vertices_.size(); ++k) {
      if (used_[k] || largest_ == 0) sink_.add_vertex(vertices_[k]);
    }
    // Faces may name vertices that come later.
    const auto position = [this](const Corner& corner) { return vertices_[corner.vertex]; };
    if (points_.empty()) return faces_.pass_to(sink_, position);
    faces_.pass_to(sink_, position, [this](const Corner& corner) {
      return corner.point < points_.size() ? points_[corner.point] : TexturePoint{};
    });
  }

 private:
  struct Corner {
    std::size_t vertex;
    std::size_t point;  ///< of the texture; beyond all: none
  };
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  static std::string no_such_vertex() { return "names a vertex that the file does not have"; }

  void take_line() {
    const std::string_view keyword = words_.next_in_line();
    if (keyword == "v") take_vertex();
    if (keyword == "vt" && sink_.wants_faces()) take_point();
    if (keyword != "f" && keyword != "l" && keyword != "p") return;
    const bool is_face = keyword == "f" && sink_.wants_faces();
    for (auto word = next(); !word.empty(); word = next()) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      const std::size_t index = use(word.substr(0, slash));
      if (is_face) faces_.add_corner({index, point_of(word.substr(slash))});
    }
    if (is_face) faces_.end_face();
  }

  /// x y z, x y z w or x y z red green blue.
  void take_vertex() {
    const Vec3<double> v{next_coordinate(), next_coordinate(), next_coordinate()};
    std::array<std::string_view, 3> more;
    std::size_t count = 0;
    for (auto word = next(); !word.empty(); word = next()) {
      if (count < more.size()) more[count] = word;
      ++count;
    }
    if (count == 0 || count == more.size()) {
      vertices_.push_back(v);
    } else if (count == 1) {
      const double w = words_.coordinate(more[0]);
      vertices_.push_back(v / w);
      if (!is_finite(vertices_.back())) words_.refuse("the weight of a vertex is 0");
    } else {
      words_.refuse("a vertex of " + std::to_string(count + 3) +
                    " numbers; allowed: 3, 4 with a weight, 6 with a colour");
    }
  }

  void take_point() {
    const auto u = static_cast<float>(next_coordinate()), v = static_cast<float>(next_coordinate());
    points_.push_back({u, v});
  }

  /// The point of a texture that a corner names, such as 7 of "/7/3".
  std::size_t point_of(std::string_view rest) const {
    if (rest.empty()) return kNone;
    rest.remove_prefix(1);
    const std::optional<long> number = parse_integer<long>(rest.substr(0, rest.find('/')));
    if (!number || *number == 0) return kNone;
    const long last = static_cast<long>(points_.size());
    if (*number < -last) return kNone;
    return static_cast<std::size_t>(*number > 0 ? *number - 1 : last + *number);
  }

  /// The next word of the line, up to a comment.
  std::string_view next() {
    const std::string_view word = words_.next_in_line();
    return word.substr(0, word.find('#'));
  }

  double next_coordinate() { return words_.coordinate(next()); }

  /// @returns the index of the vertex
  std::size_t use(std::string_view word) {
    const std::optional<long> number = parse_integer<long>(word);
    if (!number || *number == 0) words_.refuse("the number of a vertex is none; allowed: 1, 2 ...");
    const auto count = static_cast<long>(vertices_.size());
    if (*number < -count) words_.refuse(no_such_vertex());
    const auto index = static_cast<std::size_t>(*number > 0 ? *number : count + 1 + *number);
    if (index > used_.size()) words_.refuse(no_such_vertex());
    used_[index - 1] = true;
    if (index > largest_) {
      largest_ = index;
      line_of_largest_ = words_.line();
    }
    return index - 1;
  }

  MeshTokenizer words_;
  MeshSink& sink_;
  std::vector<Vec3<double>> vertices_;
  std::vector<TexturePoint> points_;
  FaceList<Corner> faces_;
  std::vector<bool> used_;
  std::size_t largest_ = 0;  ///< largest referenced vertex number; 0: none is referenced
  int line_of_largest_ = 0;
};

}  // namespace

void read_obj(const std::string& bytes, MeshSink& sink) { ObjReader(bytes, sink).read(); }

}  // namespace skybody
