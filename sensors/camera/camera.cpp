// A camera on any link: depth, range, ids, classes, normals, colours and optical flow, through a
// pinhole, a distorting lens, a fisheye or as a panorama, with a rate, a latency and noise.
#include <skybody/plugin.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sensors/camera/optical_flow.h"
#include "sensors/camera/projection.h"
#include "sensors/imaging/color_errors.h"
#include "sensors/imaging/daylight.h"
#include "sensors/imaging/image_noise.h"
#include "sensors/imaging/image_sensor.h"
#include "sensors/imaging/pinhole.h"

namespace skybody {
namespace {

using camera::Lens;
using sensor::DepthNoise;
using sensor::EdgeHoles;

class Camera : public sensor::ImageSensor {
 public:
  Camera()
      : ImageSensor("depth and range of nothing; farther surfaces are not seen", "depth",
                    "depth, range, instance, class, normal, rgb, flow",
                    "images: depth, range, instance, class, normal, rgb, flow; see Outputs") {}

  void configure(const Setup& setup) override {
    check_outputs();
    check_combinations();
    // Bytes of holes, and shapes and depths of flow: one after another.
    const std::size_t room = hole_room() + (has("flow") ? pixels() + 1 : 0);
    const Lens lens = checked_lens();
    const sensor::WorldShapes::Draws draws{has("rgb"), has("flow")};
    if (projection_.value() == "fisheye") {
      configure_exposures(setup, camera::fisheye(lens), room, draws);
    } else if (projection_.value() == "panorama") {
      configure_exposures(setup, camera::panorama(lens), room, draws);
    } else if (!lens.distortion.empty()) {
      configure_exposures(setup, camera::distorted(lens), room, draws);
    } else {
      lens_ = sensor::pinhole(lens.width, lens.height, lens.field_of_view);
      configure_exposures(setup, lens_, room, draws);
    }
    for (const std::string& name : outputs()) declare(setup, name);
  }

 private:
  static constexpr std::uint64_t kDepthDraws = 1, kRangeDraws = 2, kHoleDraws = 3, kRgbDraws = 4;

  int width() const { return static_cast<int>(width_.value()); }
  int height() const { return static_cast<int>(height_.value()); }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
  }
  std::size_t hole_room() const { return edge_holes_.is_given() ? pixels() / 8 + 1 : 0; }
  bool is_panorama() const { return projection_.value() == "panorama"; }
  Lens checked_lens() const {
    Lens lens{width(), height(), field_of_view_.value(), {}};
    for (int k = 0; k < distortion_.count(); ++k) lens.distortion.push_back(distortion_.value(k));
    const bool is_pinhole = projection_.value() == "pinhole";
    if (is_pinhole && lens.field_of_view > sensor::kWidestPinhole) {
      refuse("`field_of_view` is ", lens.field_of_view, "; allowed: 0.01 to ",
             sensor::kWidestPinhole,
             " rad for `projection: pinhole`; give a smaller one, or `projection: fisheye`");
    }
    if (is_panorama() && lens.field_of_view * height() > kPi * width()) {
      refuse("`height` is ", height(), "; allowed: up to ",
             static_cast<int>(kPi * width() / lens.field_of_view),
             " for this `width` and `field_of_view`: a panorama ends at the zenith");
    }
    const std::size_t most = is_pinhole ? 5 : is_panorama() ? 0 : 4;
    if (lens.distortion.size() > most) {
      refuse("`distortion` has ", distortion_.count(),
             " values; allowed for `projection: ", projection_.value(), "`: at most ", most);
    }
    return lens;
  }

  void check_combinations() const {
    if (is_panorama() && has("depth")) {
      refuse("`outputs` names depth, and a panorama has no optical axis: name range");
    }
    if (has("flow") && (projection_.value() != "pinhole" || distortion_.count() > 0)) {
      refuse(
          "`outputs` names flow, which a pinhole without distortion has alone: leave out "
          "`projection` and `distortion`");
    }
    if (edge_holes_.is_given() && !has("depth") && !has("range")) {
      refuse("`edge_holes` needs depth or range in `outputs`");
    }
  }

  void declare(const Setup& setup, const std::string& name) {
    const int h = height(), w = width(), of = robot();
    if (name == "depth") {
      depth_ =
          setup.image<float>(name, {h, w}, of, has_axis_behind() ? -max_range() : 0.0, max_range());
    } else if (name == "range") {
      range_ = setup.image<float>(name, {h, w}, of, 0.0, max_range());
    } else if (name == "instance") {
      instance_ = setup.image<std::uint16_t>(name, {h, w}, of);
    } else if (name == "class") {
      class_ = setup.image<std::uint8_t>(name, {h, w}, of);
    } else if (name == "normal") {
      normal_ = setup.image<float>(name, {h, w, 3}, of, -1.0, 1.0);
    } else if (name == "rgb") {
      rgb_ = setup.image<std::uint8_t>(name, {h, w, 3}, of);
    } else if (name == "flow") {
      flow_ = setup.image<float>(name, {h, w, 2}, of);
    } else {
      refuse_output(name);
    }
  }
  /// Whether pixels look behind the camera, where depths are negative.
  bool has_axis_behind() const { return projection_.value() == "fisheye"; }

