// The header of a PLY file: the declaration of its values. Internal to core/io.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skybody {

enum class PlyOrder { kText, kLittleEndian, kBigEndian };

/// A numeric type with its two names.
struct PlyType {
  const char *name, *sized_name;
  std::size_t size;  ///< [bytes]
  enum Kind { kSigned, kUnsigned, kReal } kind;
};

/// A number, or a list of numbers with their count before them.
struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count_type = nullptr;  ///< null: not a list
};

/// Rows of properties.
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Index of the property of this name that is not a list; -1: there is none.
  int find(const std::string& property) const;
};

struct PlyHeader {
  PlyOrder order = PlyOrder::kText;
  std::vector<PlyElement> elements;
  std::size_t size = 0;  ///< [bytes]
  int lines = 0;
};

/// Reads the header. Checks that all elements with rows have properties, and that the rest of the
/// file is long enough for these rows with empty lists. @throws MeshError
PlyHeader read_ply_header(const std::string& bytes);

}  // namespace skybody
