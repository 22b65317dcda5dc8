// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Two bodies at rest or during a step, mostly close to where the answer of some query changes, and their truth.

#include "oracles/twin_bodies.h"
#include "oracles/twins/pair_kind.h"

#include <encage/separated.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace encage::twins {

struct Scene {
  const test::Body* a = nullptr;
  const test::Body* b = nullptr;
  Motion motion_a, motion_b;
  double margin = 0;
  double unit = 1;  ///< of lengths; a power of two

  double size() const { return (a->diagonal() + b->diagonal()) / 2; }
  /// A distance so large, compared with the bodies, that queries must recognise a larger one.
  double one_per_cent() const { return 0.01 * std::max(a->diagonal(), b->diagonal()); }
  /// Runs every stage that may reject.
  Verdict ask(double more = 0) const {
    return separated(*a->shape, motion_a, *b->shape, motion_b, {.margin = margin + more, .cages = CageUse::always});
  }
  /// True if numbers are in range and rounding is far below 1 %: a pose may depart from rigid by 2.5e-10 of its
  /// distance.
  bool well_conditioned() const { return unit < 0x1p90 && motion_a.start.translation().norm() < 1e5 * unit; }
  std::string text() const;
};

/// Makes scenes of all small bodies; every 64th pair has a large one, every 512th has two.
class Scenes {
 public:
  enum class Bodies { all, with_fine_mesh };
  /// `large` is false if there must be no large bodies.
  Scenes(Bodies bodies, bool large);

  /// True if the query under test rejects the scene; the scenes search for positions where that changes.
  using Query = std::function<bool(const Scene&)>;
  Scene resting(test::TwinRandom& random, std::int64_t number, const Query& query) const;
  Scene moving(test::TwinRandom& random, std::int64_t number, const Query& query) const;

 private:
  struct InUnit {
    double unit;
    std::vector<test::Body> small, large;
  };
  Scene start(test::TwinRandom& random, std::int64_t number) const;

  std::vector<InUnit> units_;  ///< the usual unit, a tiny and a huge one
};

/// Exact brute force for bodies at rest. The bodies are the sources, not the stored meshes.
class RestingTruth {
 public:
  explicit RestingTruth(const Scene& scene);
  ~RestingTruth();
  RestingTruth(const RestingTruth&) = delete;
  RestingTruth& operator=(const RestingTruth&) = delete;

  bool within_margin() const;  ///< also true in contact or containment
  Truth truth() const;
  bool farther(double more) const;  ///< farther apart than the margin plus `more`
  /// True if triangles i of a and j of b are no farther apart than the margin.
  bool triangles_near(std::int64_t i, std::int64_t j) const;
  bool surfaces_near(double distance) const;
  /// True if one body contains a part of the other. The surfaces must not meet.
  bool held() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Brute force for a step: exact times of contact; with a margin, sampled distances. The vertices' positions are
/// rounded; queries reject only bodies that are farther apart than that rounding.
class MovingTruth {
 public:
  enum class Meshes { sources, fine };
  explicit MovingTruth(const Scene& scene, Meshes meshes = Meshes::sources);
  ~MovingTruth();
  MovingTruth(const MovingTruth&) = delete;
  MovingTruth& operator=(const MovingTruth&) = delete;

  Truth truth() const;              ///< never Truth::unknown
  bool farther(double more) const;  ///< proven farther apart than the margin plus `more` throughout
  /// The same for the surfaces alone: a body inside the other is apart.
  Truth surface_truth() const;
  bool surfaces_farther(double more) const;
  /// True if some pair of triangles comes within the margin and is not among the `known` ones (i * triangles of b + j).
  bool near_triangles_but(const std::vector<bool>& known) const;
  /// Upper bound of the first time of contact; more than 1 if there is none, 0 if the bodies intersect at the start.
  double latest_first_contact() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Returns a random motion of one body during a step.
Motion random_motion(test::TwinRandom& random, const test::Body& body, const Eigen::Isometry3d& start);

/// Moves the whole motion so that the body's centre starts at `where`.
void place(const test::Body& body, Motion& motion, const Eigen::Vector3d& where);

}  // namespace encage::twins
