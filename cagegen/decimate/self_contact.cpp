// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/self_contact.h"

#include "cagegen/decimate/decimate.h"

#include <cmath>

namespace encage::makers {

SurfaceTree::SurfaceTree(const TriangleMesh& mesh) : mesh_(mesh), room_(bounds(mesh)) {
  const Point spare = room_.sizes();
  room_.min() -= spare;
  room_.max() += spare;
  rebuild();
}

void SurfaceTree::rebuild() {
  std::vector<Eigen::AlignedBox3d> boxes(static_cast<std::size_t>(mesh_.triangles.rows()));
  for (std::int64_t t = 0; t < mesh_.triangles.rows(); ++t) {
    if (mesh_.triangles(t, 0) < 0) continue;
    for (const Point& p : corners(mesh_, t)) boxes[static_cast<std::size_t>(t)].extend(p);
  }
  tree_.build(boxes);
}

void SurfaceTree::update(std::int32_t triangle) {
  Eigen::AlignedBox3d box;
  for (const Point& p : corners(mesh_, triangle)) box.extend(p);
  tree_.update(triangle, box);
}

BoxFilter SurfaceTree::filter(const Prism& prism, double gap) const {
  Eigen::AlignedBox3d box;
  for (const Point& p : prism.corner) box.extend(p);
  box.min().array() -= gap;
  box.max().array() += gap;
  BoxFilter filter(box, std::max(room_.min().cwiseAbs().maxCoeff(), room_.max().cwiseAbs().maxCoeff()));
  // Of all corners: a sliver's normal may be any direction.
  const Point level(prism.normal.dot(prism.corner[0]), prism.normal.dot(prism.corner[1]),
                    prism.normal.dot(prism.corner[2]));
  filter.below(prism.normal, level.maxCoeff() + gap);
  filter.below(-prism.normal, -level.minCoeff() + gap);
  return filter;
}

BoxFilter SurfaceTree::ray_filter(const Point& start, const Point& direction) const {
  Eigen::AlignedBox3d box(start);
  box.extend(start + 2 * room_.diagonal().norm() * direction.normalized());
  BoxFilter filter(box, std::max(room_.min().cwiseAbs().maxCoeff(), room_.max().cwiseAbs().maxCoeff()));
  const Point side = direction.unitOrthogonal();
  const Point other = direction.normalized().cross(side);
  for (const Point& normal : {side, other}) {
    filter.below(normal, normal.dot(start));
    filter.below(-normal, -normal.dot(start));
  }
  return filter;
}

std::vector<TrianglePair> self_contacts(const TriangleMesh& mesh, double gap) {
  const SurfaceTree tree(mesh);
  std::vector<TrianglePair> found;
  for (std::int32_t s = 0; s < mesh.triangles.rows(); ++s) {
    const Prism prism(corners(mesh, s));
    if (!prism.valid) {
      found.push_back({s, s});
      continue;
    }
    tree.near(prism, gap, [&](std::int32_t t) {
      if (t <= s) return;
      if (!separated(indices(mesh, s), prism.corner, indices(mesh, t), corners(mesh, t), gap)) found.push_back({s, t});
    });
  }
  return found;
}

}  // namespace encage::makers
