#include "learn/common/seen_images.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/simd/isa.h"
#include "core/base/system/error.h"
#include "core/io/files/text.h"
#include "learn/network/policy_network.h"

namespace skybody::learn {
namespace {

constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;

[[noreturn]] void fail(const CompiledScenario& compiled, const ObservationColumn& column,
                       const std::string& what) {
  throw Error("`" + compiled.scenario().name + "` observes the image " + column.name + ", " + what);
}

ImageFormat format_of(const CompiledScenario& compiled, const ObservationColumn& column,
                      double range) {
  const std::vector<int>& shape = column.shape;
  if (shape.size() != 2 && shape.size() != 3) {
    fail(compiled, column,
         "which has " + std::to_string(shape.size()) +
             " extents: allowed are height x width, or height x width x channels");
  }
  ImageFormat format;
  format.type = static_cast<PixelType>(column.type);
  format.height = shape[0];
  format.width = shape[1];
  format.channels = shape.size() == 3 ? shape[2] : 1;
  const bool is_limited = range > 0.0 && column.type != ColumnType::kUint8;
  format.low = static_cast<float>(column.low);
  format.high = static_cast<float>(is_limited ? std::min(range, column.high) : column.high);
  if (!std::isfinite(format.low) || !std::isfinite(format.high) || !(format.low < format.high)) {
    fail(compiled, column,
         "whose pixels are to be scaled from " + format_number(format.low) + " to " +
             format_number(format.high) +
             ": give finite bounds, `low` below `high`, in its entry of `observe`, or a "
             "hyper-parameter cnn_range above `low`");
  }
  return format;
}

void check_encoder(const CompiledScenario& compiled, const ObservationColumn& column,
                   const ImageFormat& format, const Hyperparameters& hyper) {
  try {
    ImageEncoder(format, encoder_shape(hyper), best_isa());
  } catch (const Error& error) {
    fail(compiled, column,
         std::string("too small or large for its network: ") + error.what() +
             "; change the hyper-parameters cnn_kernels, cnn_strides or "
             "cnn_same_padding, or the camera's resolution");
  }
}

void check_memory(const CompiledScenario& compiled, const std::vector<SeenImage>& images,
                  std::int64_t kept) {
  double bytes = 0.0;
  for (const SeenImage& image : images) bytes += image.format.bytes();
  const std::string each = format_number(bytes);
  bytes *= static_cast<double>(kept);
  const double allowed = 0.5 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                         static_cast<double>(sysconf(_SC_PAGESIZE));
  if (bytes <= allowed) return;
  throw Error("`" + compiled.scenario().name + "`: the images of a rollout need " +
              format_number(bytes / kGibibyte) + " GiB (" + std::to_string(kept) +
              " observations with images of " + each +
              " bytes): allowed is half of this machine's memory, " +
              format_number(allowed / kGibibyte) +
              " GiB; take fewer envs or rollout_steps, or smaller images");
}

}  // namespace

std::vector<SeenImage> find_images(const CompiledScenario& compiled, const Hyperparameters& hyper,
                                   std::int64_t kept) {
  std::vector<SeenImage> images;
  for (const ObservedImage& image : compiled.images()) {
    const ObservationColumn& column = compiled.columns()[static_cast<std::size_t>(image.column)];
    if (hyper.shared_policy) {
      fail(compiled, column, "and shared_policy learns from vectors only: set shared_policy=false");
    }
    const ImageFormat format = format_of(compiled, column, hyper.cnn_range);
    check_encoder(compiled, column, format, hyper);
    images.push_back({column.name, format});
  }
  check_memory(compiled, images, kept);
  return images;
}

std::vector<ImageFormat> formats_of(const std::vector<SeenImage>& images) {
  std::vector<ImageFormat> formats;
  for (const SeenImage& image : images) formats.push_back(image.format);
  return formats;
}

void add_images(const std::vector<SeenImage>& images, std::vector<std::vector<PolicyLayer>> layers,
                PolicyFile& file) {
  for (std::size_t k = 0; k < images.size(); ++k) {
    const auto& [column, format] = images[k];
    file.images.push_back({column, format.height, format.width, format.channels,
                           static_cast<double>(format.low), static_cast<double>(format.high),
                           std::move(layers[k])});
  }
}

}  // namespace skybody::learn
