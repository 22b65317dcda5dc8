// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twins/pair_kind.h"

namespace encage::twins {

void Tally::add(const Outcome& outcome) {
  ++pairs;
  rejected += outcome.rejected;
  missed += outcome.missed;
  close += outcome.close;
  if (!outcome.sampled) return;
  ++sampled;
  touching += outcome.truth == Truth::touching;
  within_margin += outcome.truth == Truth::within_margin;
  far += outcome.far;
  far_kept += outcome.far && !outcome.rejected;
}

void Tally::add(const Tally& other) {
  pairs += other.pairs;
  rejected += other.rejected;
  missed += other.missed;
  close += other.close;
  sampled += other.sampled;
  touching += other.touching;
  within_margin += other.within_margin;
  far += other.far;
  far_kept += other.far_kept;
}

Outcome ask_pair(const PairKind& kind, std::uint64_t salt, std::uint64_t seed, std::int64_t number) {
  // The numbers are mixed step by step, so that pairs with similar seeds and numbers have nothing in common.
  std::uint64_t mixed = test::SplitMix(seed)();
  mixed = test::SplitMix(mixed ^ salt)();
  test::TwinRandom random(test::SplitMix(mixed ^ static_cast<std::uint64_t>(number))());
  return kind.ask(random, number);
}

const std::vector<KindEntry>& all_kinds() {
  // The shares depend on the cost of a pair and on the number of possible faults.
  static const std::vector<KindEntry> kinds = {
      {"resting", 20, resting_pairs},
      {"moving", 12, moving_pairs},
      {"world", 3, world_pairs},
      {"candidates", 4, candidate_pairs},
      {"first-contact", 3, contact_pairs},
      {"half-space", 4, plane_pairs},
      {"box-gate", 8, gate_pairs},
      {"triangles", 14, triangle_pairs},
      {"moving-triangles", 8, moving_triangles},
      {"vertex-face", 10, vertex_faces},
      {"edge-edge", 10, edge_edges},
      {"points", 4, points},
      {"distance", 4, body_distances},
      {"triangle-distance", 10, triangle_distances},
  };
  return kinds;
}

}  // namespace encage::twins
