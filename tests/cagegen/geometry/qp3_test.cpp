// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/qp3.h"

#include "tests/cagegen/geometry/shapes.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace encage::makers {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using shapes::Random;

double objective(const Matrix3d& a, const Vector3d& b, const Vector3d& p) { return 0.5 * p.dot(a * p) - b.dot(p); }

double worst_violation(const std::vector<LinearConstraint>& constraints, const Vector3d& p) {
  double worst = 0;
  for (const LinearConstraint& c : constraints) worst = std::max(worst, c.offset - c.normal.dot(p));
  return worst;
}

/// The best point over all sets of up to three active constraints that satisfies all within `slack`.
std::optional<Vector3d> brute_force(const Matrix3d& a, const Vector3d& b,
                                    const std::vector<LinearConstraint>& constraints, double slack) {
  std::optional<Vector3d> best;
  std::vector<std::size_t> active;
  const auto attempt = [&] {
    const Eigen::Index n = static_cast<Eigen::Index>(active.size());
    Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(3 + n, 3 + n);
    Eigen::VectorXd right(3 + n);
    kkt.topLeftCorner(3, 3) = a;
    right.head(3) = b;
    for (Eigen::Index i = 0; i < n; ++i) {
      kkt.block(3 + i, 0, 1, 3) = constraints[active[i]].normal.transpose();
      kkt.block(0, 3 + i, 3, 1) = constraints[active[i]].normal;
      right[3 + i] = constraints[active[i]].offset;
    }
    const Eigen::FullPivLU<Eigen::MatrixXd> factor(kkt);
    if (!factor.isInvertible()) return;
    const Vector3d p = factor.solve(right).head(3);
    if (worst_violation(constraints, p) > slack) return;
    if (!best || objective(a, b, p) < objective(a, b, *best)) best = p;
  };
  const std::size_t count = constraints.size();
  attempt();
  for (std::size_t i = 0; i < count; ++i) {
    active = {i};
    attempt();
    for (std::size_t j = 0; j < i; ++j) {
      active = {i, j};
      attempt();
      for (std::size_t k = 0; k < j; ++k) {
        active = {i, j, k};
        attempt();
      }
    }
  }
  return best;
}

Matrix3d random_matrix(Random& random, double condition) {
  Matrix3d m;
  for (int k = 0; k < 3; ++k) m.col(k) = random.point(1);
  return m * m.transpose() + Matrix3d::Identity() / condition;
}

std::vector<LinearConstraint> random_constraints(Random& random, int count) {
  std::vector<LinearConstraint> constraints;
  for (int i = 0; i < count; ++i) {
    LinearConstraint c{random.point(1).normalized(), random(-1.5, 0.6)};
    if (i > 0) {
      const LinearConstraint& other = constraints[random.integer(i)];
      switch (random.integer(8)) {
        case 0: c = other; break;                                                              // the same again
        case 1: c = {other.normal, other.offset + random(-0.5, 0.5)}; break;                   // redundant
        case 2: c = {-other.normal, -other.offset + random(-0.6, 0.2)}; break;                 // a slab, often empty
        case 3: c = {(-other.normal + random.point(0.1)).normalized(), -other.offset}; break;  // a thin wedge
        default: break;
      }
    }
    constraints.push_back(c);
  }
  return constraints;
}

TEST(SolveQp, AgreesWithAllActiveSets) {
  Random random(11);
  int solved = 0;
  int infeasible = 0;
  for (int i = 0; i < 3000; ++i) {
    const Matrix3d a = random_matrix(random, i % 3 == 0 ? 1e3 : 1);
    const Vector3d b = random.point(2);
    const std::vector<LinearConstraint> constraints = random_constraints(random, random.integer(9));
    const auto found = solve_qp(a, b, constraints);
    // Problems that a shift of the planes by this much would decide otherwise have no definite answer.
    constexpr double margin = 1e-6;
    std::vector<LinearConstraint> tighter = constraints;
    std::vector<LinearConstraint> looser = constraints;
    for (std::size_t k = 0; k < constraints.size(); ++k) {
      tighter[k].offset += margin;
      looser[k].offset -= margin;
    }
    if (const auto inner = brute_force(a, b, tighter, 1e-9)) {
      ++solved;
      ASSERT_TRUE(found) << i;
      EXPECT_LE(worst_violation(constraints, *found), 1e-6) << i;
      EXPECT_LE(objective(a, b, *found), objective(a, b, *inner) + 1e-6) << i;
      const auto outer = brute_force(a, b, looser, 1e-9);
      ASSERT_TRUE(outer);
      EXPECT_GE(objective(a, b, *found), objective(a, b, *outer) - 1e-6) << i;
    } else if (!brute_force(a, b, looser, 1e-9)) {
      ++infeasible;
      EXPECT_FALSE(found) << i;
    }
  }
  EXPECT_GT(solved, 1000);
  EXPECT_GT(infeasible, 300);
}

TEST(SolveQp, KnownAnswers) {
  const Matrix3d one = Matrix3d::Identity();
  const auto solve = [&](const Vector3d& b, std::vector<LinearConstraint> constraints) {
    return solve_qp(one, b, constraints);
  };
  EXPECT_EQ(*solve({1, 2, 3}, {}), Vector3d(1, 2, 3));
  EXPECT_EQ(*solve({0, 0, 0}, {{{0, 0, 2}, -1}}), Vector3d(0, 0, 0)) << "not active";
  EXPECT_TRUE(solve({0, 0, 0}, {{{0, 0, 2}, 1}})->isApprox(Vector3d(0, 0, 0.5)));
  EXPECT_TRUE(solve({0, 0, 0}, {{{1, 0, 0}, 1}, {{0, 1, 0}, 2}})->isApprox(Vector3d(1, 2, 0)));
  EXPECT_TRUE(solve({9, 9, 9}, {{{-1, 0, 0}, -1}, {{0, -1, 0}, -2}, {{0, 0, -1}, -3}})->isApprox(Vector3d(1, 2, 3)));
  EXPECT_FALSE(solve({0, 0, 0}, {{{1, 0, 0}, 1}, {{-1, 0, 0}, 1}}));
  // Three planes through a line, the fourth across.
  EXPECT_TRUE(
      solve({0, 0, -5}, {{{1, 0, 0}, 1}, {{0, 1, 0}, 1}, {{1, 1, 0}, 2}, {{0, 0, 1}, 4}})->isApprox(Vector3d(1, 1, 4)));
  // A constraint without a direction says nothing.
  EXPECT_EQ(*solve({1, 2, 3}, {{{0, 0, 0}, 5}}), Vector3d(1, 2, 3));
  EXPECT_FALSE(solve_qp(Matrix3d::Zero(), {0, 0, 0}, {})) << "not positive definite";
}

TEST(SolveQp, ScalesWithTheProblem) {
  Random random(12);
  for (const double scale : {1e-20, 1e-6, 1e6, 1e20}) {
    for (int i = 0; i < 200; ++i) {
      const Matrix3d a = random_matrix(random, 10);
      const Vector3d b = random.point(2);
      std::vector<LinearConstraint> constraints = random_constraints(random, 4);
      const auto unit = solve_qp(a, b, constraints);
      for (LinearConstraint& c : constraints) c.offset *= scale;
      const auto scaled = solve_qp(a, b * scale, constraints);
      ASSERT_EQ(unit.has_value(), scaled.has_value());
      EXPECT_LT((scaled.value_or(Vector3d::Zero()) / scale - unit.value_or(Vector3d::Zero())).norm(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace encage::makers
