// Frames per second of Embree on one thread, on the scene and with the eyes of bench_render: depth
// along the optical axis and instances.
//
//   bench_peer_embree [--size N] [--frames N] [--rounds N] [--rays 8|16|stream]
//                     [--shapes triangles|quads|native]
//
// triangles: 12 a box, 1,024 a sphere or capsule; quads: 6 and 512; native: boxes as quads, spheres
// and capsules as Embree's points and round curves. Rays go in packets of 8 or 16, 4 x 2 or
// 4 x 4 pixels each, or as one stream a frame. The hierarchy is built once, at high quality: the
// shapes do not move.
//
// Prints one line of JSON: processor time; the share of pixels whose instance or depth (by more
// than 1 %) differs from ours, which must be below 2 %.
#include <embree3/rtcore.h>
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "research/bench/render/scene.h"

namespace skybody {
namespace {

using render::PlacedShape;
using render::Solid;

constexpr float kFarthest = 1000.0f;  // [m]
constexpr int kColumns = 32;          // of the faces of a sphere

struct Options {
  int size = 64;
  int frames = 2000;
  int rounds = 5;
  std::string shapes = "triangles";
  std::string rays = "16";
};

struct Images {
  std::vector<float> depth;
  std::vector<std::uint16_t> instance;
};

/// Corners of a geometry, and corner numbers of its faces.
struct Faces {
  std::vector<Vec3<double>> corners;
  std::vector<unsigned> numbers;
};

/// Twelve triangles or six quadrilaterals of a box.
Faces faces_of_box(const Vec3<double>& half, bool triangles) {
  Faces faces;
  for (unsigned i = 0; i < 8; ++i) {
    faces.corners.push_back(
        {i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
  }
  for (const auto& [a, b, c, d] : {std::array<unsigned, 4>{0, 2, 3, 1},
                                   {4, 5, 7, 6},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}}) {
    if (triangles) {
      faces.numbers.insert(faces.numbers.end(), {a, b, c, a, c, d});
    } else {
      faces.numbers.insert(faces.numbers.end(), {a, b, c, d});
    }
  }
  return faces;
}

/// 1,024 triangles or 512 quads of a sphere, with a cylinder of half a length between its halves.
Faces faces_of_capsule(double radius, double half, bool triangles) {
  Faces faces;
  const int rings = triangles ? 17 : 16;  // the first and the last ring of quads are triangles
  for (int r = 0; r <= rings; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const SinCos<double> fall = sincos(kPi * r / rings);
      const SinCos<double> turn = sincos(kTwoPi * c / kColumns);
      faces.corners.push_back({radius * fall.sin * turn.cos, radius * fall.sin * turn.sin,
                               radius * fall.cos + (2 * r <= rings ? half : -half)});
    }
  }
  const auto number = [](int r, int c) {
    return static_cast<unsigned>(r * kColumns + c % kColumns);
  };
  for (int r = 0; r < rings; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const unsigned a = number(r, c), b = number(r, c + 1);
      const unsigned d = number(r + 1, c), e = number(r + 1, c + 1);
      if (!triangles) {
        faces.numbers.insert(faces.numbers.end(), {a, d, e, b});
        continue;
      }
      if (r > 0) faces.numbers.insert(faces.numbers.end(), {a, d, b});
      if (r + 1 < rings) faces.numbers.insert(faces.numbers.end(), {b, d, e});
    }
  }
  return faces;
}

Vec3<double> placed(const PlacedShape& shape, const Vec3<double>& point) {
  return shape.position + shape.axes * point;
}

/// Embree's scene; a geometry's number is its shape's index.
class EmbreeScene {
 public:
  EmbreeScene(const std::vector<PlacedShape>& shapes, const std::string& by)
      : triangles_(by == "triangles"), native_(by == "native") {
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    for (const PlacedShape& shape : shapes) add(shape);
    rtcCommitScene(scene_);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) {
      throw std::runtime_error("Embree refuses the scene");
    }
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  RTCScene get() const { return scene_; }

