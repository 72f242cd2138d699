// The types that values of an observation may have.
#pragma once

#include <array>
#include <cstddef>

#include "plugins/api/abi.h"

namespace skybody {

/// What learners take. Vectors are float32; images may be any.
enum class ColumnType { kFloat32, kUint8, kUint16 };

struct ColumnTypeInfo {
  int abi;           ///< SkybodyColumnType
  const char* name;  ///< as NumPy has it
  int bytes;         ///< of a value
};

/// In the order of the enumerators.
inline constexpr std::array<ColumnTypeInfo, SKYBODY_COLUMN_TYPE_COUNT> kColumnTypes = {{
    {SKYBODY_FLOAT32, "float32", 4},
    {SKYBODY_UINT8, "uint8", 1},
    {SKYBODY_UINT16, "uint16", 2},
}};

constexpr const ColumnTypeInfo& info_of(ColumnType type) {
  return kColumnTypes[static_cast<std::size_t>(type)];
}

}  // namespace skybody
