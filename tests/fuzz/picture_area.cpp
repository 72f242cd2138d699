// Pictures for textures: PNG and JPEG files.
#include <png.h>
#include <turbojpeg.h>

#include <algorithm>

#include "core/io/files/picture_reader.h"
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 12, kHeight = 7;

std::vector<std::uint8_t> pixels(std::size_t bytes_per_pixel) {
  std::vector<std::uint8_t> bytes(bytes_per_pixel * kWidth * kHeight);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(37 * i);
  return bytes;
}

std::string png(std::uint32_t format, std::size_t bytes_per_pixel) {
  const std::vector<std::uint8_t> picture = pixels(bytes_per_pixel);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = kWidth;
  image.height = kHeight;
  image.format = format;
  std::string bytes(4096, '\0');
  png_alloc_size_t size = bytes.size();
  png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.data(), 0, nullptr);
  bytes.resize(size);
  return bytes;
}

std::string jpeg(int sampling, int flags) {
  const std::vector<std::uint8_t> picture = pixels(3);
  const tjhandle encoder = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(encoder, picture.data(), kWidth, 0, kHeight, TJPF_RGB, &data, &size, sampling, 80,
              flags);
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  tjFree(data);
  tjDestroy(encoder);
  return bytes;
}

class PictureArea : public Area {
 public:
  PictureArea() {
    material_.seeds = {png(PNG_FORMAT_RGB, 3),
                       png(PNG_FORMAT_RGBA, 4),
                       png(PNG_FORMAT_GRAY, 1),
                       jpeg(TJSAMP_444, 0),
                       jpeg(TJSAMP_420, 0),
                       jpeg(TJSAMP_GRAY, 0),
                       jpeg(TJSAMP_420, TJFLAG_PROGRESSIVE)};
  }

  void begin(const fs::path& folder) override { file_ = folder / "input.png"; }

  Answer run(const std::string& input, bool thorough) override {
    write_bytes(file_, input);
    Picture picture, again;
    const std::string problem = read_picture(file_.string(), picture);
    if (thorough && (read_picture(file_.string(), again) != problem || again.rgb != picture.rgb)) {
      wrong_answer("reads differently the second time");
    }
    const auto is_printable = [](char c) { return c >= ' ' && c <= '~'; };
    if (!std::all_of(problem.begin(), problem.end(), is_printable)) {
      wrong_answer("a problem with control characters");
    }
    const std::size_t size =
        3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    if (picture.rgb.size() != size || (size == 0) == problem.empty()) {
      wrong_answer("a picture of another size");
    }
    return problem.empty() ? Answer::kAccepted : Answer::kRefused;
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  fs::path file_;
};

}  // namespace

std::unique_ptr<Area> make_picture_area(const AreaOptions&) {
  return std::make_unique<PictureArea>();
}

}  // namespace skybody::fuzz
