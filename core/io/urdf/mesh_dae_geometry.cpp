// Source: COLLADA 1.4.1, Khronos Group 2008, chapter 5. <mesh> references positions by
// <triangles><input semantic="VERTEX"> -> <vertices><input semantic="POSITION"> -> <source>. The
// <accessor> of <source> assigns values of its <float_array> to positions.
#include "core/io/urdf/mesh_dae_geometry.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace skybody {
namespace {

using tinyxml2::XMLElement;

constexpr std::array<const char*, 7> kPrimitives = {
    "lines", "linestrips", "polygons", "polylist", "triangles", "trifans", "tristrips"};

template <class Visit>
void for_each_child(const XMLElement& parent, const char* name, const Visit& visit) {
  for (const XMLElement* e = parent.FirstChildElement(name); e; e = e->NextSiblingElement(name)) {
    visit(*e);
  }
}

const XMLElement* find_input(const XMLElement& parent, const char* semantic) {
  for (const XMLElement* e = parent.FirstChildElement("input"); e;
       e = e->NextSiblingElement("input")) {
    if (attribute_is(*e, "semantic", semantic)) return e;
  }
  return nullptr;
}

/// Number of values per corner in <p>: one for each offset.
std::uint64_t width_of(const XMLElement& primitives) {
  std::uint64_t width = 0;
  for_each_child(primitives, "input", [&](const XMLElement& input) {
    width = std::max(width, dae_count(input, "offset", 0) + std::uint64_t{1});
  });
  return width;
}

/// Checks the number of corners if the file declares it: for triangles and polygons with counts.
/// (SketchUp declares too many lines.)
void check_corners(const XMLElement& primitives, std::uint64_t corners) {
  const std::string kind = primitives.Name();
  std::uint64_t said = corners;
  if (kind == "triangles") said = 3 * std::uint64_t{dae_count(primitives, "count")};
  if (kind == "polylist") {
    said = 0;
    for_each_child(primitives, "vcount", [&](const XMLElement& vcount) {
      for_each_word(vcount, [&](std::string_view word, const MeshTokenizer& words) {
        const auto count = parse_integer<std::uint32_t>(word);
        if (!count) words.refuse("a count of corners is no whole number from 0 on");
        said += *count;
      });
    });
  }
  if (said == corners) return;
  refuse_element(primitives, "<" + kind + "> says " + std::to_string(said) + " corners, and has " +
                                 std::to_string(corners));
}

template <class Iterator>
void add_face(Iterator first, Iterator last, DaePart& part) {
  for (; first != last; ++first) part.faces.add_corner(*first);
  part.faces.end_face();
}
void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, DaePart& part) {
  const std::uint32_t corners[] = {a, b, c};
  add_face(std::begin(corners), std::end(corners), part);
}

/// Faces of <polylist>, as many corners each as <vcount> says.
void add_polygons(const XMLElement& primitives, const std::vector<std::uint32_t>& used,
                  DaePart& part) {
  std::size_t at = 0;
  for_each_child(primitives, "vcount", [&](const XMLElement& vcount) {
    for_each_word(vcount, [&](std::string_view word, const MeshTokenizer&) {
      const std::size_t count = parse_integer<std::uint32_t>(word).value_or(0);
      if (count > used.size() - at) return;  // check_corners() refuses the file
      const auto first = used.begin() + static_cast<std::ptrdiff_t>(at);
      add_face(first, first + static_cast<std::ptrdiff_t>(count), part);
      at += count;
    });
  });
}

/// The faces of one <p>. @param used  its corners
void add_faces(const XMLElement& primitives, const std::vector<std::uint32_t>& used,
               DaePart& part) {
  const std::string kind = primitives.Name();
  const std::size_t count = used.size();
  if (kind == "triangles") {
    for (std::size_t k = 2; k < count; k += 3)
      add_triangle(used[k - 2], used[k - 1], used[k], part);
  } else if (kind == "polylist") {
    add_polygons(primitives, used, part);
  } else if (kind == "polygons") {
    add_face(used.begin(), used.end(), part);
  } else if (kind == "trifans") {
    for (std::size_t k = 2; k < count; ++k) add_triangle(used[0], used[k - 1], used[k], part);
  } else if (kind == "tristrips") {
    for (std::size_t k = 2; k < count; ++k) {
      const bool is_odd = k % 2 != 0;
      add_triangle(used[k - (is_odd ? 1 : 2)], used[k - (is_odd ? 2 : 1)], used[k], part);
    }
  }
}

}  // namespace

const DaeGeometry& DaeGeometries::read(const XMLElement& geometry) {
  const auto [found, is_new] = geometries_.try_emplace(&geometry);
  if (!is_new) return found->second;
  const XMLElement& mesh = dae_child(geometry, "mesh");
  for (const XMLElement* e = mesh.FirstChildElement(); e; e = e->NextSiblingElement()) {
    const std::string kind = e->Name();
    if (std::find(kPrimitives.begin(), kPrimitives.end(), kind) == kPrimitives.end()) continue;
    found->second.push_back(read_part(*e));
  }
  return found->second;
}

