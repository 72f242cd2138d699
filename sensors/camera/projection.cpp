#include "sensors/camera/projection.h"

#include <skybody/plugin.h>

#include <algorithm>
#include <cmath>

#include "sensors/imaging/pinhole.h"

namespace skybody::camera {
namespace {

using render::RayImage;

/// Focal length of a fisheye and of a panorama [pixels per rad].
double angular_focal(const Lens& lens) { return lens.width / lens.field_of_view; }

constexpr int kMostIterations = 50;
/// Steps from the centre of the image to a pixel: an inverse found at one begins at the next.
constexpr int kSteps = 16;
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
  image.directions.reserve(static_cast<std::size_t>(lens.width) *
                           static_cast<std::size_t>(lens.height));
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
  /// By Newton's method from the centre outwards.
  /// @returns false: not found, or the image is folded on the way to p
  bool invert(const Point& image, Point& p) const {
    p = {0.0, 0.0};
    for (int step = 1; step <= kSteps; ++step) {
      const double share = static_cast<double>(step) / kSteps;
      if (!refine({image.x * share, image.y * share}, p)) return false;
    }
    return true;
  }

 private:
  bool refine(const Point& image, Point& p) const {
    for (int i = 0; i < kMostIterations; ++i) {
      const double s = p.x * p.x + p.y * p.y, r = radial(s);
      const Point aside = tangential(p, s);
      const Point error{p.x * r + aside.x - image.x, p.y * r + aside.y - image.y};
      // The Jacobian, which is symmetric.
      const double slope = 2.0 * (k1 + s * (2.0 * k2 + s * 3.0 * k3));
      const double xx = r + p.x * p.x * slope + 2.0 * p1 * p.y + 6.0 * p2 * p.x;
      const double yy = r + p.y * p.y * slope + 6.0 * p1 * p.y + 2.0 * p2 * p.x;
      const double xy = p.x * p.y * slope + 2.0 * p1 * p.x + 2.0 * p2 * p.y;
      const double determinant = xx * yy - xy * xy;
      if (!(determinant > 0.0 && xx > 0.0)) return false;
      if (std::abs(error.x) + std::abs(error.y) < kFound) return true;
      p.x -= (yy * error.x - xy * error.y) / determinant;
      p.y -= (xx * error.y - xy * error.x) / determinant;
    }
    return false;
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
  /// By Newton's method from the centre outwards. Corners beyond the whole sphere look backwards.
  bool invert(double image, double& angle) const {
    angle = 0.0;
    for (int step = 1; step <= kSteps; ++step) {
      if (!refine(image * step / kSteps, angle)) return false;
    }
    return true;
  }

 private:
  bool refine(double image, double& angle) const {
    for (int i = 0; i < kMostIterations; ++i) {
      const double error = radius(angle) - image;
      if (!(slope(angle) > 0.0)) return false;
      if (std::abs(error) < kFound) return true;
      angle -= error / slope(angle);
    }
    return false;
  }
};

}  // namespace

RayImage distorted(const Lens& lens) {
  const Brown brown(lens);
  const double focal = sensor::pinhole_focal(lens.width, lens.field_of_view);
  return rays_of(lens, focal, [&](double u, double v, int column, int row) {
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
