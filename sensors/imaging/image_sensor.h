// Exposures of the world's shapes at a rate, with a latency: the base of cameras and lidars.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "render/renderer.h"
#include "sensors/common/mount.h"
#include "sensors/imaging/frame_clock.h"
#include "sensors/imaging/ground_texture.h"
#include "sensors/imaging/world_shapes.h"

namespace skybody::sensor {

/// A sensor that draws images of an environment as it was at an exposure. The state keeps the
/// moments of exposures, never pixels: those that have not arrived, and that of the present image.
///
/// A moment holds the poses of all shapes, and the sensor's own randomizable values.
class ImageSensor : public Sensor {
 public:
  template <class Real>
  struct State {
    Word<Real> drawn;   ///< 1 + the physics step at which the image was drawn; 0: there is none
    Word<Real> stream;  ///< EnvView::stream_env() then
  };

  void sense(const EnvView<double>& env, State<double>& state, Values<double>,
             Values<double> buffer) const {
    double* const moment = env.scratch_block();
    if (env.draws_again()) {
      if (state.drawn == 0) return;
      recall(kShown, buffer, moment);
      expose(env, state, moment);
      return;
    }
    const auto now = static_cast<std::int64_t>(env.physics_step());
    const std::int64_t exposure = clock_.exposure_at(now), arrival = clock_.arrival_at(now);
    const bool is_kept = exposure >= 0 && clock_.latency > 0;
    const bool is_drawn = is_read(env, now) && (now == 0 || arrival >= 0);
    if (is_kept || (is_drawn && (now == 0 || clock_.latency == 0))) capture(env, moment);
    if (is_kept) keep(moment, place_of(exposure), buffer);
    if (!is_drawn) return;
    if (now > 0 && clock_.latency > 0) recall(place_of(arrival), buffer, moment);
    keep(moment, kShown, buffer);
    state = {static_cast<std::uint64_t>(now) + 1, env.stream_env()};
    expose(env, state, moment);
  }

 protected:
  /// An exposure to draw.
  struct Exposure {
    render::Eye eye;
    std::span<const render::PlacedShape> shapes;
    const double* moment;  ///< for world_shapes()
    double* memory;        ///< of the renderer, and the room asked for in configure_exposures()
  };

  /// @param range_doc  meaning of `max_range`
  /// @param kinds      names of all images, for messages
  ImageSensor(const char* range_doc, const char* standard, const char* kinds,
              const char* outputs_doc)
      : kinds_(kinds),
        outputs_(this, {.name = "outputs", .values = {standard}, .doc = outputs_doc}),
        max_range_(this, real("max_range", "m", 100.0, between(1e-3, 1e6), range_doc)) {}

  /// Call in configure(), before the images are declared.
  /// @param view  render::Pinhole or render::RayImage
  /// @param room  doubles of memory beside the renderer's
  /// @param draws  colours, of which textures are a part; velocities of bodies
  /// @throws std::runtime_error for times that cannot be, and scenes that cannot be drawn
  template <class View>
  void configure_exposures(const Setup& setup, const View& view, std::size_t room,
                           const WorldShapes::Draws& draws) {
    mount_.configure(setup);
    set_clock(setup);
    if (draws.has_colors) ground_texture_.configure(setup);
    shapes_.emplace(setup, mount_.body(), sees_own_robot_.value() ? -1 : mount_.robot(),
                    ground_.value(), draws);
    render::Capacity most = shapes_->capacity();
    if (has_painted_ground()) ++most.textured;
    renderer_.emplace(view, most, max_range_.value(), render::kernels_of(best_isa()));
    list_own_values();
    const auto of_shapes = static_cast<std::size_t>(shapes_->most()) * kShapeSize;
    setup.scratch_block(moment_size() + params_size_ +
                        static_cast<int>(of_shapes + renderer_->scratch_size() + room));
    setup.buffer((clock_.latency > 0 ? 1 + clock_.most_kept() : 1) * moment_size());
  }

  /// Whether the scenario asks for an image.
  bool has(const std::string& output) const {
    const std::vector<std::string>& names = outputs_.values();
    return std::find(names.begin(), names.end(), output) != names.end();
  }
  const std::vector<std::string>& outputs() const { return outputs_.values(); }
  /// @throws std::runtime_error if an image is named twice or none is named
  void check_outputs() const {
    const std::vector<std::string>& names = outputs_.values();
    if (names.empty()) refuse("`outputs` is empty: name one or more of ", kinds_);
    for (const std::string& name : names) {
      if (std::count(names.begin(), names.end(), name) > 1) {
        refuse("`outputs` names ", name, " twice: name each image once");
      }
    }
  }
  [[noreturn]] void refuse_output(const std::string& name) const {
    refuse("`outputs` has an unknown image ", name, ": choose from ", kinds_);
  }

  int robot() const { return mount_.robot(); }
  double max_range() const { return max_range_.value(); }
  float nothing() const { return static_cast<float>(max_range_.value()); }  ///< its pixels
  const render::Renderer& renderer() const { return *renderer_; }
  const WorldShapes& world_shapes() const { return *shapes_; }

