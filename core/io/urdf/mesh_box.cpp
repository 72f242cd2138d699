#include "core/io/urdf/mesh_box.h"

#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/yaml/ranges.h"

namespace skybody {
namespace {

/// Rounds to micrometres: removes round-off of decimal texts and of rotated corners.
double rounded(double length) { return round_half_even(length * 1e6) / 1e6; }

/// The largest magnitude of a coordinate of the box's corners.
double farthest(const MeshBox& box) {
  const auto largest = [](const Vec3<double>& v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); };
  return max(largest(box.low), largest(box.high));
}

std::string too_far() { return "has vertices farther off than " + format_number(kFar) + " m"; }

}  // namespace

Vec3<double> MeshBox::size() const {
  const Vec3<double> d = high - low;
  return {rounded(d.x), rounded(d.y), rounded(d.z)};
}

std::string scale_mesh_box(const Vec3<double>& scale, MeshBox& box) {
  const Vec3<double> a = multiply_elements(box.low, scale), b = multiply_elements(box.high, scale);
  box.low = {rounded(min(a.x, b.x)), rounded(min(a.y, b.y)), rounded(min(a.z, b.z))};
  box.high = {rounded(max(a.x, b.x)), rounded(max(a.y, b.y)), rounded(max(a.z, b.z))};
  if (!(farthest(box) <= kFar)) return too_far();
  const Vec3<double> size = box.size();
  if (min(size.x, min(size.y, size.z)) > 0.0) return "";
  return "is flat: it is " + format_number(size.x) + " x " + format_number(size.y) + " x " +
         format_number(size.z) + " m";
}

std::string read_mesh_box(const std::string& file, const MeshFormat& format, MeshBox& box) {
  std::string bytes;
  const std::string problem = read_regular_file(file, kLargestMesh, bytes);
  if (!problem.empty()) return problem;
  try {
    VertexBox found;
    format.read(bytes, found);
    if (found.is_empty()) return "has no vertices";
    box = {found.low(), found.high()};
  } catch (const MeshError& error) {
    return std::string("cannot be read: ") + error.what();
  }
  return farthest(box) <= kFar ? "" : too_far();
}

}  // namespace skybody
