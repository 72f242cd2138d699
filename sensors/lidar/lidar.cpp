// A lidar on any link: ranges, points, intensities and ids along rings of rays, or along a list of
// rays, with noise and lost returns.
#include <skybody/plugin.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sensors/imaging/image_noise.h"
#include "sensors/imaging/image_sensor.h"

namespace skybody {
namespace {

/// Most rays of a scan.
constexpr int kMostRays = 1 << 20;

class Lidar : public sensor::ImageSensor {
 public:
  Lidar()
      : ImageSensor("range of a ray without a return; farther surfaces are not seen", "range",
                    "range, points, intensity, instance, class",
                    "images: range, points, intensity, instance, class; see Outputs") {}

  void configure(const Setup& setup) override {
    check_outputs();
    list_rays();
    const std::size_t room = intensity_room();
    render::RayImage view{columns_of_scan_, rings_of_scan_, {}};
    for (const Vec3<double>& d : rays_) view.directions.push_back({-d.y, -d.z, d.x});
    configure_exposures(setup, view, room, {has("intensity"), false});
    for (const std::string& name : outputs()) declare(setup, name);
  }

 private:
  static constexpr std::uint64_t kNoiseDraws = 1, kDropoutDraws = 2;

  std::size_t count() const { return rays_.size(); }

  void list_rays() {
    rays_.clear();
    if (angles_.count() > 0) {
      list_angles();
    } else {
      list_rings();
    }
  }
  /// Rings in the order of `elevations`, each with its rays counter-clockwise.
  void list_rings() {
    const int around = static_cast<int>(columns_.value());
    const double field = field_of_view_.value();
    const bool is_ring = field >= kTwoPi;  // the last ray would coincide with the first
    const int gaps = is_ring ? around : around - 1;
    if (elevations_.count() == 0) {
      refuse("`elevations` is empty: give one or more, such as [0], or `angles`");
    }
    check_count(std::int64_t{around} * elevations_.count());
    const double first = is_ring || around == 1 ? 0.0 : -0.5 * field;
    for (int e = 0; e < elevations_.count(); ++e) {
      for (int i = 0; i < around; ++i) {
        add_ray(gaps > 0 ? first + field * i / gaps : 0.0, elevations_.value(e));
      }
    }
    columns_of_scan_ = around;
    rings_of_scan_ = elevations_.count();
  }
  void list_angles() {
    if (angles_.count() % 2 != 0) {
      refuse("`angles` has ", angles_.count(),
             " values; needed: pairs of azimuth and elevation, one after another");
    }
    check_count(angles_.count() / 2);
    for (int i = 0; i < angles_.count(); i += 2) add_ray(angles_.value(i), angles_.value(i + 1));
    columns_of_scan_ = static_cast<int>(rays_.size());
    rings_of_scan_ = 1;
  }
  static void check_count(std::int64_t rays) {
    if (rays <= kMostRays) return;
    refuse("the scan has ", rays, " rays; allowed: at most ", kMostRays);
  }
  void add_ray(double azimuth, double elevation) {
    const SinCos<double> turn = sincos(azimuth), rise = sincos(elevation);
    rays_.push_back({rise.cos * turn.cos, rise.cos * turn.sin, rise.sin});
  }

  void declare(const Setup& setup, const std::string& name) {
    const int h = rings_of_scan_, w = columns_of_scan_;
    if (name == "range") {
      range_ = setup.image<float>(name, {h, w}, robot(), 0.0, max_range());
    } else if (name == "points") {
      const double reach = axes_.value() == "world" ? kInfinity : max_range();
      points_ = setup.image<float>(name, {h, w, 3}, robot(), -reach, reach);
    } else if (name == "intensity") {
      intensity_ = setup.image<float>(name, {h, w}, robot(), 0.0, 1.0);
    } else if (name == "instance") {
      instance_ = setup.image<std::uint16_t>(name, {h, w}, robot());
    } else if (name == "class") {
      class_ = setup.image<std::uint8_t>(name, {h, w}, robot());
    } else {
      refuse_output(name);
    }
  }

  /// Images that are not outputs, in memory behind the renderer's. Ranges are drawn there, too, if
  /// only points are wanted.
  struct Room {
    float *range, *normal;
    std::uint8_t* rgb;
  };
  std::size_t intensity_room() const {
    const std::size_t floats = has("intensity") ? 4 * count() : count();
    return (floats * sizeof(float) + (has("intensity") ? 3 * count() : 0) + 7) / 8;
  }
  Room room_in(double* memory) const {
    auto* const range = reinterpret_cast<float*>(memory);
    if (!has("intensity")) return {range, nullptr, nullptr};
    float* const normal = range + count();
    return {range, normal, reinterpret_cast<std::uint8_t*>(normal + 3 * count())};
  }

