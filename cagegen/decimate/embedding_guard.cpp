// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/embedding_guard.h"

#include <algorithm>

namespace encage::makers {

bool EmbeddingGuard::allows(std::int32_t from, std::int32_t to, std::span<const std::int32_t> star,
                            std::span<const std::int32_t> lost, const Point& position) {
  std::vector<std::array<std::int32_t, 3>> index;
  std::vector<Prism> prism;
  for (const std::int32_t t : star) {
    index.push_back(indices(mesh_, t));
    Corners corner = corners(mesh_, t);
    for (int k = 0; k < 3; ++k) {
      if (index.back()[k] != from && index.back()[k] != to) continue;
      index.back()[k] = to;
      corner[k] = position;
    }
    prism.emplace_back(corner);
    if (!prism.back().valid) return false;
  }
  for (std::size_t i = 0; i < star.size(); ++i) {
    for (std::size_t j = i + 1; j < star.size(); ++j) {
      if (!separated(index[i], prism[i].corner, index[j], prism[j].corner, gap_)) return false;
    }
  }
  const auto replaced = [&](std::int32_t t) {
    return std::find(star.begin(), star.end(), t) != star.end() || std::find(lost.begin(), lost.end(), t) != lost.end();
  };
  for (std::size_t i = 0; i < star.size(); ++i) {
    bool free = true;
    tree_.near(prism[i], gap_, [&](std::int32_t t) {
      if (!free || replaced(t)) return;
      free = separated(index[i], prism[i].corner, indices(mesh_, t), corners(mesh_, t), gap_);
    });
    if (!free) return false;
  }
  return true;
}

void EmbeddingGuard::collapsed(std::int32_t gone, std::int32_t kept, std::span<const std::int32_t> star,
                               std::span<const std::int32_t> lost, const Point& position) {
  mesh_.vertices.row(kept) = position.transpose();
  for (const std::int32_t t : lost) {
    tree_.remove(t);
    mesh_.triangles.row(t).setConstant(-1);
  }
  for (const std::int32_t t : star) {
    for (int k = 0; k < 3; ++k) {
      if (mesh_.triangles(t, k) == gone) mesh_.triangles(t, k) = kept;
    }
    tree_.update(t);
  }
  // Boxes only grow: tight ones again, now and then.
  live_ -= static_cast<std::int64_t>(lost.size());
  if (++changes_ <= live_ / 8) return;
  changes_ = 0;
  tree_.rebuild();
}

}  // namespace encage::makers
