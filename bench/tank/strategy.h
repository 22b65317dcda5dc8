// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/recording.h"
#include "bench/tank/sweep.h"

#include <encage/contact.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace encage::tank {

/// The body of which a tank holds many copies: as Encage's run time sees it, and its triangles.
struct TankBody {
  ShapePtr shape;
  BodyMesh mesh;
  double fine_error = 0;  ///< CageHierarchy::fine_error
};

/// Throws Error if the hierarchy has no fine mesh or no cage, or is malformed.
TankBody make_tank_body(CageHierarchy hierarchy);

/// Indices of two bodies of a step, a < b; hence also by increasing body number.
struct IndexPair {
  std::int32_t a = 0, b = 0;
  friend auto operator<=>(const IndexPair&, const IndexPair&) = default;
};

struct StrategyOptions {
  ContactOptions contact;
  /// Cage levels asked, 0 the finest. One tight level beats chains (measured: with 8,000 faces).
  int finest_cage = 0, coarsest_cage = 0;
};

/// Pairs of bodies of a step that are left over after each stage.
struct StageCounts {
  std::int64_t pairs = 0;  ///< all but those left out
  std::int64_t boxes = 0;  ///< world boxes of the motions overlap
  std::int64_t cages = 0;  ///< cages are not proven apart during the motion; = boxes if not asked
  std::int64_t touching = 0;

  StageCounts& operator+=(const StageCounts& other);
};

/// What the body-pair stages leave for the triangles.
struct Survivors {
  StageCounts counts;
  std::vector<IndexPair> pairs;  ///< sorted
  /// Bodies of `pairs`, each once: those whose trees must be rebuilt where trees are rebuilt.
  std::vector<std::int32_t> bodies;
};

/// The stages on pairs of bodies: overlapping world boxes of the motions, then, if asked, cages. A pair that is
/// rejected cannot have a contact by StrategyOptions::contact.
class PairFilter {
 public:
  /// `body` has to outlive this.
  PairFilter(const TankBody& body, bool cages, const StrategyOptions& options);

  /// `left_out` is sorted; its pairs are not asked at all.
  Survivors run(const bench::RecordedStep& step, const std::vector<IndexPair>& left_out = {}) const;

 private:
  const TankBody& body_;
  bool cages_;
  double distance_;  ///< proves absence of contact, but for rounding
  PairOptions cage_options_;
};

/// Finds the first contact of each surviving pair.
class ContactFinder {
 public:
  virtual ~ContactFinder() = default;
  /// One entry a pair, in their order.
  virtual std::vector<std::optional<Contact>> find(const bench::RecordedStep& step, const Survivors& survivors) = 0;
};

struct BodyContact {
  std::int32_t body_a = 0, body_b = 0;  ///< body numbers, a < b
  Contact contact;
};

struct Detection {
  StageCounts counts;
  std::int64_t bodies = 0;            ///< as Survivors::bodies
  std::vector<BodyContact> contacts;  ///< sorted by (body_a, body_b)
};

/// One way to detect collisions: boxes, cages or not, and a contact finder. Not for use by several threads.
class Strategy {
 public:
  Strategy(std::string name, PairFilter filter, std::unique_ptr<ContactFinder> finder)
      : name_(std::move(name)), filter_(std::move(filter)), finder_(std::move(finder)) {}

  const std::string& name() const { return name_; }
  const PairFilter& filter() const { return filter_; }
  Detection detect(const bench::RecordedStep& step, const std::vector<IndexPair>& left_out = {});

 private:
  std::string name_;
  PairFilter filter_;
  std::unique_ptr<ContactFinder> finder_;
};

enum class Baseline {
  rebuild_kdop,    ///< the paper: 26-DOP trees of swept triangles, built in every step
  rebuild_embree,  ///< Embree's fastest builder instead
  prebuilt,        ///< Encage's body-frame trees, built once
};

const char* name(Baseline baseline) noexcept;

/// Named after the baseline, with "+cages" appended for CageUse::always, "+policy" for CageUse::automatic. `body` has
/// to outlive it.
Strategy make_strategy(const TankBody& body, Baseline baseline, CageUse cages, const StrategyOptions& options = {});

}  // namespace encage::tank
