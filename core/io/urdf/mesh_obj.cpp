// OBJ: lines of words. `v` defines a vertex; `f`, `l` and `p` reference vertices by their numbers,
// from 1 or, if negative, back from the latest vertex. All other lines are skipped.
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
  explicit ObjReader(const std::string& text)
      : words_(text), used_((text.size() + 1) / kShortestVertex + 1) {}

  VertexBox read() {
    do {
      take_line();
    } while (words_.next_line());
    if (largest_ > vertices_.size()) throw MeshError(line_of_largest_, no_such_vertex());
    VertexBox box;
    for (std::size_t k = 0; k < vertices_.size(); ++k) {
      if (used_[k] || largest_ == 0) box.add(vertices_[k]);
    }
    return box;
  }

 private:
  static std::string no_such_vertex() { return "names a vertex that the file does not have"; }

  void take_line() {
    const std::string_view keyword = words_.next_in_line();
    if (keyword == "v") take_vertex();
    if (keyword != "f" && keyword != "l" && keyword != "p") return;
    for (auto word = next(); !word.empty(); word = next()) use(word.substr(0, word.find('/')));
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

  /// The next word of the line, up to a comment.
  std::string_view next() {
    const std::string_view word = words_.next_in_line();
    return word.substr(0, word.find('#'));
  }

  double next_coordinate() { return words_.coordinate(next()); }

  void use(std::string_view word) {
    const std::optional<long> number = parse_integer<long>(word);
    if (!number || *number == 0) words_.refuse("the number of a vertex is none; allowed: 1, 2 ...");
    const auto count = static_cast<long>(vertices_.size());
    if (*number < -count) words_.refuse(no_such_vertex());
    const auto index = static_cast<std::size_t>(*number > 0 ? *number : count + 1 + *number);
    if (index > used_.size()) words_.refuse(no_such_vertex());
    used_[index - 1] = true;
    if (index <= largest_) return;
    largest_ = index;
    line_of_largest_ = words_.line();
  }

  MeshTokenizer words_;
  std::vector<Vec3<double>> vertices_;
  std::vector<bool> used_;
  std::size_t largest_ = 0;  ///< largest referenced vertex number; 0: none is referenced
  int line_of_largest_ = 0;
};

}  // namespace

VertexBox read_obj(const std::string& bytes) { return ObjReader(bytes).read(); }

}  // namespace skybody
