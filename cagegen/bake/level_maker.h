// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"
#include "cagegen/threads/control.h"
#include "cagegen/threads/journal.h"

#include <encage/bake.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace encage {

/// One level, certified, and what the next one of the same chain needs to know of it.
struct MadeLevel {
  CageLevel level;
  /// The coarse mesh as its decimation made it, before the flow and re-inflation; empty if made by collapse.
  TriangleMesh undeformed;
  BakeReport::Level times;
};

struct LevelTarget {
  Method method = Method::collapse;  ///< hull: the source is too small for the others
  std::int64_t faces = 0;
  const TriangleMesh* coarse = nullptr;  ///< of the flow: made by the user, local frame
};

/// Where on the way of the whole bake a level stands.
struct LevelProgress {
  std::string chain;  ///< what messages begin with; empty if there is but one
  double done = 0;    ///< fraction of the bake before this level
  double share = 1;   ///< fraction that this level is
  /// There is something to return already, hence a level of the flow may be left unfinished when time is up.
  bool may_give_up = false;
};

/// Makes levels one by one, on a thread of its own, while the caller's functions are called from the caller's thread.
class LevelMaker {
 public:
  LevelMaker(const SourceMesh& source, const BakeOptions& options, const BakeContext& context);

  /// The level around `finer`, or around the source if that is null. No value if it failed: `failure` says why; or if
  /// time is up, which leaves `failure` empty. Throws Cancelled, and what the caller's functions throw.
  std::optional<MadeLevel> make(const MadeLevel* finer, const LevelTarget& target, const LevelProgress& progress,
                                std::string& failure);

  bool expired() { return control_.expired(); }
  bool out_of_time() const { return control_.out_of_time; }

 private:
  void work(const MadeLevel* finer, const LevelTarget& target, MadeLevel& made, std::string& failure);
  makers::LevelResult make_by(Method method, const makers::Obstacle& obstacle, const makers::LevelRequest& request,
                              const MadeLevel* finer, const TriangleMesh* coarse);
  std::optional<Certificate> accept(const TriangleMesh& inner, Solid solid, const makers::Candidate& candidate);

  const SourceMesh& source_;
  const BakeOptions& options_;
  const BakeContext& context_;
  makers::Control control_;
  int threads_ = 1;
  double shown_ = 0;
  Journal journal_;
};

}  // namespace encage
