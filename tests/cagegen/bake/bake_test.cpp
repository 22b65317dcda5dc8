// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"
#include "tests/cagegen/bake/certified.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace encage {
namespace {

using shapes::box;
using shapes::cube;
using shapes::joined;
using shapes::moved;
using shapes::scaled;
using shapes::sphere;
using shapes::torus;
using test::expect_certified;
using test::with_faces;

/// Bakes with two threads, expects certified cages.
CageHierarchy bake_certified_once(const SourceMesh& source, const std::vector<std::int64_t>& faces) {
  CageHierarchy cages = bake(source, with_faces(faces, 2), {});
  expect_certified(cages, source);
  return cages;
}
CageHierarchy bake_certified_once(const TriangleMesh& input, const std::vector<std::int64_t>& faces) {
  return bake_certified_once(sanitize(input), faces);
}

/// Bakes with one thread and with two, expects the same certified cages.
CageHierarchy bake_certified(const TriangleMesh& input, const std::vector<std::int64_t>& faces) {
  const SourceMesh source = sanitize(input);
  const CageHierarchy two = bake_certified_once(source, faces);
  CageHierarchy one = bake(source, with_faces(faces, 1), {});
  EXPECT_EQ(one.levels.size(), two.levels.size());
  for (std::size_t i = 0; i < std::min(one.levels.size(), two.levels.size()); ++i) {
    EXPECT_EQ(one.levels[i].mesh.vertices, two.levels[i].mesh.vertices);
    EXPECT_EQ(one.levels[i].mesh.triangles, two.levels[i].mesh.triangles);
    EXPECT_EQ(one.levels[i].certificate.start, two.levels[i].certificate.start);
    EXPECT_LT(one.levels[i].certificate.clearance / one.diagonal, 1);
  }
  return one;
}

/// A box with every face cut into n x n squares.
TriangleMesh gridded_box(int n, const Eigen::Vector3d& size) {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::map<std::array<int, 3>, std::int32_t> number;
  const auto id = [&](const std::array<int, 3>& p) {
    const auto [it, added] = number.try_emplace(p, static_cast<std::int32_t>(vertices.size()));
    if (added) vertices.push_back({size[0] * p[0] / n, size[1] * p[1] / n, size[2] * p[2] / n});
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, n}) {
      for (int i = 0; i < n * n; ++i) {
        const auto at = [&](int du, int dv) {
          std::array<int, 3> p{};
          p[axis] = side;
          p[(axis + 1) % 3] = i % n + du;
          p[(axis + 2) % 3] = i / n + dv;
          return id(p);
        };
        const std::int32_t a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
        if (side == n) {
          triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
        } else {
          triangles.insert(triangles.end(), {{a, c, b}, {a, d, c}});
        }
      }
    }
  }
  return shapes::mesh(vertices, triangles);
}

/// A wavy sheet of 2 n n triangles over the unit square, tilted out of the axes.
TriangleMesh sheet(int n, double wave) {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      const double z = wave * std::sin(7 * x) * std::cos(5 * y);
      vertices.push_back({x - z / 2, y - z / 3, x / 2 + y / 3 + z});
      const std::int32_t a = j * (n + 1) + i;
      if (i == n || j == n) continue;
      triangles.insert(triangles.end(), {{a, a + 1, a + n + 2}, {a, a + n + 2, a + n + 1}});
    }
  }
  return shapes::mesh(vertices, triangles);
}

/// A U of three bars, extruded: closed, concave.
TriangleMesh u_shape() {
  const std::vector<std::array<double, 2>> outline = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  const std::vector<std::array<std::int32_t, 3>> caps = {{0, 5, 7}, {5, 6, 7}, {0, 1, 5},
                                                         {1, 4, 5}, {1, 2, 4}, {2, 3, 4}};
  std::vector<std::array<double, 3>> vertices;
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : outline) vertices.push_back({p[0], p[1], z});
  }
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const auto& t : caps) {
    triangles.push_back({t[0], t[2], t[1]});
    triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  }
  for (std::int32_t i = 0; i < 8; ++i) {
    const std::int32_t j = (i + 1) % 8;
    triangles.insert(triangles.end(), {{i, j, j + 8}, {i, j + 8, i + 8}});
  }
  return shapes::mesh(vertices, triangles);
}

