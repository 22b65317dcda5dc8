// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/render.h"

#include "cagegen/render/levels.h"
#include "tests/cagegen/render/shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace encage::render {
namespace {

constexpr int white = 255;

Eigen::Vector3i pixel(const Image& image, int x, int y) {
  const std::uint8_t* p = image.pixel(x, y);
  return {p[0], p[1], p[2]};
}

bool is_white(const Image& image, int x, int y) { return pixel(image, x, y) == Eigen::Vector3i::Constant(white); }

int count_drawn(const Image& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += !is_white(image, x, y);
  }
  return count;
}

// Red above green above blue, or whichever channel leads.
int leading_channel(const Eigen::Vector3i& color) {
  int channel = 0;
  color.maxCoeff(&channel);
  return channel;
}

Options small(int width = 120, int height = 90) {
  Options options;
  options.width = width;
  options.height = height;
  return options;
}

Camera front() {
  Camera camera;
  camera.azimuth = 0;
  camera.elevation = 0;
  return camera;
}

TEST(Render, CubeCoversTheMiddle) {
  const TriangleMesh mesh = test::cube(1);
  Item item;
  item.mesh = &mesh;
  item.color = {0.1F, 0.8F, 0.2F};
  Options options = small(100, 100);
  options.camera = front();
  const Image image = render({&item, 1}, options);
  EXPECT_EQ(image.rgb.size(), 100U * 100 * 3);
  // The nearer face spans 93 pixels.
  EXPECT_NEAR(count_drawn(image), 93 * 93, 250);
  EXPECT_TRUE(is_white(image, 1, 50));
  EXPECT_TRUE(is_white(image, 98, 50));
  EXPECT_TRUE(is_white(image, 50, 1));
  const Eigen::Vector3i middle = pixel(image, 50, 50);
  EXPECT_EQ(leading_channel(middle), 1);
  EXPECT_GT(middle[1], 100);
  EXPECT_LT(middle[0], 60);
}

TEST(Render, ZoomMagnifies) {
  const TriangleMesh mesh = test::cube(1);
  Item item;
  item.mesh = &mesh;
  Options options = small(100, 100);
  options.camera = front();
  options.camera->zoom = 0.5;
  EXPECT_NEAR(count_drawn(render({&item, 1}, options)), 46.5 * 46.5, 150);
}

TEST(Render, NearerMeshHidesTheOther) {
  const TriangleMesh inner = test::cube(1), outer = test::cube(2);
  std::vector<Item> items(2);
  items[0] = {&inner, {0.9F, 0.1F, 0.1F}, Style::solid, false, false};
  items[1] = {&outer, {0.1F, 0.1F, 0.9F}, Style::solid, false, false};
  Options options = small();
  options.camera = front();
  EXPECT_EQ(leading_channel(pixel(render(items, options), 60, 45)), 2);
  // Through a translucent one, both are seen.
  items[1].style = Style::translucent;
  const Eigen::Vector3i both = pixel(render(items, options), 60, 45);
  EXPECT_EQ(leading_channel(both), 0);
  EXPECT_GT(both[2], 100);
  items.pop_back();
  EXPECT_LT(pixel(render(items, options), 60, 45)[2], both[2]);
}

TEST(Render, SurfacesForSectionsOnlyAreNotDrawn) {
  const TriangleMesh mesh = test::cube(1);
  Item item;
  item.mesh = &mesh;
  item.style = Style::section;
  EXPECT_EQ(count_drawn(render({&item, 1}, small())), 0);
}

TEST(Render, EdgesAreDarkLines) {
  const TriangleMesh mesh = test::cube(1);
  Item item = level_item(mesh, 1);
  Options options = small(200, 200);
  options.camera = front();
  const Image with = render({&item, 1}, options);
  item.edges = false;
  const Image without = render({&item, 1}, options);
  // The diagonal of the front face passes through the middle of the picture.
  int darker = 0;
  for (int x = 90; x < 110; ++x) darker += pixel(with, x, 95).sum() + 60 < pixel(without, x, 95).sum();
  EXPECT_GE(darker, 1);
  EXPECT_LE(darker, 5);
}

TEST(Render, SectionShowsRingsInOrder) {
  const std::vector<TriangleMesh> levels{test::sphere(1, 4), test::sphere(1.5, 3), test::sphere(2, 3)};
  Options options = small(240, 240);
  options.cut = Cut{Axis::x, 0};
  const Image image = render(nested_items(levels), options);
  // From the middle to the right: the tint of each level between contours that are darker than both sides.
  const double pixels_per_unit = 0.93 * 120 / 2;
  const auto at = [&](double radius) { return pixel(image, 120 + static_cast<int>(radius * pixels_per_unit), 120); };
  EXPECT_EQ(leading_channel(at(0.5)), 0);  // yellow
  EXPECT_GT(at(0.5)[1], at(0.5)[2] + 20);
  EXPECT_EQ(leading_channel(at(1.25)), 0);  // red
  EXPECT_LT(at(1.25)[1], at(0.5)[1]);
  EXPECT_EQ(leading_channel(at(1.75)), 2);  // blue
  EXPECT_EQ(at(2.1), Eigen::Vector3i::Constant(white));
  for (const double radius : {1.0, 1.5, 2.0}) {
    int darkest = 3 * white;
    for (const double off : {-0.04, -0.02, 0.0, 0.02, 0.04}) darkest = std::min(darkest, at(radius + off).sum());
    EXPECT_LT(darkest + 50, std::min(at(radius - 0.25).sum(), at(radius + 0.1).sum())) << radius;
  }
}

