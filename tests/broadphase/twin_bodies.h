// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What the twin tests of separated() share: bodies, and random places where the answer is delicate.

#include "tests/broadphase/body.h"

#include <encage/broadphase.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <utility>
#include <vector>

namespace encage::test {

/// Every kind of small body that the twin tests mix: with and without cages and fine
/// mesh, with and without rounding of the fine mesh, large, small, far from 0.
std::vector<Body> twin_bodies();

/// The same kinds with 1,000 to 2,048 triangles.
std::vector<Body> large_twin_bodies();

/// A number from the environment, for longer runs by hand.
inline int number_from(const char* variable, int usual) {
  const char* text = std::getenv(variable);
  return text ? std::atoi(text) : usual;
}

/// How much a twin test attacks, and what share of rejects it saw.
struct TwinFigures {
  int rejected = 0;  ///< proven apart
  int asked = 0;     ///< pairs of which the figures below tell
  int contacts = 0;  ///< that truly touch (or come within the margin, at rest) or are contained
  int far = 0;       ///< farther than margin + 1 % of the larger diagonal, of `shows_rate` pairs
  int far_kept = 0;  ///< of these, not proven apart

  /// As properties of the test.
  void record() const;
};

/// The rate of rejects is asked where the fine meshes are there and both interiors known.
inline bool shows_rate(const Body& a, const Body& b) { return a.solid() && b.solid() && a.has_fine() && b.has_fine(); }

/// Random numbers, poses and margins; one seed, one sequence.
class TwinRandom {
 public:
  explicit TwinRandom(unsigned seed) : engine_(seed) {}

  unsigned below(unsigned count) { return static_cast<unsigned>(engine_() % count); }
  const Body& one_of(const std::vector<Body>& bodies) { return bodies[below(static_cast<unsigned>(bodies.size()))]; }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Eigen::Vector3d direction();
  /// Up to 1e4 from the origin; some drift from rigid like poses integrated without care, up to what is accepted.
  Eigen::Isometry3d pose();
  /// 0 twice in three times, else 0.3 to 1e-8 of a's size, of which what is far beyond b's does not count.
  double margin(const Body& a, const Body& b) {
    return below(3) != 0 ? 0 : std::pow(10.0, -uniform(0.5, 8)) * std::min(a.diagonal(), 8 * b.diagonal());
  }
  Eigen::Matrix3d quarter_turns();
  /// Multiples of an eighth, up to 2.5.
  Eigen::Vector3d lattice_point();

  /// Anywhere on the source's surface, in the body's frame.
  Eigen::Vector3d surface_point(const Body& body);
  /// Where b's centre is when b, turned as in its pose, starts out from a: near a's centre, or so that points of both
  /// surfaces meet, which finds contacts between bodies of very different sizes.
  Eigen::Vector3d meeting_place(const Body& a, const Eigen::Isometry3d& pose_a, const Body& b,
                                const Eigen::Isometry3d& pose_b);

  /// Asks for an answer in [0, high] close to where it changes, on either side, at most 1e-2 of `size` and at least
  /// 1e-16 away or as close as bisection comes. If it has the same value at both ends: asks for `high`.
  template <class Answer>
  void near_change(Answer&& answer, double high, double size) {
    double low = 0;
    const bool at_low = answer(low);
    if (answer(high) == at_low) return;
    const double step = below(8) == 0 ? 0 : std::pow(10.0, -uniform(2, 16)) * size;
    for (int i = 0; i < 52 && high - low > step / 8; ++i) {
      const double middle = 0.5 * (low + high);
      (answer(middle) == at_low ? low : high) = middle;
    }
    answer(high + (below(2) == 0 ? step : -step));
  }

 private:
  std::minstd_rand engine_;
};

}  // namespace encage::test
