// Pictures: PNG and JPEG by their content, limits, broken files.
#include "core/io/files/picture_reader.h"

#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

class PictureReader : public ::testing::Test {
 protected:
  static std::string png(int width, int height, std::uint32_t format,
                         const std::vector<std::uint8_t>& pixels) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<std::uint32_t>(width);
    image.height = static_cast<std::uint32_t>(height);
    image.format = format;
    png_alloc_size_t size = 0;
    png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr);
    std::string bytes(size, '\0');
    png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr);
    bytes.resize(size);
    return bytes;
  }
  static std::string jpeg(int width, int height, const std::vector<std::uint8_t>& rgb) {
    const tjhandle encoder = tjInitCompress();
    unsigned char* data = nullptr;
    unsigned long size = 0;
    tjCompress2(encoder, rgb.data(), width, 0, height, TJPF_RGB, &data, &size, TJSAMP_444, 100, 0);
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    tjFree(data);
    tjDestroy(encoder);
    return bytes;
  }
  std::string problem_of(const std::string& name, const std::string& bytes) const {
    Picture picture;
    picture.width = 7;
    const std::string problem = read_picture(folder_.write(name, bytes), picture);
    EXPECT_EQ(picture.width, 0);
    EXPECT_TRUE(picture.rgb.empty());
    return problem;
  }

  TempFolder folder_;
};

const std::vector<std::uint8_t> kPixels{10, 20, 30, 40, 50, 60, 70, 80, 90, 1, 2, 3};  // 2 x 2

TEST_F(PictureReader, ReadsPngByItsContent) {
  Picture picture;
  EXPECT_EQ(read_picture(folder_.write("a.jpg", png(2, 2, PNG_FORMAT_RGB, kPixels)), picture), "");
  EXPECT_EQ(picture.width, 2);
  EXPECT_EQ(picture.height, 2);
  EXPECT_EQ(picture.rgb, kPixels);
}

TEST_F(PictureReader, MakesGreyRedGreenBlueAndLeavesTransparencyOut) {
  Picture picture;
  EXPECT_EQ(read_picture(folder_.write("grey.png", png(2, 1, PNG_FORMAT_GRAY, {5, 250})), picture),
            "");
  EXPECT_EQ(picture.rgb, (std::vector<std::uint8_t>{5, 5, 5, 250, 250, 250}));
  const std::vector<std::uint8_t> rgba{10, 20, 30, 0, 40, 50, 60, 128};
  EXPECT_EQ(read_picture(folder_.write("alpha.png", png(2, 1, PNG_FORMAT_RGBA, rgba)), picture),
            "");
  EXPECT_EQ(picture.rgb, (std::vector<std::uint8_t>{10, 20, 30, 40, 50, 60}));
}

TEST_F(PictureReader, ReadsJpeg) {
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < 16 * 8; ++i) rgb.insert(rgb.end(), {200, 100, 50});
  Picture picture;
  EXPECT_EQ(read_picture(folder_.write("a.jpg", jpeg(16, 8, rgb)), picture), "");
  ASSERT_EQ(picture.rgb.size(), rgb.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) EXPECT_NEAR(picture.rgb[i], rgb[i], 2);
}

TEST_F(PictureReader, SaysWhyAFileIsNoPicture) {
  EXPECT_EQ(problem_of("text.png", "no picture"), "is neither PNG nor JPEG");
  EXPECT_EQ(problem_of("empty.png", ""), "is neither PNG nor JPEG");
  const std::vector<std::uint8_t> row(3 * 5000);
  const std::string too_large = "is 5000 x 1 pixels; allowed: at most 4096 x 4096";
  EXPECT_EQ(problem_of("wide.png", png(5000, 1, PNG_FORMAT_RGB, row)), too_large);
  EXPECT_EQ(problem_of("wide.jpg", jpeg(5000, 1, row)), too_large);
  Picture picture;
  EXPECT_EQ(read_picture(folder_.path("none.png"), picture), "does not exist");
  EXPECT_EQ(read_picture(folder_.path(""), picture), "is a folder");
}

TEST_F(PictureReader, RefusesCutFiles) {
  const std::string whole = png(2, 2, PNG_FORMAT_RGB, kPixels);
  for (const std::size_t size : {8u, 20u, 33u, 45u}) {
    EXPECT_EQ(problem_of("cut.png", whole.substr(0, size)).rfind("is a broken PNG: ", 0), 0u);
  }
  const std::string photo = jpeg(2, 2, kPixels);
  for (const std::size_t size : {std::size_t{4}, photo.size() / 2, photo.size() - 4}) {
    EXPECT_EQ(problem_of("cut.jpg", photo.substr(0, size)).rfind("is a broken JPEG: ", 0), 0u);
  }
}

}  // namespace
}  // namespace skybody
