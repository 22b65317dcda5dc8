// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow.h"

#include "cagegen/certify/separation.h"
#include "cagegen/flow/signed_distance.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <cstring>
#include <map>

namespace encage::makers {
namespace {

constexpr double part_gap = 1e-3;

FlowRequest request(const TriangleMesh& fine, const TriangleMesh& coarse) {
  FlowRequest result;
  result.fine = &fine;
  result.coarse = &coarse;
  result.diagonal = bounds(fine).diagonal().norm();
  result.gap = part_gap;
  return result;
}

TriangleMesh at(const TriangleMesh& fine, const Vertices& vertices) { return {vertices, fine.triangles}; }

/// By the certificate's distances, triangle by triangle, and the sides of the corners.
void expect_inside(const TriangleMesh& fine, const TriangleMesh& coarse) {
  const SignedDistance surface(coarse);
  for (std::int64_t s = 0; s < fine.triangles.rows(); ++s) {
    for (std::int64_t t = 0; t < coarse.triangles.rows(); ++t) {
      ASSERT_GT(proof::separate(shapes::corners(fine, s), shapes::corners(coarse, t)).lower, 0.999 * part_gap) << s;
    }
    for (int k = 0; k < 3; ++k) ASSERT_LT(surface.nearest(fine.corner(s, k)).distance, 0) << s;
  }
}

bool same_bytes(const Vertices& a, const Vertices& b) {
  return a.rows() == b.rows() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

/// A prism of height 1 over a plane polygon, counter-clockwise, whose triangles are given.
TriangleMesh prism(const std::vector<std::array<double, 2>>& polygon,
                   const std::vector<std::array<std::int32_t, 3>>& cap) {
  const auto n = static_cast<std::int32_t>(polygon.size());
  std::vector<std::array<double, 3>> vertices;
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : polygon) vertices.push_back({p[0], p[1], z});
  }
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const auto& t : cap) {
    triangles.push_back({t[0], t[2], t[1]});
    triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t j = (i + 1) % n;
    triangles.push_back({i, j, j + n});
    triangles.push_back({i, j + n, i + n});
  }
  return shapes::mesh(vertices, triangles);
}

/// A U of two arms, x < 1 and x > 2, on a foot, y < `foot`.
TriangleMesh u_shape(double foot) {
  return prism({{0, 0}, {3, 0}, {3, 4}, {2, 4}, {2, foot}, {1, foot}, {1, 4}, {0, 4}},
               {{0, 1, 5}, {1, 4, 5}, {1, 2, 4}, {2, 3, 4}, {0, 5, 6}, {0, 6, 7}});
}

/// A block with a narrow V cut into it from y = 4 down to y = `foot`.
TriangleMesh v_shape(double foot) {
  return prism({{0, 0}, {3, 0}, {3, 4}, {2, 4}, {1.5, foot}, {1, 4}, {0, 4}},
               {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {0, 4, 6}, {4, 5, 6}});
}

/// Every triangle into four.
TriangleMesh subdivided(const TriangleMesh& mesh) {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::map<std::array<double, 3>, std::int32_t> known;
  const auto vertex = [&](const Point& p) {
    const auto [it, added] = known.try_emplace({p.x(), p.y(), p.z()}, static_cast<std::int32_t>(vertices.size()));
    if (added) vertices.push_back(it->first);
    return it->second;
  };
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Corners c = shapes::corners(mesh, t);
    std::array<std::int32_t, 6> v;
    for (int k = 0; k < 3; ++k) {
      v[k] = vertex(c[k]);
      v[k + 3] = vertex((c[k] + c[(k + 1) % 3]) / 2);
    }
    triangles.insert(triangles.end(), {{v[0], v[3], v[5]}, {v[3], v[1], v[4]}, {v[5], v[4], v[2]}, {v[3], v[4], v[5]}});
  }
  return shapes::mesh(vertices, triangles);
}