TEST(Bake, SubdividedBox) {
  const CageHierarchy cages = bake_certified(gridded_box(8, {1, 2, 3}), {100, 12});
  ASSERT_EQ(cages.levels.size(), 1u) << "the first level is a box already";
  EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.001);
  EXPECT_EQ(cages.levels[0].mesh.triangles.rows(), 12);
}

TEST(Bake, UShapeKeepsItsGap) {
  const CageHierarchy cages = bake_certified(u_shape(), {24, 12});
  EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.25) << "the hull has 9 / 7";
}

TEST(Bake, NestedSpheres) {
  const CageHierarchy cages = bake_certified(sphere(3), {250, 100, 30});
  ASSERT_EQ(cages.levels.size(), 3u);
  EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.1);
  EXPECT_LT(*cages.levels[1].certificate.volume_ratio, 1.3);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_GT(cages.levels[i].certificate.volume, cages.levels[i - 1].certificate.volume);
  }
}

TEST(Bake, TwoComponentsFarApart) {
  bake_certified(joined(sphere(3), moved(scaled(sphere(2), 0.01), {40, 3, 2})), {200, 50});
}

TEST(Bake, PartsStayApartAtLargeClearances) {
  // Two plates of 1 x 1 x 0.25; their hull has 1.25 times their volume.
  const TriangleMesh plates = joined(gridded_box(8, {1, 1, 0.25}), moved(gridded_box(8, {1, 1, 0.25}), {0, 0, 0.375}));
  double largest = 1.0001;
  for (const double clearance : {1e-4, 1e-3, 3e-3}) {
    BakeOptions options = with_faces({24});
    options.min_clearance = clearance;
    const CageHierarchy cages = bake(plates, options);
    EXPECT_EQ(cages.levels[0].certificate.components, 2);
    EXPECT_GT(*cages.levels[0].certificate.volume_ratio, largest);
    largest = 1 + 40 * clearance;
    EXPECT_LT(*cages.levels[0].certificate.volume_ratio, largest);
  }
}

TEST(Bake, OpenBoxIsCapped) {
  TriangleMesh open = gridded_box(5, {1, 1, 1});
  open.triangles.conservativeResize(open.triangles.rows() - 50, 3);
  const CageHierarchy cages = bake_certified(open, {100, 20});
  EXPECT_EQ(cages.solid, Solid::capped);
  EXPECT_GT(cages.cap_count, 0);
}

TEST(Bake, Sheets) {
  for (const double wave : {0.0, 0.1}) bake_certified(sheet(10, wave), {60, 20});
}

TEST(Bake, CrossingSheets) {
  TriangleMesh across = sheet(8, 0.05);
  across.vertices.col(2).array() = 0.8 - across.vertices.col(2).array();
  bake_certified(joined(sheet(8, 0), across), {100, 24});
}

TEST(Bake, SoupOfCrossingTriangles) {
  shapes::Random random(7);
  TriangleMesh soup = shapes::mesh({}, {});
  for (int i = 0; i < 60; ++i) soup = shapes::with_triangle(soup, random.point(1), random.point(1), random.point(1));
  bake_certified(soup, {50, 16});
}

TEST(Bake, SingleTriangles) {
  const std::vector<std::array<Eigen::Vector3d, 3>> triangles = {
      {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)},
      {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)},         // tilted
      {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 2, 3.000001)},  // sliver
      {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(2, 4, 6)},         // collinear
      {Eigen::Vector3d(5, 5, 5), Eigen::Vector3d(5, 5, 6), Eigen::Vector3d(5, 5, 6)},         // a segment
      {Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d(7.7, 3.3, 1.9), Eigen::Vector3d(2, 9, 4)}};
  for (const auto& t : triangles) {
    SCOPED_TRACE(t[2].transpose());
    const CageHierarchy cages = bake_certified(shapes::with_triangle(shapes::mesh({}, {}), t[0], t[1], t[2]), {100});
    EXPECT_EQ(cages.levels.size(), 1u);
    EXPECT_EQ(cages.levels[0].certificate.method, Method::hull);
  }
}

