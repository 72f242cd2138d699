// The renderer, for pictures and films.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/base/system/error.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "render/mesh.h"
#include "render/smooth_renderer.h"

namespace skybody::python {
namespace {

using render::Mesh;
using render::PlacedShape;
using render::SmoothRenderer;
using render::Solid;

using Corners = nb::ndarray<const float, nb::shape<-1, 3, 3>, nb::c_contig, nb::device::cpu>;
using Doubles1 = nb::ndarray<const double, nb::shape<3>, nb::c_contig, nb::device::cpu>;
using Doubles2 = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Doubles3 = nb::ndarray<const double, nb::shape<-1, 3, 3>, nb::c_contig, nb::device::cpu>;
using Axes = nb::ndarray<const double, nb::shape<3, 3>, nb::c_contig, nb::device::cpu>;
using Floats2 = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Floats4 = nb::ndarray<const float, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using Floats1 = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Marks = nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rgb = nb::ndarray<std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;

Vec3<double> vec3(const double* v) { return {v[0], v[1], v[2]}; }

Mat3<double> mat3(const double* v) {
  Mat3<double> m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m(i, j) = v[3 * i + j];
  }
  return m;
}

/// A camera of films and its memory for each thread that draws at the same time.
class Picture {
 public:
  Picture(int width, int height, double focal, int shapes, int triangles, double farthest)
      : renderer_({width, height, focal, focal, 0.5 * width, 0.5 * height}, {shapes, triangles},
                  farthest, render::kernels_of(best_isa())),
        most_shapes_(shapes),
        most_triangles_(triangles) {}

  void draw(const render::Eye& eye, const std::vector<PlacedShape>& shapes,
            const std::vector<render::LinePoint>& lines, const render::Sky& sky,
            std::uint8_t* rgb) {
    check(shapes);
    std::unique_ptr<SmoothRenderer::Scratch> scratch = take();
    renderer_.draw(eye, shapes, sky, *scratch, rgb, lines);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(scratch));
  }

  int width() const { return renderer_.width(); }
  int height() const { return renderer_.height(); }

 private:
  void check(const std::vector<PlacedShape>& shapes) const {
    int triangles = 0;
    for (const PlacedShape& shape : shapes) {
      if (shape.solid == Solid::kMesh) triangles += shape.mesh->count();
    }
    if (static_cast<int>(shapes.size()) <= most_shapes_ && triangles <= most_triangles_) return;
    throw Error("too many shapes or triangles for the picture");
  }

  std::unique_ptr<SmoothRenderer::Scratch> take() {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<SmoothRenderer::Scratch> scratch = std::move(free_.back());
        free_.pop_back();
        return scratch;
      }
    }
    return std::make_unique<SmoothRenderer::Scratch>(renderer_);
  }

  SmoothRenderer renderer_;
  int most_shapes_, most_triangles_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<SmoothRenderer::Scratch>> free_;
};

struct Shapes {
  Numbers kinds;
  Doubles2 positions;
  Doubles3 axes;
  Doubles2 halves;
  Floats2 colors, checkers;
  Floats1 squares;
  Marks shadows;
};

std::vector<PlacedShape> placed(const Shapes& given, const std::vector<const Mesh*>& meshes) {
  const std::size_t count = given.kinds.shape(0);
  for (const std::size_t other :
       {given.positions.shape(0), given.axes.shape(0), given.halves.shape(0), given.colors.shape(0),
        given.checkers.shape(0), given.squares.shape(0), given.shadows.shape(0), meshes.size()}) {
    if (other != count) throw nb::value_error("the arrays of shapes differ in length");
  }
  std::vector<PlacedShape> shapes(count);
  for (std::size_t i = 0; i < count; ++i) {
    PlacedShape& shape = shapes[i];
    const std::int32_t kind = given.kinds.data()[i];
    if (kind < 0 || kind > static_cast<int>(Solid::kMesh)) throw nb::value_error("no such kind");
    shape.solid = static_cast<Solid>(kind);
    if (shape.solid == Solid::kMesh && meshes[i] == nullptr) throw nb::value_error("no mesh");
    shape.mesh = meshes[i];
    shape.position = vec3(given.positions.data() + 3 * i);
    shape.axes = mat3(given.axes.data() + 9 * i);
    shape.half = vec3(given.halves.data() + 3 * i);
    shape.instance = 1;
    shape.paint.square = given.squares.data()[i];
    std::copy_n(given.colors.data() + 3 * i, 3, shape.paint.color.begin());
    std::copy_n(given.checkers.data() + 3 * i, 3, shape.paint.checker.begin());
    shape.casts_shadow = given.shadows.data()[i] != 0;
  }
  return shapes;
}