/// A ball in the U's left arm with one vertex pulled out to `tip`.
TriangleMesh ball_with_spike(const Point& tip) {
  TriangleMesh ball = shapes::rounded(shapes::moved(shapes::scaled(shapes::sphere(3), 0.3), Point(0.5, 3, 0.5)));
  Eigen::Index outermost = 0;
  ball.vertices.col(0).maxCoeff(&outermost);
  ball.vertices.row(outermost) = tip.transpose();
  return ball;
}

TEST(Flow, MovesNothingThatIsInside) {
  const TriangleMesh fine = shapes::cube(1);
  const TriangleMesh coarse = shapes::cube(1.01);
  const FlowResult result = flow(request(fine, coarse));
  EXPECT_TRUE(result.inside);
  EXPECT_EQ(result.history.steps(), 0);
  EXPECT_TRUE(same_bytes(result.positions, fine.vertices));
  EXPECT_TRUE(result.stuck.empty());
}

TEST(Flow, KeepsTheGapEvenWhereNothingTouches) {
  const TriangleMesh fine = shapes::cube(1);
  const TriangleMesh coarse = shapes::cube(1 + part_gap / 2);
  const FlowResult result = flow(request(fine, coarse));
  EXPECT_TRUE(result.inside);
  EXPECT_GT(result.history.steps(), 0);
  expect_inside(at(fine, result.positions), coarse);
}

TEST(Flow, SphereIntoASmallerOneMovesRadially) {
  const TriangleMesh fine = shapes::rounded(shapes::sphere(4));
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(3), 0.98);
  const FlowResult result = flow(request(fine, coarse));
  ASSERT_TRUE(result.inside);
  EXPECT_LE(result.history.steps(), 10);
  EXPECT_EQ(result.smoothing_steps, 0);
  expect_inside(at(fine, result.positions), coarse);
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    const Point start = fine.vertices.row(v).transpose();
    const Point end = result.positions.row(v).transpose();
    EXPECT_GT((start - end).normalized().dot(start), 0.95);
    // The coarse faces lie up to 0.02 below their sphere; no deeper than a few gaps more.
    EXPECT_GT(end.norm(), 0.95);
    EXPECT_LT(end.norm(), 0.98);
  }
}

TEST(Flow, CoarseMeshOfTheSameShapeInside) {
  const TriangleMesh fine = shapes::rounded(shapes::torus(1, 0.4, 60, 30));
  const TriangleMesh coarse = shapes::torus(1, 0.4, 12, 6);
  const FlowResult result = flow(request(fine, coarse));
  ASSERT_TRUE(result.inside);
  expect_inside(at(fine, result.positions), coarse);
}

TEST(Flow, TakesDegenerateTriangles) {
  TriangleMesh fine = shapes::sphere(3);
  fine = shapes::with_triangle(fine, Point(0, 0, 1.02), Point(0, 0, 1.02), Point(0, 0, 1.02));
  fine = shapes::with_triangle(fine, Point(0.9, 0, 0), Point(1, 0, 0), Point(1.1, 0, 0));
  fine = shapes::with_triangle(fine, Point(0, -1.05, 0), Point(0, 1.05, 0), Point(0, 1.05, 0));
  fine = shapes::joined(fine, shapes::mesh({{0.7, 0.7, 0}, {0, 0.7, 0.7}}, {{0, 0, 1}, {1, 1, 1}}));
  fine = shapes::rounded(fine);
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(2), 0.97);
  const FlowResult result = flow(request(fine, coarse));
  ASSERT_TRUE(result.inside);
  expect_inside(at(fine, result.positions), coarse);
}

