// Pictures on the ground, as each sensor that draws declares them.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/scene.h"
#include "render/texture.h"

namespace skybody::sensor {

/// A picture of a file as a texture.
/// @param subject  of messages: the user of the picture
/// @throws std::runtime_error for a file that is none
inline std::unique_ptr<const render::Texture> texture_of(const Setup& setup,
                                                         const std::string& file,
                                                         const std::string& subject) {
  const auto read = [&]() -> const PictureInfo& {
    try {
      return setup.picture(file);
    } catch (const std::exception& error) {
      refuse(subject, ": ", error.what());
    }
  };
  const PictureInfo& picture = read();
  const auto bytes =
      3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  return std::make_unique<const render::Texture>(std::span(picture.rgb, bytes), picture.width,
                                                 picture.height);
}

/// The picture that the ground repeats: one of a list, by its number in each environment.
class GroundTexture {
 public:
  explicit GroundTexture(Plugin* owner)
      : files_(owner, files("ground_textures",
                            "PNG or JPEG files; one of them covers the ground, side by side")),
        number_(owner, when_given(real("ground_texture", "", 0.0, between(0.0, 1000.0),
                                       "which of `ground_textures`, from 0; rounded down"))),
        width_(owner, when_given(real("ground_texture_size", "m", 2.0, between(1e-3, 1e6),
                                      "width of the picture on the ground"))) {}

  /// Reads the pictures. @throws std::runtime_error for files that are none
  void configure(const Setup& setup) {
    textures_.clear();
    const auto count = static_cast<int>(files_.values().size());
    if (count > 0 && number_.value() >= count) {
      refuse("`ground_texture` is ", number_.value(), "; allowed: 0 to ", count - 1,
             ", the numbers of `ground_textures`");
    }
    for (const std::string& file : files_.values()) {
      textures_.push_back(texture_of(setup, file, "`ground_textures`"));
    }
  }

  bool is_on() const { return !textures_.empty(); }

  /// Puts the environment's picture on the ground. Draws beyond the list take its last one.
  void paint(const EnvView<double>& env, render::Paint& paint) const {
    const auto number = static_cast<std::size_t>(std::max(number_(env), 0.0));
    paint.texture = textures_[std::min(number, textures_.size() - 1)].get();
    paint.texture_width = static_cast<float>(width_(env));
  }

 private:
  TextsParameter files_;
  RealParameter number_, width_;
  std::vector<std::unique_ptr<const render::Texture>> textures_;
};

}  // namespace skybody::sensor
