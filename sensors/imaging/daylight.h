// Sun, sky and exposure of cameras, as each of them declares it.
#pragma once

#include <skybody/plugin.h>

#include "render/scene.h"

namespace skybody::sensor {

/// The light in which a camera sees, and its exposure.
class Daylight {
 public:
  explicit Daylight(Plugin* owner)
      : sun_(owner, randomizable(reals("sun", "", {-0.48, -0.36, 0.8}, kAny,
                                       "direction towards the sun, W axes, of any length"))),
        sunlight_(owner,
                  randomizable(real("sunlight", "", 0.75, between(0.0, 10.0),
                                    "brightness that the sun adds to a white surface facing it"))),
        ambient_(owner, randomizable(real("ambient", "", 0.3, between(0.0, 10.0),
                                          "brightness of a white surface in shadow"))),
        shadows_(owner, boolean("shadows", true, "shapes shade each other and the ground")),
        exposure_(owner, when_given(real("exposure", "", 1.0, between(0.0, 100.0),
                                         "gain of the brightness of all colours"))) {}

  render::Sky operator()(const EnvView<double>& env) const {
    render::Sky sky;
    const Vec3<double> sun = sun_.vec3(env);
    const double length = norm(sun);
    sky.sun = length > 0.0 ? sun / length : Vec3<double>{0.0, 0.0, 1.0};
    sky.direct = static_cast<float>(sunlight_(env));
    sky.ambient = static_cast<float>(ambient_(env));
    sky.has_shadows = shadows_.value();
    if (exposure_.is_given()) expose(static_cast<float>(exposure_(env)), sky);
    return sky;
  }

 private:
  static void expose(float gain, render::Sky& sky) {
    sky.direct *= gain;
    sky.ambient *= gain;
    for (float& c : sky.zenith) c *= gain;
    for (float& c : sky.horizon) c *= gain;
  }

  RealsParameter sun_;
  RealParameter sunlight_, ambient_;
  BooleanParameter shadows_;
  RealParameter exposure_;
};

}  // namespace skybody::sensor
