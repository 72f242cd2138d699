// The images that a policy sees.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"
#include "learn/hyperparameters.h"
#include "learn/network/image_encoder.h"

namespace skybody::learn {

struct SeenImage {
  std::string column;  ///< name of the observation's column
  ImageFormat format;
};

/// The sizes of the networks of images.
EncoderShape encoder_shape(const Hyperparameters& hyper);

/// The images of the observation, in the order of CompiledScenario::images().
/// @throws Error if an image has other than two or three extents or is too small for the
///         convolutions, its pixels have no range, `shared_policy` is set, or the images of a
///         rollout need more than half of the machine's memory
std::vector<SeenImage> find_images(const CompiledScenario& compiled, const Hyperparameters& hyper);

}  // namespace skybody::learn
