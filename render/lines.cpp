#include "render/lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace skybody::render {
namespace {

/// Least depth of a line's points [m].
constexpr double kNearest = 0.02;
/// A line on a surface is seen: it may lie that much behind the surface, relative to its depth.
constexpr double kBehind = 5e-4;

/// A point of a line in the image.
struct Seen {
  double x, y;     ///< [pixels]
  double inverse;  ///< 1 / depth [1/m]
  double width, opacity;
  double color[3];
};

/// A part of a line in front of the camera.
struct Segment {
  Seen a, b;
  double along_x, along_y;  ///< from a to b [pixels]
  double length;            ///< [pixels]
};

double mixed(double a, double b, double share) { return a + share * (b - a); }

Seen seen_at(const Pinhole& camera, const LinePoint& point, const Vec3<double>& v) {
  Seen seen{};
  seen.inverse = 1.0 / v.z;
  seen.x = camera.focal_x * v.x * seen.inverse + camera.center_x;
  seen.y = camera.focal_y * v.y * seen.inverse + camera.center_y;
  seen.width = static_cast<double>(point.width);
  seen.opacity = static_cast<double>(point.opacity);
  for (std::size_t c = 0; c < 3; ++c) seen.color[c] = 255.0 * static_cast<double>(point.color[c]);
  return seen;
}

/// The part of a line in front of the camera. @returns whether there is one
bool segment_of(const Pinhole& camera, const Eye& eye, const LinePoint& from, const LinePoint& to,
                Segment& segment) {
  Vec3<double> a = transpose_times(eye.axes, from.position - eye.position);
  Vec3<double> b = transpose_times(eye.axes, to.position - eye.position);
  if (!(a.z > kNearest) && !(b.z > kNearest)) return false;
  const auto cut = [](const Vec3<double>& behind, const Vec3<double>& ahead) {
    return ahead + (behind - ahead) * ((ahead.z - kNearest) / (ahead.z - behind.z));
  };
  if (!(a.z > kNearest)) a = cut(a, b);
  if (!(b.z > kNearest)) b = cut(b, a);
  segment.a = seen_at(camera, from, a);
  segment.b = seen_at(camera, to, b);
  segment.along_x = segment.b.x - segment.a.x;
  segment.along_y = segment.b.y - segment.a.y;
  segment.length = std::sqrt(segment.along_x * segment.along_x + segment.along_y * segment.along_y);
  return std::isfinite(segment.length) && segment.length > 1e-3;
}

/// Pixels [first, last) of an axis whose centres lie between two bounds.
struct Pixels {
  int first, last;
};
Pixels pixels_between(double low, double high, int count) {
  const double most = count;
  return {static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, most)),
          static_cast<int>(std::clamp(std::floor(high - 0.5) + 1.0, 0.0, most))};
}

/// Blends a segment into one pixel.
void blend(const Segment& s, double x, double y, float depth, std::uint8_t* pixel) {
  const double from_x = x - s.a.x, from_y = y - s.a.y;
  const double share = (from_x * s.along_x + from_y * s.along_y) / (s.length * s.length);
  if (!(share >= 0.0 && share < 1.0)) return;
  if (mixed(s.a.inverse, s.b.inverse, share) * static_cast<double>(depth) < 1.0 - kBehind) return;
  const double aside = std::abs(from_x * s.along_y - from_y * s.along_x) / s.length;
  const double width = mixed(s.a.width, s.b.width, share);
  // Lines narrower than a pixel are as faint as they are narrow.
  const double covered = std::clamp(0.5 * std::max(width, 1.0) + 0.5 - aside, 0.0, 1.0);
  const double weight = covered * std::min(width, 1.0) * mixed(s.a.opacity, s.b.opacity, share);
  for (int c = 0; c < 3; ++c) {
    const double color = mixed(s.a.color[c], s.b.color[c], share);
    const double under = pixel[c];
    const double mean = std::clamp(under + weight * (color - under), 0.0, 255.0);
    pixel[c] = static_cast<std::uint8_t>(std::lround(mean));
  }
}

void draw_segment(const Pinhole& camera, const Segment& s, const float* depth, std::uint8_t* rgb) {
  const double reach = 0.5 * std::max({s.a.width, s.b.width, 1.0}) + 0.5;
  const Pixels rows =
      pixels_between(std::min(s.a.y, s.b.y) - reach, std::max(s.a.y, s.b.y) + reach, camera.height);
  const double left = std::min(s.a.x, s.b.x) - reach, right = std::max(s.a.x, s.b.x) + reach;
  for (int y = rows.first; y < rows.last; ++y) {
    const double center = y + 0.5;
    double low = left, high = right;
    if (std::abs(s.along_y) > 1e-6) {  // the band about the line in this row
      const double middle = s.a.x + (center - s.a.y) * s.along_x / s.along_y;
      const double half = std::abs(reach * s.length / s.along_y);
      low = std::max(low, middle - half);
      high = std::min(high, middle + half);
    }
    const Pixels columns = pixels_between(low, high, camera.width);
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y) * camera.width;
    for (int x = columns.first; x < columns.last; ++x) {
      blend(s, x + 0.5, center, depth[row + x], rgb + 3 * (row + x));
    }
  }
}

}  // namespace

void draw_lines(const Pinhole& camera, const Eye& eye, std::span<const LinePoint> points,
                const float* depth, std::uint8_t* rgb) {
  Segment segment;
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (points[k].is_first) continue;
    if (!segment_of(camera, eye, points[k - 1], points[k], segment)) continue;
    draw_segment(camera, segment, depth, rgb);
  }
}

}  // namespace skybody::render
