// A sensor of images: grey levels, depths and ranges computed from height and physics step, and a
// vector between them.
#include <skybody/plugin.h>

#include <cmath>
#include <cstdint>

namespace {

using namespace skybody;

class ImageSensor : public Sensor {
 public:
  template <class Real>
  struct State {
    Real height;       ///< [m], when the images were drawn
    Word<Real> drawn;  ///< 1 + the physics step then; 0: never
  };

  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    body_ = setup.robots()[robot].first_body;
    setup.period(static_cast<int>(period_.value()));
    const auto height = static_cast<int>(height_.value()), width = static_cast<int>(width_.value());
    grey_ = setup.image<std::uint8_t>("grey", {height, width, 1}, robot);
    setup.channel("height", "m", 1, -kInfinity, kInfinity, robot);
    depth_ = setup.image<std::uint16_t>("depth", {3, 5},
                                        robot);  // 30 bytes: padding precedes the next image
    range_ = setup.image<float>("range", {2, 2}, robot, 0.0, 100.0);
  }

  void sense(const EnvView<double>& env, State<double>& state, Values<double> output) const {
    if (!env.draws_again()) {
      state = {env.body(body_).position.z, env.physics_step() + 1};
      output.set(0, state.height);
    }
    if (state.drawn == 0) return;
    const double height = state.height;
    const auto step = static_cast<int>(state.drawn - 1);
    fill(env, grey_, [&](int k) { return static_cast<std::uint8_t>(step + k); });
    fill(env, depth_, [&](int k) { return static_cast<std::uint16_t>(1000 * height + k); });
    fill(env, range_, [&](int k) { return static_cast<float>(height + k); });
  }

 private:
  template <class T, class Value>
  static void fill(const EnvView<double>& env, const Image<T>& image, Value&& value) {
    T* pixels = env.pixels(image);
    for (int k = 0; k < image.count; ++k) pixels[k] = value(k);
  }

  TextParameter robot_{this, {.name = "robot", .doc = "whose height; empty: the only one"}};
  IntegerParameter period_{this,
                           {.name = "period",
                            .unit = "physics steps",
                            .value = 1,
                            .min = 1,
                            .max = 1000,
                            .doc = "rate"}};
  IntegerParameter height_{
      this,
      {.name = "height", .unit = "pixels", .value = 36, .min = 1, .max = 512, .doc = "of grey"}};
  IntegerParameter width_{
      this,
      {.name = "width", .unit = "pixels", .value = 40, .min = 1, .max = 512, .doc = "of grey"}};
  int body_ = 0;
  Image<std::uint8_t> grey_;
  Image<std::uint16_t> depth_;
  Image<float> range_;
};

}  // namespace

SKYBODY_PLUGIN(ImageSensor, "image_sensor", "1.0.0", "Images of the height and the physics step.");