TEST(Bake, Needles) {
  // Collinear points only, along an axis and askew.
  for (const Eigen::Vector3d& along : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 2, 4)}) {
    TriangleMesh needle = shapes::mesh({}, {});
    for (int i = 0; i < 30; ++i) needle = shapes::with_triangle(needle, i * along, (i + 1) * along, (i + 2) * along);
    bake_certified(needle, {12});
    bake_certified(needle, {100});
  }
  // Closed, but a million times longer than thick.
  bake_certified(gridded_box(5, {1, 1e-6, 1e-6}), {60, 12});
  bake_certified(gridded_box(5, {1, 1, 1e-7}), {60, 12});
}

TEST(Bake, FarFromTheOrigin) {
  const TriangleMesh far = moved(scaled(sphere(3), 0.6), {1e3, -1e3, 1e3});
  const CageHierarchy cages = bake_certified(far, {100, 20});
  EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.3);
  // Just near enough to keep the origin where it is.
  const double diagonal = 2 * std::sqrt(3.0);
  const CageHierarchy kept = bake_certified(moved(sphere(3), {3.9 * diagonal, 0, -3.9 * diagonal}), {100, 20});
  EXPECT_EQ(kept.origin, Eigen::Vector3d::Zero().eval());
  EXPECT_LT(*kept.levels[0].certificate.volume_ratio, 1.3);
}

TEST(Bake, ExtremeScales) {
  for (const double scale : {1e-28, 1e-20, 1e20, 1e36}) {
    SCOPED_TRACE(scale);
    const CageHierarchy cages = bake_certified_once(scaled(sphere(2), scale), {60, 20});
    EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.5);
    bake_certified_once(scaled(sheet(4, 0.1), scale), {20});
    bake_certified_once(scaled(sheet(1, 0), scale), {40});
  }
}

TEST(Bake, ClearanceIsKept) {
  for (const double clearance : {1e-7, 1e-3, 0.09}) {
    SCOPED_TRACE(clearance);
    for (const TriangleMesh& mesh : {sphere(2), u_shape(), sheet(4, 0.1), sheet(1, 0)}) {
      BakeOptions options = with_faces({60, 16}, 2, BakeMethod::collapse);
      options.min_clearance = clearance;
      const CageHierarchy cages = bake(mesh, options);
      for (const CageLevel& level : cages.levels) {
        EXPECT_GE(level.certificate.clearance, 0.99 * clearance * cages.diagonal) << level.certificate.start;
      }
    }
  }
}

TEST(Bake, Topology) {
  const TriangleMesh ring = torus(1, 0.3, 40, 16);
  BakeOptions options = with_faces({200, 60});
  options.topology = Topology::keep;
  for (const CageLevel& level : bake(ring, options).levels) EXPECT_EQ(level.certificate.genus, 1);
  // A ball around the ring encloses it without its handle.
  BakeOptions ball;
  ball.coarse = {scaled(sphere(2), 2)};
  EXPECT_EQ(bake(ring, ball).levels[0].certificate.genus, 0);
  ball.topology = Topology::keep;
  try {
    bake(ring, ball);
    FAIL() << "the handle is lost";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("has genus 1, that of the level before"), std::string::npos)
        << error.what();
  }
  // A hole too narrow to be worth a handle.
  options.topology = Topology::simplify;
  const CageHierarchy simple = bake(torus(1, 0.98, 60, 30), options);
  EXPECT_EQ(simple.levels.back().certificate.genus, 0);
  for (const CageLevel& level : simple.levels) EXPECT_NE(level.certificate.no_new_handles, false);
}

