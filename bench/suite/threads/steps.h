// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>
#include <encage/world.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace encage::threads {

struct StepsOptions {
  std::int64_t every = 1;   ///< takes every K-th step only
  int copies = 1;           ///< the recorded bodies so many times side by side, out of each other's reach
  bool continuous = false;  ///< each body moves to where it is in the next recorded step; otherwise it rests
};

/// What all bodies do in one step.
using WorldStep = std::vector<Motion>;

/// Of those recorded steps, at least one, that have most bodies.
std::vector<WorldStep> make_steps(const std::vector<PoseStep>& recorded, const Shape& shape,
                                  const StepsOptions& options);

/// All that a search gives.
struct SearchResult {
  struct Found {
    BodyId a, b;
    Stage stage;
    std::int16_t level;
    std::vector<std::pair<std::int32_t, std::int32_t>> triangles;
    bool operator==(const Found&) const = default;
  };
  std::vector<Found> found;
  std::array<std::int64_t, 7> counts{};
  bool operator==(const SearchResult&) const = default;
};

/// Wall-clock milliseconds of one step.
struct StepTime {
  double update = 0;  ///< setting all motions
  double search = 0;
};

/// A world of bodies of one shape that goes through steps.
class Walker {
 public:
  Walker(ShapePtr shape, const WorldStep& first, CandidateOptions options);

  /// The visitor does next to nothing.
  StepTime walk(const WorldStep& step);
  SearchResult walk_and_tell(const WorldStep& step);

 private:
  void move(const WorldStep& step);

  World world_;
  std::vector<BodyId> bodies_;
  CandidateOptions options_;
};

}  // namespace encage::threads