 private:
  void add(const PlacedShape& shape) {
    const double radius = shape.half.x, half = shape.half.z;
    if (shape.solid == Solid::kPlane) return add(shape, faces_of_box({1e3, 1e3, 0.0}, triangles_));
    if (shape.solid == Solid::kBox) return add(shape, faces_of_box(shape.half, triangles_));
    const bool is_ball = shape.solid == Solid::kSphere;
    if (!native_) return add(shape, faces_of_capsule(radius, is_ball ? 0.0 : half, triangles_));
    if (is_ball) return add_round(shape, RTC_GEOMETRY_TYPE_SPHERE_POINT, {0.0});
    add_round(shape, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE, {-half, half});
  }
  void add(const PlacedShape& shape, const Faces& faces) {
    const RTCGeometry geometry =
        rtcNewGeometry(device_, triangles_ ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
    const std::size_t width = triangles_ ? 3 : 4;
    float* to =
        memory<float>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3, faces.corners.size());
    for (const Vec3<double>& corner : faces.corners) {
      const Vec3<double> at = placed(shape, corner);
      for (const double x : {at.x, at.y, at.z}) *to++ = static_cast<float>(x);
    }
    std::copy(faces.numbers.begin(), faces.numbers.end(),
              memory<unsigned>(geometry, RTC_BUFFER_TYPE_INDEX,
                               triangles_ ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT4, width,
                               faces.numbers.size() / width));
    attach(geometry);
  }
  /// A sphere at each of some heights; with two of them a capsule.
  void add_round(const PlacedShape& shape, RTCGeometryType type,
                 const std::vector<double>& heights) {
    const RTCGeometry geometry = rtcNewGeometry(device_, type);
    float* to =
        memory<float>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 4, heights.size());
    for (const double height : heights) {
      const Vec3<double> at = placed(shape, {0.0, 0.0, height});
      for (const double x : {at.x, at.y, at.z, shape.half.x}) *to++ = static_cast<float>(x);
    }
    if (heights.size() > 1) {
      *memory<unsigned>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, 1, 1) = 0;
    }
    attach(geometry);
  }
  template <class Number>
  static Number* memory(RTCGeometry geometry, RTCBufferType type, RTCFormat format,
                        std::size_t width, std::size_t count) {
    return static_cast<Number*>(
        rtcSetNewGeometryBuffer(geometry, type, 0, format, width * sizeof(Number), count));
  }
  void attach(RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }

  RTCDevice device_ = rtcNewDevice("threads=1,set_affinity=0");
  RTCScene scene_ = rtcNewScene(device_);
  bool triangles_, native_;
};

/// Pixels in the order of their rays, and their directions in camera axes (forward: 1).
struct Pixels {
  std::vector<int> index;
  std::vector<float> x, y;
};

/// Pixels by blocks of 4 columns; `size` is a multiple of 4.
Pixels pixels_of(int size, int block_rows) {
  Pixels pixels;
  const float half = 0.5f * static_cast<float>(size);
  for (int block = 0; block < size * size / (4 * block_rows); ++block) {
    const int row = block_rows * (block / (size / 4)), column = 4 * (block % (size / 4));
    for (int k = 0; k < 4 * block_rows; ++k) {
      const int at_row = row + k / 4, at_column = column + k % 4;
      pixels.index.push_back(at_row * size + at_column);
      pixels.x.push_back((static_cast<float>(at_column) + 0.5f - half) / half);
      pixels.y.push_back((static_cast<float>(at_row) + 0.5f - half) / half);
    }
  }
  return pixels;
}

/// An eye in single precision.
struct Origin {
  explicit Origin(const render::Eye& eye)
      : at{static_cast<float>(eye.position.x), static_cast<float>(eye.position.y),
           static_cast<float>(eye.position.z)} {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        axes[row][column] = static_cast<float>(eye.axes(row, column));
      }
    }
  }
  float along(int axis, float x, float y) const {
    return axes[axis][0] * x + axes[axis][1] * y + axes[axis][2];
  }
  float at[3];
  float axes[3][3];
};

void write_pixel(int pixel, float depth, unsigned geometry, Images& images) {
  const bool is_hit = geometry != RTC_INVALID_GEOMETRY_ID && depth < kFarthest;
  const auto at = static_cast<std::size_t>(pixel);
  images.depth[at] = is_hit ? depth : kFarthest;
  images.instance[at] = static_cast<std::uint16_t>(is_hit ? geometry + 1 : 0);
}

RTCIntersectContext coherent() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRayHit8* rays) {
  rtcIntersect8(valid, scene, context, rays);
}
void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRayHit16* rays) {
  rtcIntersect16(valid, scene, context, rays);
}