TEST(Flow, TakesComponentsAndCavities) {
  const TriangleMesh ball = shapes::sphere(3);
  const TriangleMesh shell = shapes::joined(ball, shapes::flipped(shapes::scaled(ball, 0.5)));
  const TriangleMesh fine = shapes::rounded(shapes::joined(shell, shapes::moved(ball, Point(3, 0, 0))));
  const TriangleMesh coarse_ball = shapes::scaled(shapes::sphere(2), 0.98);
  const TriangleMesh coarse =
      shapes::joined(shapes::joined(coarse_ball, shapes::flipped(shapes::scaled(coarse_ball, 0.53))),
                     shapes::moved(coarse_ball, Point(3, 0, 0)));
  const FlowResult result = flow(request(fine, coarse));
  ASSERT_TRUE(result.inside);
  expect_inside(at(fine, result.positions), coarse);
}

TEST(Flow, StallsWithATipInTheWrongArm) {
  const TriangleMesh coarse = u_shape(1);
  const TriangleMesh fine = ball_with_spike(Point(2.5, 3, 0.5));
  FlowRequest asked = request(fine, coarse);
  asked.most_smoothings = 0;
  const FlowResult result = flow(asked);
  EXPECT_FALSE(result.inside);
  EXPECT_EQ(result.smoothing_steps, 0);
  EXPECT_LT(result.history.steps(), asked.most_steps) << "stalls are noticed";
  ASSERT_FALSE(result.stuck.empty());
  // What is stuck are triangles around the tip, and they do touch.
  for (const std::int32_t t : result.stuck) {
    const Corners s = shapes::corners(at(fine, result.positions), t);
    bool touches = false;
    for (std::int64_t c = 0; c < coarse.triangles.rows(); ++c) {
      touches = touches || proof::separate(s, shapes::corners(coarse, c)).lower <= part_gap;
    }
    EXPECT_TRUE(touches);
  }
}

TEST(Flow, SmoothingBringsTheTipBack) {
  const TriangleMesh coarse = u_shape(1);
  const TriangleMesh fine = ball_with_spike(Point(2.5, 3, 0.5));
  const FlowResult result = flow(request(fine, coarse));
  EXPECT_TRUE(result.inside);
  EXPECT_GT(result.smoothing_steps, 0);
  expect_inside(at(fine, result.positions), coarse);
  EXPECT_LT(result.positions.col(0).maxCoeff(), 1);
}

TEST(Flow, ATipBetweenTheArmsComesInWithoutSmoothing) {
  const TriangleMesh coarse = u_shape(1);
  const TriangleMesh fine = ball_with_spike(Point(1.2, 3, 0.5));
  FlowRequest asked = request(fine, coarse);
  asked.most_smoothings = 0;
  const FlowResult result = flow(asked);
  EXPECT_TRUE(result.inside);
  expect_inside(at(fine, result.positions), coarse);
}

TEST(Flow, DrawsTheSkinOutOfAGap) {
  // The skin between the arms has nothing but the arms' walls to left and right; it has to go down.
  const TriangleMesh coarse = u_shape(1);
  for (const double foot : {1.2, 1.4, 1.6}) {
    const TriangleMesh fine = shapes::rounded(subdivided(subdivided(subdivided(u_shape(foot)))));
    const FlowResult result = flow(request(fine, coarse));
    EXPECT_TRUE(result.inside) << foot;
    expect_inside(at(fine, result.positions), coarse);
  }
}

TEST(Flow, StretchedTrianglesClimbOutOfANotch) {
  // Neither deeper targets nor smoothing bring these in.
  const TriangleMesh coarse = v_shape(1);
  for (const double foot : {1.5, 1.8, 2.5}) {
    const TriangleMesh fine = shapes::rounded(subdivided(subdivided(subdivided(v_shape(foot)))));
    const FlowResult result = flow(request(fine, coarse));
    EXPECT_TRUE(result.inside) << foot;
    expect_inside(at(fine, result.positions), coarse);
  }
}

