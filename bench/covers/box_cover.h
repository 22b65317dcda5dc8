// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/covers/cut_tree.h"
#include "broadphase/separation/surface_pair.h"

namespace encage::covers {

/// The top of a surface's own tree, whose last boxes stand for what is in them.
class BoxCover {
 public:
  BoxCover(const Surface& surface, std::int64_t boxes);

  const MeshTree& tree() const { return tree_; }
  std::int64_t boxes() const { return boxes_; }
  std::size_t bytes() const { return tree_.nodes.size() * sizeof(MeshNode); }

 private:
  MeshTree tree_;
  std::int64_t boxes_ = 0;
};

/// True only if the surfaces are proven to stay farther apart than `distance`, which covers rounding, as for
/// surfaces_apart(). `a`, `b`: covers of `surface_a`, `surface_b`.
bool covers_apart(const BoxCover& a, const Surface& surface_a, const BoxCover& b, const Surface& surface_b,
                  const PairMotion& motion, double distance);

}  // namespace encage::covers