TEST(Bake, SameFileForAnyNumberOfThreads) {
  const SourceMesh source = sanitize(torus(1, 0.4, 24, 12));
  const auto file = [&](int threads) {
    const auto path = std::filesystem::temp_directory_path() /
                      ("encage_bake_test_" + std::to_string(threads) + "_" +
                       std::to_string(std::chrono::steady_clock::now().time_since_epoch().count()) + ".glb");
    write_asset(path, bake(source, with_faces({160, 60}, threads), {}));
    std::ifstream stream(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    std::filesystem::remove(path);
    return bytes;
  };
  const std::string one = file(1);
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(one, file(2));
  EXPECT_EQ(one, file(3));
}

TEST(Bake, ProgressNeverGoesBack) {
  for (const TriangleMesh& mesh : {sphere(3), sheet(8, 0.1)}) {
    std::vector<double> seen;
    const std::thread::id caller = std::this_thread::get_id();
    BakeContext context;
    context.progress = [&](double fraction, std::string_view stage) {
      seen.push_back(fraction);
      EXPECT_FALSE(stage.empty());
      EXPECT_EQ(std::this_thread::get_id(), caller);
    };
    bake(sanitize(mesh), with_faces({80, 40, 20}, 1), context);
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
    for (const double fraction : seen) EXPECT_TRUE(fraction >= 0 && fraction <= 1) << fraction;
  }
}

TEST(Bake, Cancel) {
  std::atomic<bool> cancel = true;
  BakeContext context;
  context.cancel = &cancel;
  EXPECT_THROW(bake(sphere(3), with_faces({100}), context), Cancelled);
  // From the callback, in the middle of the work.
  cancel = false;
  context.progress = [&](double, std::string_view) { cancel = true; };
  EXPECT_THROW(bake(sphere(6), with_faces({4000, 1000, 100}, 1), context), Cancelled);
}

TEST(Bake, ExceptionsOfTheProgressFunctionPassThrough) {
  BakeContext context;
  context.progress = [](double, std::string_view) { throw std::runtime_error("enough"); };
  EXPECT_THROW(bake(sphere(6), with_faces({4000, 1000, 100}, 1), context), std::runtime_error);
}

TEST(Bake, TimeLimit) {
  BakeOptions options = with_faces({60, 30, 12});
  options.time_limit = 1e-9;
  const SourceMesh source = sanitize(sphere(2));
  BakeReport report;
  const CageHierarchy cut = bake(source, options, {}, &report);
  EXPECT_TRUE(cut.truncated);
  EXPECT_EQ(report.missing, (std::vector<std::int64_t>{30, 12}));
  EXPECT_EQ(report.failure, "the time limit leaves out levels of 30, 12 faces");
  EXPECT_EQ(cut.levels.size(), 1u);
  expect_certified(cut, source);
  for (const double limit : {1e6, 1e10, 1e300, std::numeric_limits<double>::infinity()}) {
    options.time_limit = limit;
    const CageHierarchy whole = bake(source, options, {}, &report);
    EXPECT_FALSE(whole.truncated) << limit;
    EXPECT_TRUE(report.missing.empty());
    EXPECT_EQ(report.failure, "");
    EXPECT_EQ(whole.levels.size(), 3u) << limit;
  }
}

TEST(Bake, SkippedLevelsAreLogged) {
  std::vector<std::string> messages;
  BakeContext context;
  context.log = [&](std::string_view message) { messages.emplace_back(message); };
  BakeReport report;
  const CageHierarchy cages = bake(sphere(2), with_faces({500, 128, 60, 60, 80, 20}), context, &report);
  EXPECT_EQ(cages.levels.size(), 3u);
  EXPECT_EQ(report.levels.size(), 3u);
  const auto skipped = [&](const std::string& faces) {
    return std::count_if(messages.begin(), messages.end(), [&](const std::string& message) {
      return message.starts_with("level of " + faces + " faces skipped");
    });
  };
  EXPECT_EQ(skipped("500"), 0) << "128, which is what the sphere has";
  EXPECT_EQ(skipped("128"), 1);
  EXPECT_EQ(skipped("60"), 1);
  EXPECT_EQ(skipped("80"), 1);
  EXPECT_EQ(skipped("20"), 0);
}

TEST(Bake, LevelsOfAsManyFacesAsTheInputAreAsTightAsItAllows) {
  const TriangleMesh two_boxes = joined(box({0, 0, 0}, {1, 1, 1}), box({3, 0, 0}, {4, 1, 1}));
  for (const BakeMethod method : {BakeMethod::collapse, BakeMethod::flow, BakeMethod::automatic}) {
    for (const TriangleMesh& mesh : {u_shape(), torus(1, 0.3, 12, 4), two_boxes}) {
      const SourceMesh source = sanitize(mesh);
      const CageHierarchy cages = bake(source, with_faces({1000, 500}, 2, method), {});
      ASSERT_EQ(cages.levels.size(), 1u);
      expect_certified(cages, source);
      EXPECT_LE(cages.levels[0].mesh.triangles.rows(), mesh.triangles.rows());
      EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.005);
    }
  }
}