  void draw(const EnvView<double>& env, const Exposure& exposure) const override {
    render::Frame frame = frame_of(env);
    double* const room = exposure.memory + renderer().scratch_size();
    auto* const is_hole = reinterpret_cast<std::uint8_t*>(room);
    if (flow_.count > 0) {
      frame.shape = reinterpret_cast<std::int32_t*>(room + hole_room());
      if (frame.depth == nullptr) frame.depth = reinterpret_cast<float*>(frame.shape + pixels());
    }
    renderer().draw(exposure.eye, exposure.shapes, daylight_(env), exposure.memory, frame);
    if (flow_.count > 0) write_flow(exposure, frame, env.pixels(flow_));
    const double holes = edge_holes_.is_given() ? edge_holes_(env) : 0.0;
    if (holes > 0.0) {
      EdgeHoles(width(), height())
          .find(range_.count > 0 ? frame.range : frame.depth, holes, random(env, kHoleDraws),
                is_hole);
    }
    add_errors(env, depth_.count > 0 ? frame.depth : nullptr, kDepthDraws,
               holes > 0.0 ? is_hole : nullptr);
    add_errors(env, frame.range, kRangeDraws, holes > 0.0 ? is_hole : nullptr);
    if (frame.rgb != nullptr) {
      color_errors_.add_to(frame.rgb, pixels(), env, random(env, kRgbDraws));
    }
  }

  void write_flow(const Exposure& exposure, const render::Frame& frame, float* flow) const {
    const camera::FlowOfBodies flows(exposure.eye, world_shapes().motion(exposure.moment, 0));
    std::size_t i = 0;
    for (int row = 0; row < lens_.height; ++row) {
      for (int column = 0; column < lens_.width; ++column, ++i) {
        const Vec3<double> along{(column + 0.5 - lens_.center_x) / lens_.focal_x,
                                 (row + 0.5 - lens_.center_y) / lens_.focal_y, 1.0};
        const std::int32_t shape = frame.shape[i];
        const int body = shape < 0 ? -1 : exposure.shapes[static_cast<std::size_t>(shape)].body;
        const camera::ImageVelocity seen =
            shape < 0  ? flows.of_infinity(along)
            : body < 0 ? flows.of_world(along, static_cast<double>(frame.depth[i]))
                       : flows.of_body(along, static_cast<double>(frame.depth[i]),
                                       world_shapes().motion(exposure.moment, body));
        flow[2 * i] = static_cast<float>(lens_.focal_x * seen.x);
        flow[2 * i + 1] = static_cast<float>(lens_.focal_y * seen.y);
      }
    }
  }

  /// @param is_hole  null: there are none
  void add_errors(const EnvView<double>& env, float* image, std::uint64_t draws,
                  const std::uint8_t* is_hole) const {
    if (image == nullptr) return;
    const Vec3<double> deviation = depth_noise_.vec3(env);
    const DepthNoise noise{deviation.x, deviation.y, deviation.z, depth_resolution_(env),
                           nothing()};
    if (noise.is_on()) sensor::add_noise(noise, random(env, draws), pixels(), image);
    if (is_hole != nullptr) {
      EdgeHoles(width(), height()).fill(is_hole, nothing(), image);
    }
  }

  render::Frame frame_of(const EnvView<double>& env) const {
    const auto pixels_of = [&env](const auto& image) {
      return image.count > 0 ? env.pixels(image) : nullptr;
    };
    return {pixels_of(depth_), pixels_of(range_),  pixels_of(instance_),
            pixels_of(class_), pixels_of(normal_), pixels_of(rgb_)};
  }

  IntegerParameter width_{this, integer("width", "pixels", 64, between(1, 4096), "columns")};
  IntegerParameter height_{this, integer("height", "pixels", 64, between(1, 4096), "rows")};
  RealParameter field_of_view_{
      this, real("field_of_view", "rad", 0.5 * kPi, between(0.01, kTwoPi),
                 "horizontal angle of view; pixels are square; pinhole: up to 3")};
  TextParameter projection_{this,
                            choice("projection", "pinhole", {"pinhole", "fisheye", "panorama"},
                                   "from directions to pixels; see Equations")};
  RealsParameter distortion_{this,
                             list("distortion", "", {}, between(-100.0, 100.0),
                                  "pinhole: k1, k2, p1, p2, k3; fisheye: k1 to k4; see Equations")};
  sensor::Daylight daylight_{this};
  RealsParameter depth_noise_{
      this, when_given(reals("depth_noise", "m, 1, 1/m", {0.0, 0.0, 0.0}, at_least(0.0),
                             "a, b, c: the standard deviation of a depth or range d is "
                             "a + b d + c d^2"))};
  RealParameter depth_resolution_{
      this, when_given(real("depth_resolution", "m", 0.0, at_least(0.0),
                            "depths and ranges are multiples of it; 0: as computed"))};
  RealParameter edge_holes_{
      this, when_given(real("edge_holes", "", 0.0, between(0.0, 1.0),
                            "probability that a pixel beside a jump of depth of 5 % reads "
                            "`max_range`"))};
  sensor::ColorErrors color_errors_{this};

  render::Pinhole lens_;  ///< without distortion
  Image<float> depth_, range_, normal_, flow_;
  Image<std::uint16_t> instance_;
  Image<std::uint8_t> class_, rgb_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Camera, "camera", "1.2.0",
               "Camera: depth, range, ids, classes, normals, colours and flow.");
