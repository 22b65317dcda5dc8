// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Shared by pair tests against brute force: bodies, and random positions close to where the answer changes.

#include "oracles/body.h"

#include <encage/shape.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace encage::test {

/// Every kind of small body that the pair tests mix: with and without cages and fine mesh, with and without rounding of
/// the fine mesh, large, small, scaled, hollow, far from 0. The unit is 2^exponent.
std::vector<Body> twin_bodies(int exponent = 0);

/// The same kinds with 1,000 to 2,048 triangles.
std::vector<Body> large_twin_bodies(int exponent = 0);

/// True if the rate of rejects is tested for the pair: both fine meshes exist and both interiors are known.
inline bool shows_rate(const Body& a, const Body& b) { return a.solid() && b.solid() && a.has_fine() && b.has_fine(); }

/// Steele et al. 2014, "Fast splittable pseudorandom number generators": creating a generator for every pair costs
/// almost nothing.
class SplitMix {
 public:
  using result_type = std::uint64_t;
  explicit SplitMix(std::uint64_t seed) : state_(seed) {}
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return ~std::uint64_t{0}; }
  result_type operator()() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
  }

 private:
  std::uint64_t state_;
};

/// Random numbers, poses and margins; one seed gives one sequence.
class TwinRandom {
 public:
  explicit TwinRandom(std::uint64_t seed) : engine_(seed) {}

  unsigned below(unsigned count) { return static_cast<unsigned>(engine_() % count); }
  bool coin() { return below(2) == 0; }
  const Body& one_of(const std::vector<Body>& bodies) { return bodies[below(static_cast<unsigned>(bodies.size()))]; }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Eigen::Vector3d direction();
  /// Returns a point in [-half, half]^3.
  Eigen::Vector3d point(double half);
  /// Returns a pose up to 1e6 from the origin. Some poses depart from rigid, like poses integrated without care, up to
  /// the accepted limit.
  Eigen::Isometry3d pose();
  /// Returns 0 two times in three, otherwise 0.3 to 1e-8 of a's size, which is capped at a multiple of b's.
  double margin(const Body& a, const Body& b) {
    return below(3) != 0 ? 0 : std::pow(10.0, -uniform(0.5, 8)) * std::min(a.diagonal(), 8 * b.diagonal());
  }
  Eigen::Matrix3d quarter_turns();
  /// Returns a point whose coordinates are multiples of an eighth, up to 2.5.
  Eigen::Vector3d lattice_point();

  /// Returns a point on the source's surface, in the body's frame.
  Eigen::Vector3d surface_point(const Body& body);
  /// Returns a position of b's centre at which b, turned as in its pose, starts out from a: near a's centre, or such
  /// that points of both surfaces meet, which finds contacts between bodies of very different sizes.
  Eigen::Vector3d meeting_place(const Body& a, const Eigen::Isometry3d& pose_a, const Body& b,
                                const Eigen::Isometry3d& pose_b);

  /// Calls answer(x) for an x in [0, high] close to where it changes, on either side of the change, at most 1e-2 of
  /// `size` and at least 1e-16 away or as close as bisection comes. If both ends have the same answer, it calls
  /// answer(high).
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
  SplitMix engine_;
};

}  // namespace encage::test