TEST(Bake, ASmallInputGetsOneLevelByDefault) {
  const SourceMesh source = sanitize(u_shape());
  const CageHierarchy cages = bake(source, {}, {});
  ASSERT_EQ(cages.levels.size(), 1u);
  expect_certified(cages, source);
  EXPECT_LT(*cages.levels[0].certificate.volume_ratio, 1.002);
}

TEST(Bake, NeverMoreFacesThanAskedFor) {
  const auto expect_at_most = [](const TriangleMesh& mesh, std::int64_t faces, double clearance, BakeMethod method) {
    SCOPED_TRACE(std::to_string(faces) + " faces, clearance " + std::to_string(clearance));
    BakeOptions options = with_faces({faces}, 2, method);
    options.min_clearance = clearance;
    const CageHierarchy cages = bake(mesh, options);
    ASSERT_EQ(cages.levels.size(), 1u);
    EXPECT_LE(cages.levels[0].mesh.triangles.rows(), faces);
    EXPECT_GE(cages.levels[0].certificate.clearance, 0.99 * clearance * cages.diagonal);
  };
  const TriangleMesh ring = torus(1, 0.3, 16, 8), balls = joined(sphere(1), moved(sphere(1), {2.01, 0, 0}));
  for (const std::int64_t faces : {4, 11, 100}) expect_at_most(ring, faces, 0.05, BakeMethod::collapse);
  for (const std::int64_t faces : {6, 12}) expect_at_most(balls, faces, 0.09, BakeMethod::collapse);
  for (const TriangleMesh& mesh : {ring, balls, sheet(4, 0.1)}) {
    expect_at_most(mesh, 4, 1e-5, BakeMethod::collapse);
    expect_at_most(mesh, 100, 0.05, BakeMethod::automatic);
  }
}

TEST(Bake, NoLooserThanAnOrientedBox) {
  // A sheet, a plate and a rod, turned out of the axes.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const std::vector<Eigen::Vector3d> sizes = {{1, 1, 0}, {2, 1, 1e-4}, {1, 1e-3, 2e-3}};
  for (const Eigen::Vector3d& size : sizes) {
    TriangleMesh mesh = size[2] == 0 ? sheet(20, 0) : gridded_box(12, size);
    if (size[2] == 0) mesh.vertices.col(2).setZero();
    mesh.vertices = (mesh.vertices * turn.transpose()).eval();
    for (const BakeMethod method : {BakeMethod::collapse, BakeMethod::flow}) {
      const CageHierarchy cages = bake(mesh, with_faces({500, 100, 12}, 2, method));
      for (std::size_t i = 0; i < cages.levels.size(); ++i) {
        // A clearance more on both sides for each level, and a tenth for roundings.
        const double added = 2.2 * static_cast<double>(i + 1) * 1e-5 * cages.diagonal;
        const Certificate& certificate = cages.levels[i].certificate;
        EXPECT_LE(certificate.volume, (size.array() + added).prod()) << certificate.start << ", size " << size[2];
      }
    }
  }
}

TEST(Bake, PlanarSolidsKeepTheirOwnSurface) {
  // A table of overlapping boxes: 76 triangles bound it, however finely they are divided.
  TriangleMesh table = moved(gridded_box(6, {1, 0.6, 0.05}), {0, 0, 0.5});
  for (const double x : {0.1, 0.8}) {
    for (const double y : {0.1, 0.4}) table = joined(table, moved(gridded_box(4, {0.1, 0.1, 0.52}), {x, y, 0}));
  }
  for (const std::int64_t faces : {300, 100, 76}) {
    const CageHierarchy cages = bake(table, with_faces({faces}));
    EXPECT_LT(cages.levels.front().certificate.volume_ratio, 1.005) << faces;
    EXPECT_LT(cages.levels.front().certificate.max_distance, 1e-3) << faces;
  }
}

