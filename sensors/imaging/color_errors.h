// Errors of colours, as each camera declares them.
#pragma once

#include <skybody/plugin.h>

#include <cstddef>
#include <cstdint>

#include "sensors/imaging/image_noise.h"

namespace skybody::sensor {

/// Noise of red, green and blue bytes.
class ColorErrors {
 public:
  explicit ColorErrors(Plugin* owner)
      : rgb_noise_(owner, when_given(real("rgb_noise", "", 0.0, between(0.0, 1.0),
                                          "standard deviation of colours, as a share of the whole "
                                          "range"))),
        shot_noise_(owner, when_given(real("shot_noise", "", 0.0, between(0.0, 1.0),
                                           "standard deviation of full brightness, as a share of "
                                           "the whole range; grows with the root of brightness"))) {
  }

  void add_to(std::uint8_t* rgb, std::size_t pixels, const EnvView<double>& env,
              const Random<double>& draw) const {
    const ColorNoise noise{rgb_noise_(env), shot_noise_(env)};
    if (noise.is_on()) add_noise(noise, draw, 3 * pixels, rgb);
  }

 private:
  RealParameter rgb_noise_, shot_noise_;
};

}  // namespace skybody::sensor
