#include "sensors/camera/projection.h"

#include <skybody/plugin.h>

#include <algorithm>
#include <cmath>

namespace skybody::camera {
namespace {

using render::RayImage;

constexpr int kMostIterations = 200;
/// Error of an inverse that counts as found, in focal lengths: far below a pixel.
constexpr double kFound = 1e-10;

[[noreturn]] void refuse_fold(int column, int row) {
  refuse("`distortion` folds the image: no direction has pixel (", column, ", ", row,
         "); give smaller coefficients or a smaller `field_of_view`");
}

/// Calls direction(u, v, column, row) for each pixel.
template <class Direction>
RayImage rays_of(const Lens& lens, double focal, Direction&& direction) {
  RayImage image{lens.width, lens.height, {}};
  for (int row = 0; row < lens.height; ++row) {
    for (int column = 0; column < lens.width; ++column) {
      const double u = (column + 0.5 - 0.5 * lens.width) / focal;
      const double v = (row + 0.5 - 0.5 * lens.height) / focal;
      image.directions.push_back(direction(u, v, column, row));
    }
  }
  return image;
}

double coefficient(const Lens& lens, std::size_t k) {
  return k < lens.distortion.size() ? lens.distortion[k] : 0.0;
}

/// Image coordinates.
struct Point {
  double x, y;
};

/// The model of Brown and Conrady.
struct Brown {
  double k1, k2, p1, p2, k3;

  explicit Brown(const Lens& lens)
      : k1(coefficient(lens, 0)),
        k2(coefficient(lens, 1)),
        p1(coefficient(lens, 2)),
        p2(coefficient(lens, 3)),
        k3(coefficient(lens, 4)) {}

  double radial(double square) const { return 1.0 + square * (k1 + square * (k2 + square * k3)); }
  Point tangential(const Point& p, double square) const {
    return {2.0 * p1 * p.x * p.y + p2 * (square + 2.0 * p.x * p.x),
            p1 * (square + 2.0 * p.y * p.y) + 2.0 * p2 * p.x * p.y};
  }
  /// By fixed-point iteration; @returns the last iterate and whether it is found.
  bool invert(const Point& image, Point& p) const {
    p = image;
    for (int i = 0; i < kMostIterations; ++i) {
      const double square = p.x * p.x + p.y * p.y;
      const Point aside = tangential(p, square);
      const Point error{p.x * radial(square) + aside.x - image.x,
                        p.y * radial(square) + aside.y - image.y};
      if (std::abs(error.x) + std::abs(error.y) < kFound) return radial_slope(square) > 0.0;
      if (!(radial(square) > 0.0)) return false;
      p = {(image.x - aside.x) / radial(square), (image.y - aside.y) / radial(square)};
    }
    return false;
  }
  /// d(r radial) / dr: positive where radii do not fold.
  double radial_slope(double square) const {
    return 1.0 + square * (3.0 * k1 + square * (5.0 * k2 + square * 7.0 * k3));
  }
};

/// The radius of a fisheye's image, in focal lengths, and its slope.
struct Kannala {
  double k[4];

  explicit Kannala(const Lens& lens)
      : k{coefficient(lens, 0), coefficient(lens, 1), coefficient(lens, 2), coefficient(lens, 3)} {}

  double radius(double angle) const {
    const double s = angle * angle;
    return angle * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
  }
  double slope(double angle) const {
    const double s = angle * angle;
    return 1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * (7.0 * k[2] + s * 9.0 * k[3])));
  }
  /// By Newton's method. Corners beyond the whole sphere look backwards.
  bool invert(double image, double& angle) const {
    angle = image;
    for (int i = 0; i < kMostIterations; ++i) {
      const double error = radius(angle) - image;
      if (std::abs(error) < kFound) return slope(angle) > 0.0;
      if (!(slope(angle) > 0.0)) return false;
      angle -= error / slope(angle);
    }
    return false;
  }
};

}  // namespace

double pinhole_focal(const Lens& lens) {
  const SinCos<double> half = sincos(0.5 * lens.field_of_view);
  return 0.5 * lens.width * half.cos / half.sin;
}

double angular_focal(const Lens& lens) { return lens.width / lens.field_of_view; }

render::Pinhole pinhole(const Lens& lens) {
  render::Pinhole camera;
  camera.width = lens.width;
  camera.height = lens.height;
  camera.center_x = 0.5 * camera.width;
  camera.center_y = 0.5 * camera.height;
  camera.focal_x = camera.focal_y = pinhole_focal(lens);
  return camera;
}

RayImage distorted(const Lens& lens) {
  const Brown brown(lens);
  return rays_of(lens, pinhole_focal(lens), [&](double u, double v, int column, int row) {
    Point p{};
    if (!brown.invert({u, v}, p)) refuse_fold(column, row);
    return Vec3<double>{p.x, p.y, 1.0};
  });
}

RayImage fisheye(const Lens& lens) {
  const Kannala kannala(lens);
  return rays_of(lens, angular_focal(lens), [&](double u, double v, int column, int row) {
    const double radius = std::sqrt(u * u + v * v);
    if (radius == 0.0) return Vec3<double>{0.0, 0.0, 1.0};
    double angle = 0.0;
    if (!kannala.invert(radius, angle)) refuse_fold(column, row);
    const SinCos<double> turn = sincos(std::min(angle, kPi));
    return Vec3<double>{turn.sin * u / radius, turn.sin * v / radius, turn.cos};
  });
}

RayImage panorama(const Lens& lens) {
  return rays_of(lens, angular_focal(lens), [](double u, double v, int, int) {
    const SinCos<double> azimuth = sincos(u), fall = sincos(v);
    return Vec3<double>{fall.cos * azimuth.sin, fall.sin, fall.cos * azimuth.cos};
  });
}

}  // namespace skybody::camera
