// Positions used by the geometries of a COLLADA document, for mesh_dae.cpp. Internal to core/io.
#pragma once

#include "core/io/urdf/mesh_dae_document.h"

namespace skybody {

/// The positions of one set of primitives.
struct DaePart {
  const std::vector<double>* values = nullptr;
  std::uint32_t x = 0, y = 0, z = 0;  ///< offsets of the coordinates from a position's first value
  std::vector<std::uint32_t> positions;  ///< index of the first value of each used position, once
  FaceList<std::uint32_t> faces;         ///< if wanted, by the same indices

  Vec3<double> position(std::uint32_t first) const {
    return {(*values)[first + x], (*values)[first + y], (*values)[first + z]};
  }
};

using DaeGeometry = std::vector<DaePart>;

/// Reads each geometry, array and accessor once, even if several elements reference it.
class DaeGeometries {
 public:
  DaeGeometries(const DaeDocument& document, bool wants_faces)
      : document_(document), wants_faces_(wants_faces) {}

  /// @param geometry  <geometry>  @throws MeshError
  const DaeGeometry& read(const tinyxml2::XMLElement& geometry);

 private:
  /// A <float_array>. `user` has, per value, the last part with a position that begins there.
  struct Array {
    std::vector<double> values;
    std::vector<std::uint32_t> user;
  };
  /// The layout of the positions in an <accessor>.
  struct Accessor {
    Array* array = nullptr;
    std::uint32_t offset = 0, stride = 1, count = 0;
    std::uint32_t x = 0, y = 0, z = 0;
  };

  /// The number of values per corner in <p>, and the index of the position's value among them.
  struct Corners {
    std::uint64_t width, place;
  };

  DaePart read_part(const tinyxml2::XMLElement& primitives);
  /// Adds the positions in <p> that `part` does not have yet.
  /// @param used  the positions of all corners are added to it
  /// @returns the number of corners
  std::uint64_t add_positions(const tinyxml2::XMLElement& p, const Corners& corners,
                              const Accessor& from, DaePart& part,
                              std::vector<std::uint32_t>& used);
  const Accessor& positions_of(const tinyxml2::XMLElement& vertices);
  Accessor read_accessor(const tinyxml2::XMLElement& accessor);
  static std::uint32_t read_params(const tinyxml2::XMLElement& accessor, Accessor& result);
  Array& array_of(const tinyxml2::XMLElement& float_array);

  const DaeDocument& document_;
  bool wants_faces_;
  std::uint32_t parts_ = 0;
  std::unordered_map<const tinyxml2::XMLElement*, DaeGeometry> geometries_;
  std::unordered_map<const tinyxml2::XMLElement*, Accessor> accessors_;  ///< by <vertices>
  std::unordered_map<const tinyxml2::XMLElement*, Array> arrays_;
};

}  // namespace skybody