TEST(Bake, DefaultLevels) {
  const SourceMesh source = sanitize(sphere(4));  // 2048 triangles
  BakeOptions options;
  const CageHierarchy cages = bake(source, options, {});
  expect_certified(cages, source);
  options.level_count = 2;
  options.ratio = 0.2;
  const CageHierarchy asked = bake(source, options, {});
  ASSERT_EQ(asked.levels.size(), 2u);
  EXPECT_LE(asked.levels[0].mesh.triangles.rows(), 409);
  EXPECT_LE(asked.levels[1].mesh.triangles.rows(), 81);
}

TEST(Bake, RefusesBadOptions) {
  const auto message = [](const BakeOptions& options) -> std::string {
    try {
      bake(cube(1), options);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const auto with = [&](auto change) {
    BakeOptions options;
    change(options);
    return message(options);
  };
  EXPECT_NE(with([](BakeOptions& o) { o.faces = {100, 3}; }).find("a level of 3 faces"), std::string::npos);
  EXPECT_NE(with([](BakeOptions& o) { o.faces = {8}, o.ratio = 0.5; }).find("exclude each other"), std::string::npos);
  EXPECT_NE(with([](BakeOptions& o) { o.faces = {8}, o.level_count = 2; }).find("exclude"), std::string::npos);
  for (const double ratio : {-1.0, 0.0, 1.0, 2.0, std::nan("")}) {
    EXPECT_NE(with([&](BakeOptions& o) { o.ratio = ratio; }).find("ratio"), std::string::npos);
  }
  EXPECT_NE(with([](BakeOptions& o) { o.level_count = 0; }).find("0 levels"), std::string::npos);
  for (const double clearance : {-1.0, 0.0, 0.1, std::nan("")}) {
    EXPECT_NE(with([&](BakeOptions& o) { o.min_clearance = clearance; }).find("clearance"), std::string::npos);
  }
  EXPECT_NE(with([](BakeOptions& o) { o.threads = -1; }).find("-1 threads"), std::string::npos);
  for (const double limit : {-1.0, 0.0, std::nan(""), -std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(with([&](BakeOptions& o) { o.time_limit = limit; }).find("time limit"), std::string::npos);
  }
}

TEST(WriteCertifiedAsset, WritesWhatWasCertified) {
  const test::Folder folder;
  const CageHierarchy cages = bake(sphere(3), with_faces({100, 30}, 1));
  write_certified_asset(folder / "a.glb", cages);
  const CageHierarchy back = read_asset(folder / "a.glb", Verify::all);
  ASSERT_EQ(back.levels.size(), 2u);
  EXPECT_EQ(back.levels[1].mesh.vertices, cages.levels[1].mesh.vertices);
  write_asset(folder / "b.glb", cages);
  EXPECT_EQ(test::bytes_of(folder / "a.glb"), test::bytes_of(folder / "b.glb"));
  EXPECT_EQ(folder.file_count(), 2u);
}

TEST(WriteCertifiedAsset, KeepsTheOldFileIfWhatIsReadBackDiffers) {
  const test::Folder folder;
  const std::filesystem::path file = folder.write("a.glb", "precious");
  CageHierarchy cages = bake(sphere(3), with_faces({100}, 1));
  cages.levels[0].mesh.vertices(5, 1) += 1e-12;  // no float
  try {
    write_certified_asset(file, cages);
    FAIL() << "the cage written is not the one certified";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).rfind(file.string() + ": ", 0), 0u) << error.what();
  }
  EXPECT_THROW(write_certified_asset(folder / "missing" / "a.glb", cages), Error);
  EXPECT_EQ(test::bytes_of(file), "precious");
  EXPECT_EQ(folder.file_count(), 1u);
}

}  // namespace
}  // namespace encage
