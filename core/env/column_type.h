// Value types of observations.
#pragma once

#include <array>
#include <cstddef>

#include "core/plugin_abi/abi.h"

namespace skybody {

/// Value types that learners accept. Vectors are float32; images may have any of these types.
enum class ColumnType { kFloat32, kUint8, kUint16 };

struct ColumnTypeInfo {
  int abi;           ///< SkybodyColumnType
  const char* name;  ///< NumPy's name
  int bytes;         ///< per value
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
