// A pinhole camera on any link: depth, range, ids, classes, normals and colours, with a rate and a
// latency.
#include <skybody/plugin.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "sensors/camera/frame_clock.h"
#include "sensors/camera/world_shapes.h"
#include "sensors/common/mount.h"

namespace skybody {
namespace {

/// Most exposures that a latency keeps.
constexpr int kMostKept = 64;

class Camera : public Sensor {
 public:
  void configure(const Setup& setup) override {
    mount_.configure(setup);
    set_clock(setup);
    shapes_.emplace(setup, mount_.body(), sees_own_robot_.value() ? -1 : mount_.robot(),
                    ground_.value());
    renderer_.emplace(pinhole(), shapes_->most(), max_range_.value(),
                      render::kernels_of(best_isa()));
    const auto of_shapes = static_cast<std::size_t>(shapes_->most()) * kShapeSize;
    setup.scratch(shapes_->moment_size() + static_cast<int>(of_shapes + renderer_->scratch_size()));
    declare_images(setup, mount_.robot());
  }

  void sense(const EnvView<double>& env, State<double>&, Values<double>,
             Values<double> buffer) const {
    const auto now = static_cast<std::int64_t>(env.physics_step());
    double* const moment = env.scratch_block();
    const std::int64_t exposure = clock_.exposure_at(now), arrival = clock_.arrival_at(now);
    const bool is_kept = exposure >= 0 && clock_.latency > 0;
    const bool is_drawn = is_read(env, now) && (now == 0 || arrival >= 0);
    if (is_kept || (is_drawn && (now == 0 || clock_.latency == 0))) shapes_->capture(env, moment);
    if (is_kept) keep(moment, exposure, buffer);
    if (!is_drawn) return;
    if (now > 0 && clock_.latency > 0) recall(arrival, buffer, moment);
    draw(env, moment);
  }

 private:
  static_assert(std::is_trivially_copyable_v<render::PlacedShape>, "lies in scratch memory");
  static constexpr std::size_t kShapeSize = (sizeof(render::PlacedShape) + 7) / 8;

  void set_clock(const Setup& setup) {
    clock_ = {period_.value(), phase_.value(), latency_.value()};
    if (clock_.phase >= clock_.period) {
      refuse("`phase` is ", clock_.phase, "; allowed: 0 to ", clock_.period - 1,
             ", less than `period`");
    }
    if (clock_.most_kept() > kMostKept) {
      refuse("`latency` is ", clock_.latency / clock_.period, " periods; allowed: less than ",
             kMostKept, ": give a shorter `latency` or a longer `period`");
    }
    if (clock_.is_regular()) setup.period(static_cast<int>(clock_.period));
  }

  render::Pinhole pinhole() const {
    const SinCos<double> half = sincos(0.5 * field_of_view_.value());
    render::Pinhole camera;
    camera.width = static_cast<int>(width_.value());
    camera.height = static_cast<int>(height_.value());
    camera.center_x = 0.5 * camera.width;
    camera.center_y = 0.5 * camera.height;
    camera.focal_x = camera.focal_y = camera.center_x * half.cos / half.sin;
    return camera;
  }

  void declare_images(const Setup& setup, int robot) {
    if (clock_.latency > 0) setup.buffer(clock_.most_kept() * shapes_->moment_size());
    const int height = renderer_->camera().height, width = renderer_->camera().width;
    const double far = max_range_.value();
    if (outputs_.values().empty()) {
      refuse("`outputs` is empty: name one or more of ", kOutputs);
    }
    for (const std::string& name : outputs_.values()) {
      if (std::count(outputs_.values().begin(), outputs_.values().end(), name) > 1) {
        refuse("`outputs` names ", name, " twice: name each image once");
      }
      if (name == "depth") {
        depth_ = setup.image<float>(name, {height, width}, robot, 0.0, far);
      } else if (name == "range") {
        range_ = setup.image<float>(name, {height, width}, robot, 0.0, far);
      } else if (name == "instance") {
        instance_ = setup.image<std::uint16_t>(name, {height, width}, robot);
      } else if (name == "class") {
        class_ = setup.image<std::uint8_t>(name, {height, width}, robot);
      } else if (name == "normal") {
        normal_ = setup.image<float>(name, {height, width, 3}, robot, -1.0, 1.0);
      } else if (name == "rgb") {
        rgb_ = setup.image<std::uint8_t>(name, {height, width, 3}, robot);
      } else {
        refuse("`outputs` has an unknown image ", name, ": choose from ", kOutputs);
      }
    }
  }

  /// Whether the image is read before the next one arrives.
  bool is_read(const EnvView<double>& env, std::int64_t now) const {
    const std::uint64_t rest = env.steps_to_read();
    if (rest == SKYBODY_NEVER_READ) return false;
    return now == 0 || rest < static_cast<std::uint64_t>(clock_.period);
  }

