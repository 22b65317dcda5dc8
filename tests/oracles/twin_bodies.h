// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What pair tests against brute force share: bodies, and random places where the answer is delicate.

#include "oracles/body.h"

#include <encage/shape.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace encage::test {

/// Every kind of small body that the twin tests mix: with and without cages and fine
/// mesh, with and without rounding of the fine mesh, large, small, scaled, hollow, far from 0. In a unit of 2^exponent.
std::vector<Body> twin_bodies(int exponent = 0);

/// The same kinds with 1,000 to 2,048 triangles.
std::vector<Body> large_twin_bodies(int exponent = 0);

/// The rate of rejects is asked where the fine meshes are there and both interiors known.
inline bool shows_rate(const Body& a, const Body& b) { return a.solid() && b.solid() && a.has_fine() && b.has_fine(); }

/// Steele et al. 2014, "Fast splittable pseudorandom number generators": a generator for every pair costs nothing.
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

/// Random numbers, poses and margins; one seed, one sequence.
class TwinRandom {
 public:
  explicit TwinRandom(std::uint64_t seed) : engine_(seed) {}

  unsigned below(unsigned count) { return static_cast<unsigned>(engine_() % count); }
  bool coin() { return below(2) == 0; }
  const Body& one_of(const std::vector<Body>& bodies) { return bodies[below(static_cast<unsigned>(bodies.size()))]; }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Eigen::Vector3d direction();
  /// In [-half, half]^3.
  Eigen::Vector3d point(double half);
  /// Up to 1e6 from the origin; some drift from rigid like poses integrated without care, up to what is accepted.
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
  SplitMix engine_;
};

}  // namespace encage::test
