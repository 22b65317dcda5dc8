// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/chain.h"

#include <algorithm>
#include <utility>

namespace encage {

namespace {

Recipe uniform(Method method, const std::vector<std::int64_t>& faces, const std::vector<TriangleMesh>& coarse) {
  Recipe recipe;
  recipe.name = name(method);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    recipe.targets.push_back({method, faces[i], coarse.empty() ? nullptr : &coarse[i]});
  }
  return recipe;
}

std::string describe(std::size_t level, const LevelTarget& target) {
  return "level " + std::to_string(level + 1) + " (" + std::to_string(target.faces) + " faces)";
}

}  // namespace

std::vector<Recipe> recipes(const BakeOptions& options, const std::vector<std::int64_t>& faces,
                            const std::vector<TriangleMesh>& coarse) {
  // Only the flow can do with the user's meshes.
  if (!coarse.empty() || options.method == BakeMethod::flow) return {uniform(Method::flow, faces, coarse)};
  std::vector<Recipe> all = {uniform(Method::collapse, faces, {})};
  if (options.method == BakeMethod::automatic) all.push_back(uniform(Method::flow, faces, {}));
  return all;
}

Chain make_chain(LevelMaker& maker, const Recipe& recipe, const ChainRank& rank) {
  Chain chain;
  chain.name = recipe.name;
  const std::vector<LevelTarget>& targets = recipe.targets;
  LevelProgress progress;
  if (rank.count > 1) progress.chain = recipe.name;
  progress.share = 1.0 / static_cast<double>(rank.count * targets.size());
  std::size_t i = 0;
  const auto leave_out = [&] {
    chain.missing.assign(targets.begin() + static_cast<std::ptrdiff_t>(i), targets.end());
    return chain;
  };
  for (; i < targets.size(); ++i) {
    progress.may_give_up = rank.expendable || !chain.levels.empty();
    if (progress.may_give_up && maker.expired()) return leave_out();
    progress.done = static_cast<double>(rank.number * targets.size() + i) * progress.share;
    const MadeLevel* finer = chain.levels.empty() ? nullptr : &chain.levels.back();
    std::optional<MadeLevel> made = maker.make(finer, targets[i], progress, chain.failure);
    if (!made) {
      if (!chain.failure.empty()) chain.failure = describe(i, targets[i]) + ": " + chain.failure;
      return leave_out();
    }
    chain.levels.push_back(std::move(*made));
    const CageLevel& level = chain.levels.back().level;
    chain.volume += level.certificate.volume;
    // A level may come out with fewer faces than asked for, even fewer than the next.
    while (i + 1 < targets.size() && targets[i + 1].coarse == nullptr &&
           targets[i + 1].faces >= level.mesh.triangles.rows()) {
      ++i;
      chain.volume += level.certificate.volume;
      chain.skipped.push_back("level of " + std::to_string(targets[i].faces) +
                              " faces skipped: the one before is as coarse");
    }
  }
  chain.complete = true;
  return chain;
}

Chain best_chain(std::vector<Chain> chains) {
  const auto rank = [](const Chain& chain) {
    if (chain.complete) return 2;
    return chain.failure.empty() && !chain.levels.empty() ? 1 : 0;
  };
  const auto better = [&](const Chain& a, const Chain& b) {
    if (rank(a) != rank(b)) return rank(a) > rank(b);
    return a.complete ? a.volume < b.volume : a.levels.size() > b.levels.size();
  };
  return std::move(*std::min_element(chains.begin(), chains.end(), better));
}

}  // namespace encage
