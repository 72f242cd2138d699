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

/// The images of the observation, in the order of CompiledScenario::images().
/// @throws Error if an image has other than two or three extents or is too small for the
///         convolutions, its pixels have no range, `shared_policy` is set, or the images of a
///         rollout need more than half of the machine's memory
/// @param kept  images of each kind that are in memory at once
std::vector<SeenImage> find_images(const CompiledScenario& compiled, const Hyperparameters& hyper,
                                   std::int64_t kept);
std::vector<ImageFormat> formats_of(const std::vector<SeenImage>& images);

/// Adds the images to a policy file.
/// @param layers  of each image's network
void add_images(const std::vector<SeenImage>& images, std::vector<std::vector<PolicyLayer>> layers,
                PolicyFile& file);

}  // namespace skybody::learn
