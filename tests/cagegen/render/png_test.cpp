// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/png.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>

namespace encage::render {
namespace {

TEST(Png, RoundTripsThroughLibpng) {
  Image image{7, 3, {}};
  for (int i = 0; i < 7 * 3 * 3; ++i) image.rgb.push_back(static_cast<std::uint8_t>(i * 4));
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "encage_png_test.png";
  write_png(file, image);

  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&header, file.c_str()), 0);
  EXPECT_EQ(header.width, 7U);
  EXPECT_EQ(header.height, 3U);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(header));
  ASSERT_NE(png_image_finish_read(&header, nullptr, rgb.data(), 0, nullptr), 0);
  EXPECT_EQ(rgb, image.rgb);
  std::filesystem::remove(file);
}

TEST(Png, UnwritablePlaceIsAnError) {
  const Image image{1, 1, {1, 2, 3}};
  EXPECT_THROW(write_png("/nowhere/at/all.png", image), Error);
}

}  // namespace
}  // namespace encage::render
