// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Pair tests against brute force: random and adversarial pairs, of which the truth is known exactly.

#include "oracles/twin_bodies.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace encage::twins {

enum class Truth : std::uint8_t {
  unknown,        ///< not looked for
  apart,          ///< farther apart than the margin
  within_margin,  ///< no contact, but not farther than the margin
  touching,       ///< in contact, or one inside the other
};

/// What one pair showed.
struct Outcome {
  bool rejected = false;  ///< the code under test says: apart
  bool missed = false;    ///< wrongly so
  bool close = false;     ///< rejected, but no longer with 1e-4 of the bodies' size more; of bodies only
  /// Looked for whether the pair was rejected or not: such pairs tell how common the answers are.
  bool sampled = false;
  Truth truth = Truth::unknown;  ///< of sampled pairs
  /// Of sampled pairs: farther apart than the margin by so much that it should be rejected.
  bool far = false;
  std::string what{};  ///< describes the pair, if missed
};

/// Sums over pairs, in any order.
struct Tally {
  std::int64_t pairs = 0, rejected = 0, missed = 0, close = 0, sampled = 0;
  std::int64_t touching = 0, within_margin = 0, far = 0, far_kept = 0;  ///< of the sampled ones

  void add(const Outcome& outcome);
  void add(const Tally& other);
};

/// A way to make pairs and to know the truth about them. ask() may be called by several threads at a time.
class PairKind {
 public:
  virtual ~PairKind() = default;
  /// The pair depends on `random` and the number alone.
  virtual Outcome ask(test::TwinRandom& random, std::int64_t number) const = 0;
};

/// Asks about pair `number` of a seed; `salt` tells kinds apart.
Outcome ask_pair(const PairKind& kind, std::uint64_t salt, std::uint64_t seed, std::int64_t number);

std::unique_ptr<PairKind> resting_pairs();       ///< separated() at rest
std::unique_ptr<PairKind> moving_pairs();        ///< separated() during a step
std::unique_ptr<PairKind> world_pairs();         ///< World::find_candidates()
std::unique_ptr<PairKind> candidate_pairs();     ///< for_each_triangle_pair(), at rest and during a step
std::unique_ptr<PairKind> contact_pairs();       ///< first_contact()
std::unique_ptr<PairKind> plane_pairs();         ///< separated() and first_contact() of a half-space
std::unique_ptr<PairKind> gate_pairs();          ///< BoxGate
std::unique_ptr<PairKind> triangle_pairs();      ///< triangles_apart()
std::unique_ptr<PairKind> moving_triangles();    ///< moving_triangles_apart(), lanes_not_apart()
std::unique_ptr<PairKind> vertex_faces();        ///< vertex_face_time()
std::unique_ptr<PairKind> edge_edges();          ///< edge_edge_time()
std::unique_ptr<PairKind> points();              ///< locate(): point in solid
std::unique_ptr<PairKind> body_distances();      ///< distance(), cage_distance_bound()
std::unique_ptr<PairKind> triangle_distances();  ///< triangle_distance()

/// A kind and its share of the pairs.
struct KindEntry {
  std::string name;
  int share = 0;  ///< of the sum of all shares
  std::unique_ptr<PairKind> (*make)() = nullptr;
};

/// All of them, in the order of reports. Names and order are stable: they are part of what a seed means.
const std::vector<KindEntry>& all_kinds();

}  // namespace encage::twins
