// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/arguments.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <string>

namespace encage::render {
namespace {

TEST(Arguments, Size) {
  EXPECT_EQ(parse_size("640x480").width, 640);
  EXPECT_EQ(parse_size("640x480").height, 480);
  for (const char* bad : {"", "640", "640x", "x480", "640x480x3", "640 x 480", "6.5x4", "99999999999x4"}) {
    EXPECT_THROW(parse_size(bad), Error) << bad;
  }
}

TEST(Arguments, Cut) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, 0, 2), Eigen::Vector3d(1, 3, 6));
  EXPECT_EQ(parse_cut("y=-0.25", box).axis, Axis::y);
  EXPECT_EQ(parse_cut("y=-0.25", box).offset, -0.25);
  EXPECT_EQ(parse_cut("z", box).axis, Axis::z);
  EXPECT_EQ(parse_cut("z", box).offset, 4);
  for (const char* bad : {"", "w=1", "x=", "x1", "x=1,", "x=nan", "x=inf", "=1", "xy"}) {
    EXPECT_THROW(parse_cut(bad, box), Error) << bad;
  }
}

TEST(Arguments, Camera) {
  EXPECT_EQ(parse_camera("-30,12.5").azimuth, -30);
  EXPECT_EQ(parse_camera("-30,12.5").elevation, 12.5);
  EXPECT_EQ(parse_camera("-30,12.5").zoom, 1);
  EXPECT_EQ(parse_camera("0,0,3").zoom, 3);
  for (const char* bad : {"", "1", "1,", "1,2,3,4", "a,b", "1;2", "1,nan"})
    EXPECT_THROW(parse_camera(bad), Error) << bad;
}

TEST(Arguments, AxisAndPoint) {
  EXPECT_EQ(parse_axis("y"), Axis::y);
  EXPECT_THROW(parse_axis("up"), Error);
  EXPECT_EQ(parse_point("1,-2,0.5"), Eigen::Vector3d(1, -2, 0.5));
  EXPECT_THROW(parse_point("1,2"), Error);
}

TEST(Arguments, ErrorsQuoteTheText) {
  try {
    parse_size("huge");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("'huge'"), std::string::npos);
  }
}

}  // namespace
}  // namespace encage::render
