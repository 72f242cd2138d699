#include "core/io/files/picture_reader.h"

#include <png.h>
#include <turbojpeg.h>

#include <memory>

#include "core/io/files/file.h"

namespace skybody {
namespace {

std::string too_large(long width, long height) {
  const std::string most = std::to_string(kLargestPicture);
  return "is " + std::to_string(width) + " x " + std::to_string(height) +
         " pixels; allowed: at most " + most + " x " + most;
}

/// Makes room for the pixels. @returns the problem, or an empty text
std::string set_size(long width, long height, Picture& picture) {
  if (width > kLargestPicture || height > kLargestPicture) return too_large(width, height);
  picture.width = static_cast<int>(width);
  picture.height = static_cast<int>(height);
  picture.rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  return "";
}

bool is_png(const std::string& bytes) { return bytes.rfind("\x89PNG\r\n\x1a\n", 0) == 0; }
bool is_jpeg(const std::string& bytes) { return bytes.rfind("\xff\xd8\xff", 0) == 0; }

/// libpng's state of a picture, freed by the destructor.
class PngImage {
 public:
  PngImage() { image_.version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(&image_); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;

  std::string read(const std::string& bytes, Picture& picture) {
    if (png_image_begin_read_from_memory(&image_, bytes.data(), bytes.size()) == 0) {
      return problem();
    }
    const std::string size = set_size(image_.width, image_.height, picture);
    if (!size.empty()) return size;
    // With the opacity, which would otherwise be blended with a background.
    image_.format = PNG_FORMAT_RGBA;
    std::vector<std::uint8_t> rgba(PNG_IMAGE_SIZE(image_));
    if (png_image_finish_read(&image_, nullptr, rgba.data(), 0, nullptr) == 0) return problem();
    for (std::size_t i = 0; i < picture.rgb.size() / 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) picture.rgb[3 * i + k] = rgba[4 * i + k];
    }
    return "";
  }

 private:
  std::string problem() const { return std::string("is a broken PNG: ") + image_.message; }

  png_image image_{};
};

std::string read_jpeg(const std::string& bytes, Picture& picture) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  const auto problem = [&] {
    return std::string("is a broken JPEG: ") + tjGetErrorStr2(decoder.get());
  };
  if (!decoder) return "cannot be read: no memory for its decoder";
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto size = static_cast<unsigned long>(bytes.size());
  int width = 0, height = 0, sampling = 0, colors = 0;
  if (tjDecompressHeader3(decoder.get(), data, size, &width, &height, &sampling, &colors) != 0) {
    return problem();
  }
  const std::string wrong_size = set_size(width, height, picture);
  if (!wrong_size.empty()) return wrong_size;
  // The accurate transform has the same bits with and without vector instructions.
  const int flags = TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  if (tjDecompress2(decoder.get(), data, size, picture.rgb.data(), width, 0, height, TJPF_RGB,
                    flags) != 0) {
    return problem();
  }
  return "";
}

}  // namespace

std::string read_picture(const std::string& file, Picture& picture) {
  std::string bytes;
  std::string problem = read_regular_file(file, kLargestPictureFile, bytes);
  if (problem.empty()) {
    problem = is_png(bytes)    ? PngImage().read(bytes, picture)
              : is_jpeg(bytes) ? read_jpeg(bytes, picture)
                               : "is neither PNG nor JPEG";
  }
  if (!problem.empty()) picture = {};
  return problem;
}

}  // namespace skybody