  /// Draws the images of an exposure.
  /// @param env  its parameters and random numbers alone
  virtual void draw(const EnvView<double>& env, const Exposure& exposure) const = 0;

 private:
  static_assert(std::is_trivially_copyable_v<render::PlacedShape>, "lies in scratch memory");
  static constexpr std::size_t kShapeSize = (sizeof(render::PlacedShape) + 7) / 8;
  /// Most exposures that a latency keeps.
  static constexpr int kMostKept = 64;
  /// Place of the present image's moment in the buffer.
  static constexpr int kShown = 0;

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

  /// Whether the image is read before the next one arrives.
  bool is_read(const EnvView<double>& env, std::int64_t now) const {
    const std::uint64_t rest = env.steps_to_read();
    if (rest == SKYBODY_NEVER_READ) return false;
    return now == 0 || rest < static_cast<std::uint64_t>(clock_.period);
  }

  bool has_painted_ground() const { return ground_.value() && ground_texture_.is_on(); }

  /// The values of each environment that belong to this sensor.
  void list_own_values() {
    own_values_.clear();
    params_size_ = 0;
    for (const Parameter* parameter : parameters()) {
      for (int k = 0; k < parameter->env_param_count(); ++k) {
        own_values_.push_back(parameter->env_param() + k);
        params_size_ = std::max(params_size_, own_values_.back() + 1);
      }
    }
  }

  int moment_size() const { return shapes_->moment_size() + static_cast<int>(own_values_.size()); }
  void capture(const EnvView<double>& env, double* moment) const {
    shapes_->capture(env, moment);
    double* own = moment + shapes_->moment_size();
    for (const int value : own_values_) *own++ = env.param(value);
  }
  int place_of(std::int64_t exposure) const {
    return (1 + static_cast<int>(exposure % clock_.most_kept())) * moment_size();
  }
  void keep(const double* moment, int place, const Values<double>& buffer) const {
    for (int k = 0; k < moment_size(); ++k) buffer.set(place + k, moment[k]);
  }
  void recall(int place, const Values<double>& buffer, double* moment) const {
    for (int k = 0; k < moment_size(); ++k) moment[k] = buffer[place + k];
  }

  /// @param moment  followed by memory for the drawing
  void expose(const EnvView<double>& live, const State<double>& state, double* moment) const {
    double* const params = moment + moment_size();
    const double* own = moment + shapes_->moment_size();
    for (const int value : own_values_) params[value] = *own++;
    // One lane with all that a drawing reads, as it was when the image was drawn first.
    const std::uint64_t key[] = {live.seed(), state.stream}, episode = live.episode(),
                        step = state.drawn - 1;
    SkybodyLanes lanes{};
    lanes.lanes = lanes.active = 1;
    lanes.key = key;
    lanes.episode = &episode;
    lanes.physics_step = &step;
    lanes.params = params;
    lanes.images = live.pixels(Image<unsigned char>{});
    const EnvView<double> env(lanes, 1, 0, true);

    double* const shapes = params + params_size_;
    Exposure exposure;
    WorldShapes::mount(moment, exposure.eye.position, exposure.eye.axes);
    exposure.eye.position += exposure.eye.axes * mount_.point(env);
    exposure.eye.axes = exposure.eye.axes * to_mat3(mount_.rotation(env)) * from_camera();
    auto* const placed = reinterpret_cast<render::PlacedShape*>(shapes);
    exposure.shapes = shapes_->place(moment, placed);
    if (has_painted_ground()) ground_texture_.paint(env, placed->paint);  // the first shape
    exposure.moment = moment;
    exposure.memory = shapes + static_cast<std::size_t>(shapes_->most()) * kShapeSize;
    draw(env, exposure);
  }

  /// (forward, left, up) from camera axes.
  static Mat3<double> from_camera() {
    Mat3<double> axes{};
    axes(0, 2) = 1.0;
    axes(1, 0) = axes(2, 1) = -1.0;
    return axes;
  }

  const char* kinds_;
  Mount mount_{this};
  TextsParameter outputs_;
  RealParameter max_range_;
  BooleanParameter ground_{this, boolean("ground", true, "the plane z = 0 of W is seen")};
  GroundTexture ground_texture_{this};
  BooleanParameter sees_own_robot_{
      this, boolean("sees_own_robot", false, "the sensor's own robot is seen")};
  IntegerParameter period_{
      this, integer("period", "physics steps", 1, between(1, 1000000), "interval of exposures")};
  IntegerParameter phase_{this, integer("phase", "physics steps", 0, between(0, 1000000),
                                        "step of the first exposure, below `period`")};
  IntegerParameter latency_{this, integer("latency", "physics steps", 0, between(0, 1000),
                                          "time from an exposure to its image")};

  FrameClock clock_;
  std::optional<WorldShapes> shapes_;
  std::optional<render::Renderer> renderer_;
  std::vector<int> own_values_;  ///< EnvParams of this sensor
  int params_size_ = 0;          ///< up to the last of them
};

}  // namespace skybody::sensor
