// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/triplets.h"

#include "oracles/meshes.h"
#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <encage/asset.h>
#include <encage/bake.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace encage::zoo {
namespace {

using render::Image;

Image filled(int width, int height, std::uint8_t value) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height), value)};
}

TEST(Tiled, PlacesPicturesRowByRow) {
  const Image image = tiled({filled(2, 3, 10), filled(2, 3, 20), filled(2, 3, 30)}, 2);
  ASSERT_EQ(image.width, 4);
  ASSERT_EQ(image.height, 6);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 4; ++x) {
      const int expected = y < 3 ? (x < 2 ? 10 : 20) : (x < 2 ? 30 : 255);
      EXPECT_EQ(*image.pixel(x, y), expected) << x << ' ' << y;
    }
  }
  EXPECT_EQ(tiled({}, 2).width, 0);
}

bool blank(const Image& image) {
  return std::all_of(image.rgb.begin(), image.rgb.end(), [](std::uint8_t value) { return value == 255; });
}

TEST(Triplet, ShowsInputSectionAndCage) {
  CageHierarchy hierarchy;
  hierarchy.fine = shapes::sphere(4);
  EXPECT_THROW(triplet(hierarchy, render::Axis::z, 32), Error);
  hierarchy.levels.resize(1);
  hierarchy.levels[0].mesh = shapes::scaled(shapes::sphere(2), 1.5);
  const std::array<Image, 3> pictures = triplet(hierarchy, render::Axis::z, 32);
  for (const Image& picture : pictures) {
    EXPECT_EQ(picture.width, 32);
    EXPECT_EQ(picture.height, 32);
    EXPECT_FALSE(blank(picture));
  }
  EXPECT_NE(pictures[0].rgb, pictures[1].rgb);
  EXPECT_NE(pictures[0].rgb, pictures[2].rgb);
  hierarchy.fine = {};
  EXPECT_THROW(triplet(hierarchy, render::Axis::z, 32), Error);
}

TEST(TripletsTool, DrawsAnAsset) {
  test::ScratchFolder folder;
  BakeOptions options;
  options.faces = {60};
  options.method = BakeMethod::collapse;
  write_asset(folder.path() / "ring.glb", bake(test::torus(12, 8), options));
  const test::RunResult drawn = test::run(
      {ENCAGE_BENCH_BINARY, "triplets", "ring.glb", "ring.glb", "--size", "24", "-o", "out.png"}, folder.path());
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_NE(drawn.out.find("144 x 24"), std::string::npos) << drawn.out;
  EXPECT_TRUE(folder.read("out.png").starts_with("\x89PNG"));
  const test::RunResult refused =
      test::run({ENCAGE_BENCH_BINARY, "triplets", "ring.glb", "--up", "y,z", "-o", "no.png"}, folder.path());
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("2 axes for 1 asset"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace encage::zoo