/// A frame by packets of `kCount` rays.
template <class Packet, int kCount>
void draw_packets(RTCScene scene, const Origin& origin, const Pixels& pixels, Images& images) {
  alignas(64) int valid[kCount];
  std::fill(valid, valid + kCount, -1);
  RTCIntersectContext context = coherent();
  Packet packet;
  for (std::size_t first = 0; first < pixels.index.size(); first += kCount) {
    const float *x = &pixels.x[first], *y = &pixels.y[first];
    for (int k = 0; k < kCount; ++k) {
      packet.ray.org_x[k] = origin.at[0];
      packet.ray.org_y[k] = origin.at[1];
      packet.ray.org_z[k] = origin.at[2];
      packet.ray.dir_x[k] = origin.along(0, x[k], y[k]);
      packet.ray.dir_y[k] = origin.along(1, x[k], y[k]);
      packet.ray.dir_z[k] = origin.along(2, x[k], y[k]);
      packet.ray.tnear[k] = packet.ray.time[k] = 0.0f;
      packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
      packet.ray.mask[k] = ~0u;
      packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    intersect(valid, scene, &context, &packet);
    for (int k = 0; k < kCount; ++k) {
      write_pixel(pixels.index[first + static_cast<std::size_t>(k)], packet.ray.tfar[k],
                  packet.hit.geomID[k], images);
    }
  }
}

/// A frame as one stream.
void draw_stream(RTCScene scene, const Origin& origin, const Pixels& pixels, Images& images) {
  static std::vector<RTCRayHit> rays(pixels.index.size());
  for (std::size_t k = 0; k < rays.size(); ++k) {
    RTCRay& ray = rays[k].ray;
    ray.org_x = origin.at[0];
    ray.org_y = origin.at[1];
    ray.org_z = origin.at[2];
    ray.dir_x = origin.along(0, pixels.x[k], pixels.y[k]);
    ray.dir_y = origin.along(1, pixels.x[k], pixels.y[k]);
    ray.dir_z = origin.along(2, pixels.x[k], pixels.y[k]);
    ray.tnear = ray.time = 0.0f;
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
    ray.flags = 0;
    rays[k].hit.geomID = rays[k].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context = coherent();
  rtcIntersect1M(scene, &context, rays.data(), static_cast<unsigned>(rays.size()),
                 sizeof(RTCRayHit));
  for (std::size_t k = 0; k < rays.size(); ++k) {
    write_pixel(pixels.index[k], rays[k].ray.tfar, rays[k].hit.geomID, images);
  }
}

using Draw = void (*)(RTCScene, const Origin&, const Pixels&, Images&);

Draw draw_by(const std::string& rays) {
  if (rays == "8") return draw_packets<RTCRayHit8, 8>;
  if (rays == "16") return draw_packets<RTCRayHit16, 16>;
  return draw_stream;
}

/// Share of pixels that differ from ours, over some frames.
template <class DrawFrame>
double difference(const bench::Scene& scene, const Options& options, Images& images,
                  const DrawFrame& draw) {
  const render::Renderer renderer(bench::pinhole_of(options.size),
                                  {static_cast<int>(scene.shapes.size())}, kFarthest,
                                  render::kernels_of(best_isa()));
  std::vector<double> scratch(renderer.scratch_size());
  Images ours = images;
  render::Frame frame;
  frame.depth = ours.depth.data();
  frame.instance = ours.instance.data();
  std::size_t differ = 0, all = 0;
  for (int i = 0; i < 3000; i += 500) {
    draw(i);
    renderer.draw(bench::eye_at(i), scene.shapes, {}, scratch.data(), frame);
    for (std::size_t k = 0; k < ours.depth.size(); ++k, ++all) {
      const bool is_near = std::abs(ours.depth[k] - images.depth[k]) <= 0.01f * ours.depth[k];
      differ += ours.instance[k] != images.instance[k] || !is_near;
    }
  }
  return static_cast<double>(differ) / static_cast<double>(all);
}

Options read_options(int count, char** words) {
  Options options;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string name = words[i];
    if (name == "--size") options.size = std::stoi(words[i + 1]);
    if (name == "--frames") options.frames = std::stoi(words[i + 1]);
    if (name == "--rounds") options.rounds = std::stoi(words[i + 1]);
    if (name == "--shapes") options.shapes = words[i + 1];
    if (name == "--rays") options.rays = words[i + 1];
  }
  return options;
}

int run(const Options& options) {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);  // as Embree's manual recommends
  _mm_setcsr(_mm_getcsr() | 0x0040);           // denormals are zero
  const bench::Scene scene;
  const EmbreeScene embree(scene.shapes, options.shapes);
  const Pixels pixels = pixels_of(options.size, options.rays == "8" ? 2 : 4);
  Images images{std::vector<float>(pixels.index.size()),
                std::vector<std::uint16_t>(pixels.index.size())};
  const Draw draw_frame = draw_by(options.rays);
  const auto draw = [&](int i) {
    draw_frame(embree.get(), Origin(bench::eye_at(i)), pixels, images);
  };
  const double differ = difference(scene, options, images, draw);
  if (differ > 0.02) throw std::runtime_error("Embree's images differ from ours");
  double least = 1e9;
  for (int round = 0; round < options.rounds; ++round) {
    const double start = bench::processor_time();
    for (int i = 0; i < options.frames; ++i) draw(i);
    least = std::min(least, bench::processor_time() - start);
  }
  std::printf(
      "{\"version\": \"%s\", \"shapes\": \"%s\", \"rays\": \"%s\", \"frames_per_second\": %.0f, "
      "\"differ\": %.3g}\n",
      RTC_VERSION_STRING, options.shapes.c_str(), options.rays.c_str(), options.frames / least,
      differ);
  return 0;
}

}  // namespace
}  // namespace skybody

int main(int count, char** words) {
  try {
    return skybody::run(skybody::read_options(count, words));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_peer_embree: %s\n", error.what());
    return 1;
  }
}