  int place_of(std::int64_t exposure) const {
    return static_cast<int>(exposure % clock_.most_kept()) * shapes_->moment_size();
  }
  void keep(const double* moment, std::int64_t exposure, const Values<double>& buffer) const {
    const int first = place_of(exposure);
    for (int k = 0; k < shapes_->moment_size(); ++k) buffer.set(first + k, moment[k]);
  }
  void recall(std::int64_t exposure, const Values<double>& buffer, double* moment) const {
    const int first = place_of(exposure);
    for (int k = 0; k < shapes_->moment_size(); ++k) moment[k] = buffer[first + k];
  }

  void draw(const EnvView<double>& env, double* moment) const {
    double* const shapes = moment + shapes_->moment_size();
    double* const rest = shapes + static_cast<std::size_t>(shapes_->most()) * kShapeSize;
    render::Eye eye;
    WorldShapes::mount(moment, eye.position, eye.axes);
    eye.position += eye.axes * mount_.point(env);
    eye.axes = eye.axes * to_mat3(mount_.rotation(env)) * from_camera();
    renderer_->draw(eye, shapes_->place(moment, reinterpret_cast<render::PlacedShape*>(shapes)),
                    sky_of(env), rest, frame_of(env));
  }

  /// (forward, left, up) from camera axes.
  static Mat3<double> from_camera() {
    Mat3<double> axes{};
    axes(0, 2) = 1.0;
    axes(1, 0) = axes(2, 1) = -1.0;
    return axes;
  }

  render::Sky sky_of(const EnvView<double>& env) const {
    render::Sky sky;
    const Vec3<double> sun = sun_.vec3(env);
    const double length = norm(sun);
    sky.sun = length > 0.0 ? sun / length : Vec3<double>{0.0, 0.0, 1.0};
    sky.direct = static_cast<float>(sunlight_(env));
    sky.ambient = static_cast<float>(ambient_(env));
    sky.has_shadows = shadows_.value();
    return sky;
  }

  render::Frame frame_of(const EnvView<double>& env) const {
    const auto pixels = [&env](const auto& image) {
      return image.count > 0 ? env.pixels(image) : nullptr;
    };
    return {pixels(depth_), pixels(range_),  pixels(instance_),
            pixels(class_), pixels(normal_), pixels(rgb_)};
  }

  static constexpr const char* kOutputs = "depth, range, instance, class, normal, rgb";

  sensor::Mount mount_{this};
  IntegerParameter width_{this, integer("width", "pixels", 64, between(1, 4096), "columns")};
  IntegerParameter height_{this, integer("height", "pixels", 64, between(1, 4096), "rows")};
  RealParameter field_of_view_{this, real("field_of_view", "rad", 0.5 * kPi, between(0.01, 3.0),
                                          "horizontal angle of view; pixels are square")};
  TextsParameter outputs_{
      this,
      {.name = "outputs",
       .values = {"depth"},
       .doc = "images: depth, range, instance, class, normal, rgb; see Outputs"}};
  RealParameter max_range_{this, real("max_range", "m", 100.0, between(1e-3, 1e6),
                                      "depth and range of nothing; farther surfaces are not seen")};
  BooleanParameter ground_{this, boolean("ground", true, "the plane z = 0 of W is seen")};
  BooleanParameter sees_own_robot_{
      this, boolean("sees_own_robot", false, "the camera's own robot is seen")};
  IntegerParameter period_{
      this, integer("period", "physics steps", 1, between(1, 1000000), "interval of exposures")};
  IntegerParameter phase_{this, integer("phase", "physics steps", 0, between(0, 1000000),
                                        "step of the first exposure, below `period`")};
  IntegerParameter latency_{this, integer("latency", "physics steps", 0, between(0, 1000),
                                          "time from an exposure to its image")};
  RealsParameter sun_{this,
                      randomizable(reals("sun", "", {-0.48, -0.36, 0.8}, kAny,
                                         "direction towards the sun, W axes, of any length"))};
  RealParameter sunlight_{
      this, randomizable(real("sunlight", "", 0.75, between(0.0, 10.0),
                              "brightness that the sun adds to a white surface facing it"))};
  RealParameter ambient_{this, randomizable(real("ambient", "", 0.3, between(0.0, 10.0),
                                                 "brightness of a white surface in shadow"))};
  BooleanParameter shadows_{this,
                            boolean("shadows", true, "shapes shade each other and the ground")};

  FrameClock clock_;
  std::optional<WorldShapes> shapes_;
  std::optional<render::Renderer> renderer_;
  Image<float> depth_, range_, normal_;
  Image<std::uint16_t> instance_;
  Image<std::uint8_t> class_, rgb_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Camera, "camera", "1.0.0",
               "Pinhole camera: depth, range, ids, classes, normals and colours.");