struct Lines {
  Doubles2 points;
  Floats1 widths;
  Floats4 colors;
  Marks firsts;
};

std::vector<render::LinePoint> points_of(const Lines& given) {
  const std::size_t count = given.points.shape(0);
  if (given.widths.shape(0) != count || given.colors.shape(0) != count ||
      given.firsts.shape(0) != count) {
    throw nb::value_error("the arrays of lines differ in length");
  }
  std::vector<render::LinePoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float* const color = given.colors.data() + 4 * i;
    points[i] = {vec3(given.points.data() + 3 * i),
                 {color[0], color[1], color[2]},
                 color[3],
                 given.widths.data()[i],
                 given.firsts.data()[i] != 0};
  }
  return points;
}

void draw_picture(Picture& self, const Doubles1& position, const Axes& axes, const Numbers& kinds,
                  const Doubles2& positions, const Doubles3& shape_axes, const Doubles2& halves,
                  const Floats2& colors, const Floats2& checkers, const Floats1& squares,
                  const Marks& shadows, const nb::typed<nb::list, nb::object>& meshes,
                  const Doubles2& line_points, const Floats1& line_widths,
                  const Floats4& line_colors, const Marks& line_firsts, const render::Sky& sky,
                  const Rgb& rgb) {
  std::vector<const Mesh*> used;
  for (const nb::handle mesh : meshes) {
    used.push_back(mesh.is_none() ? nullptr : nb::cast<const Mesh*>(mesh));
  }
  const std::vector<PlacedShape> shapes =
      placed({kinds, positions, shape_axes, halves, colors, checkers, squares, shadows}, used);
  const std::vector<render::LinePoint> lines =
      points_of({line_points, line_widths, line_colors, line_firsts});
  if (rgb.shape(0) != static_cast<std::size_t>(self.height()) ||
      rgb.shape(1) != static_cast<std::size_t>(self.width())) {
    throw nb::value_error("`rgb` has another size than the picture");
  }
  const render::Eye eye{vec3(position.data()), mat3(axes.data())};
  std::uint8_t* const pixels = rgb.data();
  const nb::gil_scoped_release other_threads_run;
  self.draw(eye, shapes, lines, sky, pixels);
}

void make_sky(render::Sky* self, const Doubles1& sun, float direct, float ambient,
              const std::array<float, 3>& zenith, const std::array<float, 3>& horizon, float haze) {
  if (!(haze >= 0.0f)) throw nb::value_error("`haze` is a depth of 0 m or more");
  new (self) render::Sky{.sun = vec3(sun.data()),
                         .direct = direct,
                         .ambient = ambient,
                         .zenith = zenith,
                         .horizon = horizon,
                         .haze = haze};
}

void make_picture(Picture* self, int width, int height, double focal, int shapes, int triangles,
                  double farthest) {
  constexpr int kMostShapes = 20000, kMostTriangles = 60000;  // numbered by 16 bits
  if (width < 1 || height < 1 || width > 4096 || height > 4096 || !(focal > 0.0) ||
      !(farthest > 0.0) || shapes < 0 || triangles < 0) {
    throw nb::value_error("a picture has 1 to 4096 pixels each way and lengths above 0");
  }
  if (shapes > kMostShapes || triangles > kMostTriangles) {
    throw nb::value_error("a picture has at most 20000 shapes and 60000 triangles");
  }
  new (self) Picture(width, height, focal, shapes, triangles, farthest);
}

}  // namespace

