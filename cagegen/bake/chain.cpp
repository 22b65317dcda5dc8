// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/chain.h"

#include <utility>

namespace encage {

Chain make_chain(LevelMaker& maker, const std::vector<LevelTarget>& targets) {
  Chain chain;
  LevelProgress progress;
  progress.share = 1.0 / static_cast<double>(targets.size());
  std::size_t i = 0;
  const auto leave_out = [&] {
    chain.missing.assign(targets.begin() + static_cast<std::ptrdiff_t>(i), targets.end());
    return chain;
  };
  for (; i < targets.size(); ++i) {
    if (!chain.levels.empty() && maker.expired()) return leave_out();
    progress.done = static_cast<double>(i) * progress.share;
    const MadeLevel* finer = chain.levels.empty() ? nullptr : &chain.levels.back();
    std::optional<MadeLevel> made = maker.make(finer, targets[i], progress, chain.failure);
    if (!made) {
      if (!chain.failure.empty()) {
        chain.failure =
            "level " + std::to_string(i + 1) + " (" + std::to_string(targets[i].faces) + " faces): " + chain.failure;
      }
      return leave_out();
    }
    chain.levels.push_back(std::move(*made));
    // A level may come out with fewer faces than asked for, even fewer than the next.
    const std::int64_t count = chain.levels.back().level.mesh.triangles.rows();
    while (i + 1 < targets.size() && targets[i + 1].coarse == nullptr && targets[i + 1].faces >= count) {
      ++i;
      chain.skipped.push_back("level of " + std::to_string(targets[i].faces) +
                              " faces skipped: the one before is as coarse");
    }
  }
  return chain;
}

}  // namespace encage
