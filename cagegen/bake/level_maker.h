// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/threads/control.h"
#include "cagegen/threads/journal.h"

#include <encage/bake.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace encage {

/// A certified level, with what the next level needs.
struct MadeLevel {
  CageLevel level;
  /// The coarse mesh as decimated, before flow and re-inflation; empty if the level was made by collapse.
  TriangleMesh undeformed;
  BakeReport::Level times;
};

struct LevelTarget {
  std::int64_t faces = 0;
  const TriangleMesh* coarse = nullptr;  ///< of the flow: made by the user, local frame
  std::size_t coarser = 0;               ///< levels that will follow
};

/// Which part of the whole bake a level is.
struct LevelProgress {
  double done = 0;   ///< fraction of the bake before this level
  double share = 1;  ///< fraction of the bake that this level takes
};

/// Makes levels one by one, on a thread of its own, while the caller's functions are called from the caller's thread.
class LevelMaker {
 public:
  LevelMaker(const SourceMesh& source, const BakeOptions& options, const BakeContext& context);

  /// Makes the level around `finer`, or around the source if that is null. Returns no value if the level failed, and
  /// `failure` says why, or if time is up, and `failure` is empty. Throws Cancelled, and what the caller's functions
  /// throw.
  std::optional<MadeLevel> make(const MadeLevel* finer, const LevelTarget& target, const LevelProgress& progress,
                                std::string& failure);

  bool expired() { return control_.expired(); }
  int threads() const { return threads_; }
  bool out_of_time() const { return control_.out_of_time; }

 private:
  const SourceMesh& source_;
  const BakeOptions& options_;
  const BakeContext& context_;
  makers::Control control_;
  int threads_ = 1;
  double shown_ = 0;
  Journal journal_;
};

}  // namespace encage
