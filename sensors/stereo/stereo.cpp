// A stereo camera on any link: colours of both eyes, disparity and depth as matching would measure
// them, with a rate, a latency and noise.
#include <skybody/plugin.h>

#include <string>

#include "sensors/imaging/color_errors.h"
#include "sensors/imaging/daylight.h"
#include "sensors/imaging/image_sensor.h"
#include "sensors/imaging/pinhole.h"
#include "sensors/stereo/matching.h"

namespace skybody {
namespace {

using stereo::DisparityNoise;
using stereo::Matching;

class Stereo : public sensor::ImageSensor {
 public:
  Stereo()
      : ImageSensor("depth without a match; farther surfaces are not seen", "depth",
                    "left, right, disparity, depth",
                    "images: left, right, disparity, depth; see Outputs") {}

  void configure(const Setup& setup) override {
    check_outputs();
    const render::Pinhole lens = sensor::pinhole(width(), height(), field_of_view_.value());
    focal_ = lens.focal_x;
    is_matched_ = has("disparity") || has("depth");
    // Depths of both eyes, one after another.
    configure_exposures(setup, lens, is_matched_ ? pixels() : 0,
                        {has("left") || has("right"), false});
    for (const std::string& name : outputs()) declare(setup, name);
  }

 private:
  static constexpr std::uint64_t kLeftDraws = 1, kRightDraws = 2, kDisparityDraws = 3;

  int width() const { return static_cast<int>(width_.value()); }
  int height() const { return static_cast<int>(height_.value()); }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
  }

  void declare(const Setup& setup, const std::string& name) {
    const int h = height(), w = width(), of = robot();
    if (name == "left") {
      left_ = setup.image<std::uint8_t>(name, {h, w, 3}, of);
    } else if (name == "right") {
      right_ = setup.image<std::uint8_t>(name, {h, w, 3}, of);
    } else if (name == "disparity") {
      disparity_ = setup.image<float>(name, {h, w}, of, 0.0, w);
    } else if (name == "depth") {
      depth_ = setup.image<float>(name, {h, w}, of, 0.0, max_range());
    } else {
      refuse_output(name);
    }
  }

  void draw(const EnvView<double>& env, const Exposure& exposure) const override {
    auto* const depths = reinterpret_cast<float*>(exposure.memory + renderer().scratch_size());
    const render::Sky sky = daylight_(env);
    const double baseline = baseline_(env);
    render::Eye right = exposure.eye;
    right.position += right.axes.column(0) * baseline;
    see(env, exposure, exposure.eye, sky, {left_, kLeftDraws, depths});
    see(env, exposure, right, sky, {right_, kRightDraws, depths + pixels()});
    if (is_matched_) match(env, baseline, depths);
  }

  /// The images of an eye.
  struct View {
    Image<std::uint8_t> rgb;
    std::uint64_t draws;  ///< key of its noise
    float* depth;         ///< memory for depths, if disparities are wanted
  };
  void see(const EnvView<double>& env, const Exposure& exposure, const render::Eye& eye,
           const render::Sky& sky, const View& view) const {
    render::Frame frame;
    frame.depth = is_matched_ ? view.depth : nullptr;
    frame.rgb = view.rgb.count > 0 ? env.pixels(view.rgb) : nullptr;
    if (frame.depth == nullptr && frame.rgb == nullptr) return;
    renderer().draw(eye, exposure.shapes, sky, exposure.memory, frame);
    if (frame.rgb != nullptr) {
      color_errors_.add_to(frame.rgb, pixels(), env, random(env, view.draws));
    }
  }

  /// @param depths  of the left eye, then of the right one
  void match(const EnvView<double>& env, double baseline, const float* depths) const {
    const Matching matching{width(), height(), focal_ * baseline, nothing()};
    const DisparityNoise noise{disparity_noise_(env), disparity_resolution_(env)};
    float* const disparity = disparity_.count > 0 ? env.pixels(disparity_) : nullptr;
    float* const depth = depth_.count > 0 ? env.pixels(depth_) : nullptr;
    const auto measure = [&](std::size_t i, double normal) {
      const double exact = matching.disparity(depths, depths + pixels(), static_cast<int>(i));
      const double measured = exact > 0.0 ? noise.of(exact, normal, width()) : 0.0;
      if (disparity != nullptr) disparity[i] = static_cast<float>(measured);
      if (depth != nullptr) depth[i] = matching.depth(measured);
    };
    if (noise.deviation > 0.0) {
      sensor::each_normal(random(env, kDisparityDraws), pixels(), measure);
    } else {
      for (std::size_t i = 0; i < pixels(); ++i) measure(i, 0.0);
    }
  }

  IntegerParameter width_{this, integer("width", "pixels", 64, between(1, 4096), "columns")};
  IntegerParameter height_{this, integer("height", "pixels", 64, between(1, 4096), "rows")};
  RealParameter field_of_view_{
      this, real("field_of_view", "rad", 0.5 * kPi, between(0.01, sensor::kWidestPinhole),
                 "horizontal angle of view; pixels are square")};
  RealParameter baseline_{
      this, when_given(real("baseline", "m", 0.1, between(1e-3, 1000.0),
                            "from the left eye to the right one, which is at -y of it"))};
  sensor::Daylight daylight_{this};
  RealParameter disparity_noise_{this,
                                 when_given(real("disparity_noise", "pixels", 0.0, at_least(0.0),
                                                 "standard deviation of disparities"))};
  RealParameter disparity_resolution_{
      this, when_given(real("disparity_resolution", "pixels", 0.0, at_least(0.0),
                            "disparities are multiples of it; 0: as computed"))};
  sensor::ColorErrors color_errors_{this};

  double focal_ = 0.0;       ///< focal length [pixels]
  bool is_matched_ = false;  ///< disparity or depth is an output
  Image<std::uint8_t> left_, right_;
  Image<float> disparity_, depth_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Stereo, "stereo", "1.0.0",
               "Stereo camera: colours of both eyes, disparity and depth with occlusions.");
