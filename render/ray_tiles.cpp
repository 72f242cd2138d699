#include "render/ray_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace skybody::render {
namespace {

constexpr int kFaces = 6;

/// Camera axes from those of a face, whose forward axis is axis face / 2, backwards if odd.
Mat3<double> axes_of_face(int face) {
  const auto forward = static_cast<std::size_t>(face / 2);
  const std::size_t right = (forward + 1) % 3, down = (forward + 2) % 3;
  Mat3<double> axes{};
  axes(right, 0) = 1.0;
  axes(down, 1) = face % 2 == 0 ? 1.0 : -1.0;
  axes(forward, 2) = face % 2 == 0 ? 1.0 : -1.0;
  return axes;
}

/// The face that a direction meets.
int face_of(const Vec3<double>& d) {
  const double size[3] = {std::abs(d.x), std::abs(d.y), std::abs(d.z)};
  const double value[3] = {d.x, d.y, d.z};
  int axis = 2;
  if (size[0] > size[axis]) axis = 0;
  if (size[1] > size[axis]) axis = 1;
  return 2 * axis + (value[axis] < 0.0 ? 1 : 0);
}

/// Pixels in the order of tiles of an image.
std::vector<int> pixels_by_tile(int width, int height) {
  std::vector<int> order;
  order.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int top = 0; top < height; top += kTileHeight) {
    for (int left = 0; left < width; left += kTileWidth) {
      for (int row = top; row < std::min(top + kTileHeight, height); ++row) {
        for (int column = left; column < std::min(left + kTileWidth, width); ++column) {
          order.push_back(row * width + column);
        }
      }
    }
  }
  return order;
}

void add(Cover& cover, float x, float y) {
  cover.left = std::min(cover.left, x);
  cover.right = std::max(cover.right, x);
  cover.top = std::min(cover.top, y);
  cover.bottom = std::max(cover.bottom, y);
}

void add_ray(RayTile& tile, const Mat3<double>& axes, const Vec3<double>& along, int pixel) {
  const Vec3<double> d = transpose_times(axes, along);
  const auto x = static_cast<float>(d.x / d.z), y = static_cast<float>(d.y / d.z);
  // Places behind the last ray repeat it, until the next one comes.
  for (int i = tile.count; i < kTilePixels; ++i) {
    tile.x[i] = x;
    tile.y[i] = y;
    tile.axial[i] = static_cast<float>(along.z / norm(along));
    tile.pixel[i] = pixel;
  }
  ++tile.count;
  add(tile.bounds, x, y);
}

}  // namespace

std::vector<RayFace> faces_of(const RayImage& rays) {
  std::array<RayFace, kFaces> faces;
  for (int f = 0; f < kFaces; ++f) faces[static_cast<std::size_t>(f)].axes = axes_of_face(f);
  for (const int pixel : pixels_by_tile(rays.width, rays.height)) {
    const Vec3<double>& along = rays.directions[static_cast<std::size_t>(pixel)];
    RayFace& face = faces[static_cast<std::size_t>(face_of(along))];
    if (face.tiles.empty() || face.tiles.back().count == kTilePixels) {
      face.tiles.push_back({{}, {}, {}, {}, 0, kNowhere});
    }
    add_ray(face.tiles.back(), face.axes, along, pixel);
  }
  std::vector<RayFace> seen;
  std::copy_if(faces.begin(), faces.end(), std::back_inserter(seen),
               [](const RayFace& face) { return !face.tiles.empty(); });
  return seen;
}

double widest_pixel(const RayImage& rays) {
  double widest = 0.0;
  for (int row = 0; row < rays.height; ++row) {
    for (int column = 1; column < rays.width; ++column) {
      const auto at = static_cast<std::size_t>(row * rays.width + column);
      const Vec3<double>&a = rays.directions[at - 1], &b = rays.directions[at];
      widest = std::max(widest, norm(b / norm(b) - a / norm(a)));
    }
  }
  return widest;
}

}  // namespace skybody::render
