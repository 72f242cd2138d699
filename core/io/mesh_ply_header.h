// The header of a PLY file: which values follow it. Internal to core/io.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skybody {

enum class PlyOrder { kText, kLittleEndian, kBigEndian };

/// A type of numbers, by its two names.
struct PlyType {
  const char *name, *sized_name;
  std::size_t size;  ///< [bytes]
  enum Kind { kSigned, kUnsigned, kReal } kind;
};

/// A number, or a list of them with their count before it.
struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count_type = nullptr;  ///< null: it is no list
};

/// Rows of properties.
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The property of this name and no list; -1: there is none.
  int find(const std::string& property) const;
};

struct PlyHeader {
  PlyOrder order = PlyOrder::kText;
  std::vector<PlyElement> elements;
  std::size_t size = 0;  ///< [bytes]
  int lines = 0;
};

/// Reads the header. All elements with a count have properties, and what follows is long enough for
/// them with empty lists. @throws MeshError
PlyHeader read_ply_header(const std::string& bytes);

}  // namespace skybody