  void draw(const EnvView<double>& env, const Exposure& exposure) const override {
    const Room room = room_in(exposure.memory + renderer().scratch_size());
    render::Frame frame;
    frame.range = range_.count > 0 ? env.pixels(range_) : room.range;
    frame.instance = instance_.count > 0 ? env.pixels(instance_) : nullptr;
    frame.label = class_.count > 0 ? env.pixels(class_) : nullptr;
    frame.normal = room.normal;
    frame.rgb = room.rgb;
    renderer().draw(exposure.eye, exposure.shapes, white_light(), exposure.memory, frame);
    if (intensity_.count > 0) write_intensity(frame, env.pixels(intensity_));
    add_noise(env, frame.range);
    lose(env, frame);
    if (points_.count > 0) write_points(exposure.eye, frame.range, env.pixels(points_));
  }

  /// Light in which colours are those of the surfaces.
  static render::Sky white_light() {
    render::Sky sky;
    sky.direct = 0.0f;
    sky.ambient = 1.0f;
    sky.has_shadows = false;
    sky.zenith = sky.horizon = {0.0f, 0.0f, 0.0f};
    return sky;
  }

  /// Mean of the surface's colour times the cosine of the angle of incidence.
  void write_intensity(const render::Frame& frame, float* intensity) const {
    for (std::size_t i = 0; i < count(); ++i) {
      const Vec3<double>& d = rays_[i];
      const float* n = frame.normal + 3 * i;  // right, down, forward
      const double facing = static_cast<double>(n[0]) * d.y + static_cast<double>(n[1]) * d.z -
                            static_cast<double>(n[2]) * d.x;
      const std::uint8_t* c = frame.rgb + 3 * i;
      const double white = (c[0] + c[1] + c[2]) / (3.0 * 255.0);
      intensity[i] = static_cast<float>(white * std::min(std::max(facing, 0.0), 1.0));
    }
  }

  /// Noise of returns; a ray without one reads exactly max_range.
  void add_noise(const EnvView<double>& env, float* range) const {
    const sensor::DepthNoise noise{noise_(env), noise_share_(env), 0.0, 0.0, nothing()};
    if (noise.is_on()) sensor::add_noise(noise, random(env, kNoiseDraws), count(), range);
  }
  /// Loses returns.
  void lose(const EnvView<double>& env, const render::Frame& frame) const {
    const double probability = ray_dropout_(env);
    if (!(probability > 0.0)) return;
    Random<double> draw = random(env, kDropoutDraws);
    for (std::size_t i = 0; i < count(); ++i) {
      if (!(draw.uniform() < probability)) continue;
      frame.range[i] = nothing();
      if (frame.instance != nullptr) frame.instance[i] = 0;
      if (frame.label != nullptr) frame.label[i] = 0;
      if (intensity_.count > 0) env.pixels(intensity_)[i] = 0.0f;
    }
  }

  void write_points(const render::Eye& eye, const float* range, float* points) const {
    const bool is_world = axes_.value() == "world";
    for (std::size_t i = 0; i < count(); ++i) {
      const Vec3<double>& d = rays_[i];
      Vec3<double> at = d * static_cast<double>(range[i]);
      if (is_world) at = eye.position + eye.axes * Vec3<double>{-at.y, -at.z, at.x};
      const double values[3] = {at.x, at.y, at.z};
      for (std::size_t k = 0; k < 3; ++k) points[3 * i + k] = static_cast<float>(values[k]);
    }
  }

  IntegerParameter columns_{
      this, integer("columns", "", 360, between(1, 65536), "rays per ring, counter-clockwise")};
  RealParameter field_of_view_{this,
                               real("field_of_view", "rad", kTwoPi, between(0.0, kTwoPi),
                                    "angle from the first ray of a ring to the last, forward in "
                                    "the middle; 2 pi: all round, starting forward")};
  RealsParameter elevations_{
      this, list("elevations", "rad", default_elevations(), between(-0.5 * kPi, 0.5 * kPi),
                 "elevation of each ring above the sensor's horizontal plane")};
  RealsParameter angles_{
      this, list("angles", "rad", {}, between(-kTwoPi, kTwoPi),
                 "azimuth and elevation of each ray, in turn, in place of rings: solid-state "
                 "patterns")};
  TextParameter axes_{this, choice("axes", "sensor", {"sensor", "world"}, "axes of `points`")};
  RealParameter noise_{this, when_given(real("noise", "m", 0.0, at_least(0.0),
                                             "standard deviation of a range, at any range"))};
  RealParameter noise_share_{
      this, when_given(real("noise_share", "", 0.0, at_least(0.0),
                            "standard deviation of a range, as a share of it, on top of `noise`"))};
  RealParameter ray_dropout_{this,
                             when_given(real("ray_dropout", "", 0.0, between(0.0, 1.0),
                                             "probability that a ray has no return in a scan"))};

  /// 16 rings from -15 to 15 degrees, 2 degrees apart, from below.
  static std::vector<double> default_elevations() {
    std::vector<double> rings;
    for (int k = 0; k < 16; ++k) rings.push_back((2.0 * k - 15.0) * kPi / 180.0);
    return rings;
  }

  std::vector<Vec3<double>> rays_;  ///< unit vectors, sensor axes (forward, left, up)
  int rings_of_scan_ = 0, columns_of_scan_ = 0;
  Image<float> range_, points_, intensity_;
  Image<std::uint16_t> instance_;
  Image<std::uint8_t> class_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Lidar, "lidar", "1.0.0",
               "Lidar: ranges, points, intensities and ids along rings or lists of rays.");