DaePart DaeGeometries::read_part(const XMLElement& primitives) {
  DaePart part;
  const XMLElement* const input = find_input(primitives, "VERTEX");
  const bool has_corners = primitives.FirstChildElement("p") || primitives.FirstChildElement("ph");
  if (input == nullptr && has_corners) {
    refuse_element(primitives, "no <input> of the semantic VERTEX");
  }
  if (input == nullptr) return part;
  const Accessor& from = positions_of(document_.find(*input, "source", {"vertices"}));
  const Corners corners{width_of(primitives), dae_count(*input, "offset", 0)};
  part.values = &from.array->values;
  part.x = from.x;
  part.y = from.y;
  part.z = from.z;
  ++parts_;
  std::uint64_t count = 0;
  std::vector<std::uint32_t> used;
  const auto take = [&](const XMLElement& p) {
    count += add_positions(p, corners, from, part, used);
    if (wants_faces_) add_faces(primitives, used, part);
    used.clear();
  };
  for_each_child(primitives, "p", take);
  for_each_child(primitives, "ph",
                 [&](const XMLElement& with_holes) { for_each_child(with_holes, "p", take); });
  check_corners(primitives, count);
  return part;
}

std::uint64_t DaeGeometries::add_positions(const XMLElement& p, const Corners& corners,
                                           const Accessor& from, DaePart& part,
                                           std::vector<std::uint32_t>& used) {
  std::uint64_t k = 0;
  for_each_word(p, [&](std::string_view word, const MeshTokenizer& words) {
    if (k++ % corners.width != corners.place) return;
    const auto index = parse_integer<std::uint32_t>(word);
    if (!index || *index >= from.count) {
      words.refuse("<p> names a position that its <accessor> does not have: it has " +
                   std::to_string(from.count) + ", numbered from 0");
    }
    const std::uint32_t first = from.offset + *index * from.stride;
    if (wants_faces_) used.push_back(first);
    if (from.array->user[first] == parts_) return;
    from.array->user[first] = parts_;
    part.positions.push_back(first);
  });
  if (k % corners.width != 0) {
    refuse_element(p, "<p> has " + std::to_string(k) + " numbers; needed: a multiple of " +
                          std::to_string(corners.width) + ", one for each offset");
  }
  return k / corners.width;
}

const DaeGeometries::Accessor& DaeGeometries::positions_of(const XMLElement& vertices) {
  const auto [found, is_new] = accessors_.try_emplace(&vertices);
  if (!is_new) return found->second;
  const XMLElement* const input = find_input(vertices, "POSITION");
  if (input == nullptr) refuse_element(vertices, "no <input> of the semantic POSITION");
  const XMLElement& source = document_.find(*input, "source", {"source"});
  found->second = read_accessor(dae_child(dae_child(source, "technique_common"), "accessor"));
  return found->second;
}

DaeGeometries::Accessor DaeGeometries::read_accessor(const XMLElement& accessor) {
  Accessor result;
  result.array = &array_of(document_.find(accessor, "source", {"float_array"}));
  result.offset = dae_count(accessor, "offset", 0);
  result.stride = dae_count(accessor, "stride", 1);
  result.count = dae_count(accessor, "count");
  const std::uint32_t params = read_params(accessor, result);
  if (params > result.stride) {
    refuse_element(accessor, "`stride` of <accessor> is " + std::to_string(result.stride) +
                                 "; needed: at least its " + std::to_string(params) + " <param>s");
  }
  if (result.count == 0) return result;
  const std::uint64_t has = result.array->values.size();
  const std::uint64_t before_last = (result.count - std::uint64_t{1}) * result.stride;
  const std::uint64_t needed = result.offset + before_last + params;
  if (needed > has) {
    refuse_element(accessor, "<accessor> says " + std::to_string(result.count) +
                                 " positions, which take " + std::to_string(needed) +
                                 " values, and its <float_array> has " + std::to_string(has));
  }
  return result;
}

/// Finds the offsets of x, y and z in a position, and returns the number of its values.
std::uint32_t DaeGeometries::read_params(const XMLElement& accessor, Accessor& result) {
  std::uint32_t count = 0;
  bool has_x = false, has_y = false, has_z = false;
  const auto note = [&](const XMLElement& param, const char* axis, bool& is_known,
                        std::uint32_t& place) {
    if (!attribute_is(param, "name", axis)) return;
    is_known = true;
    place = count;
  };
  for_each_child(accessor, "param", [&](const XMLElement& param) {
    note(param, "X", has_x, result.x);
    note(param, "Y", has_y, result.y);
    note(param, "Z", has_z, result.z);
    ++count;
  });
  if (has_x && has_y && has_z) return count;
  refuse_element(accessor, "<accessor> has no <param>s of the names X, Y and Z");
}

DaeGeometries::Array& DaeGeometries::array_of(const XMLElement& float_array) {
  const auto [found, is_new] = arrays_.try_emplace(&float_array);
  if (!is_new) return found->second;
  found->second.values = dae_numbers(float_array, dae_count(float_array, "count"));
  found->second.user.resize(found->second.values.size());
  return found->second;
}

}  // namespace skybody