TEST(Flow, EndsWhereItCannotSucceed) {
  const TriangleMesh fine = shapes::rounded(shapes::torus(1, 0.2, 24, 12));
  const TriangleMesh coarse = shapes::moved(shapes::scaled(shapes::torus(1, 0.2, 24, 12), 0.001), Point(5, 5, 5));
  const FlowResult result = flow(request(fine, coarse));
  EXPECT_FALSE(result.inside);
  EXPECT_FALSE(result.stuck.empty());
  EXPECT_LE(result.history.steps(), 300);
}

TEST(Flow, HistoryHoldsEveryStep) {
  TriangleMesh fine = shapes::sphere(4);
  fine.vertices *= 1.0 / 3;  // not float32
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(2), 0.33);
  const FlowResult result = flow(request(fine, coarse));
  ASSERT_GT(result.history.steps(), 0);
  EXPECT_TRUE(same_bytes(result.history.at(0), fine.vertices));
  EXPECT_TRUE(same_bytes(result.history.at(result.history.steps()), result.positions));
  for (int s = 0; s < result.history.steps(); ++s) {
    EXPECT_FALSE(same_bytes(result.history.at(s), result.history.at(s + 1)));
  }
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    if (result.positions.row(v) == fine.vertices.row(v)) continue;
    for (int k = 0; k < 3; ++k) {
      const double x = result.positions(v, k);
      EXPECT_EQ(x, static_cast<double>(static_cast<float>(x)));
    }
  }
}

TEST(FlowHistory, KeepsOnlyWhatMoved) {
  Vertices start(3, 3);
  start << 0.1, 0.2, 0.3, 1, 2, 3, 4, 5, 6;
  FlowHistory history(start);
  EXPECT_EQ(history.steps(), 0);
  EXPECT_TRUE(same_bytes(history.at(0), start));
  history.push({1}, {Eigen::Vector3f(7, 8, 9)});
  history.push({0, 1}, {Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(2, 2, 2)});
  EXPECT_EQ(history.steps(), 2);
  EXPECT_EQ(history.at(1).row(0), start.row(0));
  EXPECT_EQ(history.at(1).row(1), Eigen::RowVector3d(7, 8, 9));
  EXPECT_EQ(history.at(2).row(1), Eigen::RowVector3d(2, 2, 2));
  EXPECT_EQ(history.at(2).row(2), start.row(2));
  EXPECT_EQ(history.bytes(), 9 * sizeof(double) + 3 * (sizeof(std::int32_t) + 3 * sizeof(float)));
}

TEST(Flow, GivesTheSameBytesForAnyNumberOfThreads) {
  const TriangleMesh fine = shapes::rounded(shapes::sphere(6));  // enough triangles for three threads
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(2), 0.99);
  FlowRequest asked = request(fine, coarse);
  const FlowResult one = flow(asked);
  EXPECT_TRUE(one.inside);
  for (const int threads : {2, 3}) {
    asked.threads = threads;
    const FlowResult many = flow(asked);
    ASSERT_EQ(many.history.steps(), one.history.steps());
    for (int s = 0; s <= one.history.steps(); ++s) {
      EXPECT_TRUE(same_bytes(many.history.at(s), one.history.at(s))) << threads << " threads, step " << s;
    }
  }
}

TEST(Flow, CanBeCancelled) {
  const TriangleMesh fine = shapes::sphere(4);
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(3), 0.98);
  FlowRequest asked = request(fine, coarse);
  int calls = 0;
  asked.check = [&] { ++calls; };
  flow(asked);
  EXPECT_GT(calls, 3);
  const int last = calls - 1;
  calls = 0;
  asked.check = [&] {
    if (calls++ == last) throw Cancelled();
  };
  EXPECT_THROW(flow(asked), Cancelled);
}

TEST(Flow, NeedsACoarseMesh) {
  const TriangleMesh fine = shapes::sphere(1);
  const TriangleMesh nothing;
  EXPECT_THROW(flow(request(fine, nothing)), Error);
}

}  // namespace
}  // namespace encage::makers