void bind_render(nb::module_& m) {
  nb::class_<Mesh>(m, "Mesh", "Triangles, to draw.")
      .def(
          "__init__",
          [](Mesh* self, const Corners& corners, const Doubles1& scale) {
            new (self) Mesh({corners.data(), corners.size()}, vec3(scale.data()));
          },
          nb::arg("corners"), nb::arg("scale"),
          "corners: of each triangle [m], (triangles, 3, 3) float32\n"
          "scale: factors of x, y, z, (3,)")
      .def_prop_ro("count", &Mesh::count, "Number of triangles.");
  nb::class_<render::Sky>(m, "Sky", "Light and air of a picture.")
      .def("__init__", &make_sky, nb::arg("sun"), nb::arg("direct"), nb::arg("ambient"),
           nb::arg("zenith"), nb::arg("horizon"), nb::arg("haze"),
           "sun: unit vector towards it, W, (3,)\n"
           "direct, ambient: brightness of a white surface that faces the sun, and in shadow\n"
           "zenith, horizon: colours of the sky: red, green, blue in [0, 1]\n"
           "haze: depth at which surfaces have half the horizon's colour [m]; 0: none");
  nb::class_<Picture>(m, "Renderer", "Draws coloured pictures with shadows, without jagged edges.")
      .def("__init__", &make_picture, nb::arg("width"), nb::arg("height"), nb::arg("focal"),
           nb::arg("shapes"), nb::arg("triangles"), nb::arg("farthest"),
           "width, height, focal: of the picture and its focal length [pixels]\n"
           "shapes, triangles: most of a picture\n"
           "farthest: distance of surfaces that are not seen [m]")
      .def_prop_ro("width", &Picture::width, "[pixels]")
      .def_prop_ro("height", &Picture::height, "[pixels]")
      .def("draw", &draw_picture, nb::arg("position"), nb::arg("axes"), nb::arg("kinds"),
           nb::arg("positions"), nb::arg("shape_axes"), nb::arg("halves"), nb::arg("colors"),
           nb::arg("checkers"), nb::arg("squares"), nb::arg("shadows"), nb::arg("meshes"),
           nb::arg("line_points"), nb::arg("line_widths"), nb::arg("line_colors"),
           nb::arg("line_firsts"), nb::arg("sky"), nb::arg("rgb"),
           "Draws n shapes, and lines through m points; other Python threads run meanwhile.\n\n"
           "position: of the eye, W [m], (3,)\n"
           "axes: W from right, down, forward, (3, 3)\n"
           "kinds: 0 box, 1 sphere, 2 cylinder, 3 capsule, 4 half-space below z = 0, 5 mesh, (n,) "
           "int32\n"
           "positions: W [m], (n, 3)\n"
           "shape_axes: W from the shape, (n, 3, 3)\n"
           "halves: half the edges of a box; radius in x, half the length in z [m], (n, 3)\n"
           "colors: red, green, blue in [0, 1], (n, 3) float32\n"
           "checkers: colours of every other square of a plane, (n, 3) float32\n"
           "squares: their edges [m]; 0: none, (n,) float32\n"
           "shadows: 1 if a shape casts a shadow, (n,) uint8\n"
           "meshes: a Mesh of each shape of kind 5, else None\n"
           "line_points: W [m], (m, 3)\n"
           "line_widths: [pixels], (m,) float32\n"
           "line_colors: red, green, blue, opacity in [0, 1], (m, 4) float32\n"
           "line_firsts: 1 if no line leads to a point from the one before, (m,) uint8\n"
           "sky: a Sky\n"
           "rgb: the result, (height, width, 3) uint8");
}

}  // namespace skybody::python