TEST(Render, CutShowsTheFarHalf) {
  // A small sphere on the removed side of the plane, a large one beyond it.
  TriangleMesh mesh = test::sphere(0.5, 3);
  mesh.vertices.col(0).array() += 2;
  TriangleMesh other = test::sphere(1, 3);
  other.vertices.col(0).array() -= 2;
  std::vector<Item> items(2);
  items[0].mesh = &mesh;
  items[1].mesh = &other;
  items[1].color = {0.1F, 0.1F, 0.9F};
  Options options = small(100, 100);
  options.cut = Cut{Axis::x, 0};
  const Image from_right = render(items, options);  // the eye is at +x: the first is removed
  EXPECT_GT(pixel(from_right, 50, 50)[2], pixel(from_right, 50, 50)[0] + 30);
  options.camera = front();
  options.camera->azimuth = -90;  // from the other side
  const Image from_left = render(items, options);
  EXPECT_LT(std::abs(pixel(from_left, 50, 50)[2] - pixel(from_left, 50, 50)[0]), 10);
}

TEST(Render, EmptyCutIsAPictureWithoutASection) {
  // Two separate spheres; the plane lies in the gap.
  TriangleMesh mesh = test::sphere(1, 3);
  const TriangleMesh twin = mesh;
  mesh.vertices.conservativeResize(2 * twin.vertices.rows(), 3);
  mesh.triangles.conservativeResize(2 * twin.triangles.rows(), 3);
  mesh.vertices.bottomRows(twin.vertices.rows()) = twin.vertices;
  mesh.vertices.bottomRows(twin.vertices.rows()).col(0).array() += 4;
  mesh.triangles.bottomRows(twin.triangles.rows()) =
      twin.triangles.array() + static_cast<std::int32_t>(twin.vertices.rows());
  Item item;
  item.mesh = &mesh;
  Options options = small();
  options.cut = Cut{Axis::x, 2};
  EXPECT_GT(count_drawn(render({&item, 1}, options)), 1000) << "the far sphere is whole";
  // At the rim of the bounds nothing is left but a point.
  options.cut->offset = bounds(mesh).min().x();
  EXPECT_EQ(render({&item, 1}, options).rgb.size(), 120U * 90 * 3);
}

TEST(Render, OpenMeshesAreDrawnWithoutAFill) {
  TriangleMesh mesh = test::cube(1);
  mesh.triangles.conservativeResize(11, 3);
  Item item;
  item.mesh = &mesh;
  item.style = Style::section;
  Options options = small(100, 100);
  options.cut = Cut{Axis::y, 0};
  const Image image = render({&item, 1}, options);
  EXPECT_TRUE(is_white(image, 50, 50));
  EXPECT_GT(count_drawn(image), 100);
}

TEST(Render, IsTheSameTwice) {
  const std::vector<TriangleMesh> levels{test::sphere(1, 3), test::sphere(1.4, 2)};
  const auto items = nested_items(levels);
  Options options = small();
  EXPECT_EQ(render(items, options).rgb, render(items, options).rgb);
  options.cut = Cut{Axis::z, 0.2};
  EXPECT_EQ(render(items, options).rgb, render(items, options).rgb);
}

TEST(Render, FarFromZeroLooksTheSame) {
  TriangleMesh mesh = test::sphere(1, 3);
  Item item;
  item.mesh = &mesh;
  const Image near = render({&item, 1}, small());
  mesh.vertices.array() += 1048576;
  const Image far = render({&item, 1}, small());
  int different = 0;
  for (std::size_t i = 0; i < near.rgb.size(); ++i) different += std::abs(near.rgb[i] - far.rgb[i]) > 40;
  EXPECT_LT(different, 60);
}

std::string error_of(const Options& options, const TriangleMesh& mesh = test::cube(1)) {
  Item item;
  item.mesh = &mesh;
  try {
    render({&item, 1}, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Render, BadOptionsAreErrors) {
  EXPECT_NE(error_of(small(0, 90)).find("0x90"), std::string::npos);
  EXPECT_NE(error_of(small(120, 9000)).find("120x9000"), std::string::npos);
  Options options = small();
  options.cut = Cut{Axis::y, 1.5};
  EXPECT_NE(error_of(options).find("cut y=1.5"), std::string::npos);
  options.cut->offset = 0;
  options.camera = front();
  options.camera->azimuth = 90;  // looks along x, in the plane
  EXPECT_NE(error_of(options).find("plane of the cut"), std::string::npos);
  options = small();
  options.camera = front();
  options.camera->elevation = 91;
  EXPECT_NE(error_of(options).find("elevation"), std::string::npos);
  options.camera = front();
  options.camera->zoom = 0;
  EXPECT_NE(error_of(options).find("zoom"), std::string::npos);
  EXPECT_NE(error_of(small(), TriangleMesh()).find("nothing to draw"), std::string::npos);
}

}  // namespace
}  // namespace encage::render
