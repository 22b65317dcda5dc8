// SPDX-License-Identifier: Apache-2.0
// Corners of the triangles of a leaf, side by side (contact/nearest_point.cpp, query/ray_search.cpp). Compiled once for
// every instruction set: include it after <hwy/foreach_target.h>.

#include "src/mesh/mesh_view.h"
#include "src/tree/mesh_tree.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#if defined(ENCAGE_LEAF_CORNERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ENCAGE_LEAF_CORNERS_INL_H
#undef ENCAGE_LEAF_CORNERS_INL_H
#else
#define ENCAGE_LEAF_CORNERS_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using LeafTag = hn::CappedTag<double, MeshTree::leaf_size>;
using LeafVec = hn::Vec<LeafTag>;

/// Corners of one to four triangles; the last one fills the lanes that are left.
struct LeafCorners {
  alignas(16) std::array<std::array<std::array<float, MeshTree::leaf_size>, 3>, 3> c;  ///< corner, axis, triangle

  HWY_INLINE LeafCorners(const MeshView& mesh, std::span<const LeafTriangle> triangles) {
    const std::size_t last = triangles.size() - 1;
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t lane = 0; lane < MeshTree::leaf_size; ++lane) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(triangles[std::min(lane, last)].vertices[k]);
        for (std::size_t axis = 0; axis < 3; ++axis) c[k][axis][lane] = mesh.vertices[v][axis];
      }
    }
#else
    const hn::FixedTag<float, 4> d;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v0 = vertex(mesh, triangles[0].vertices[k]);
      const auto v1 = vertex(mesh, triangles[std::min<std::size_t>(1, last)].vertices[k]);
      const auto v2 = vertex(mesh, triangles[std::min<std::size_t>(2, last)].vertices[k]);
      const auto v3 = vertex(mesh, triangles[std::min<std::size_t>(3, last)].vertices[k]);
      const auto even = hn::InterleaveLower(d, v0, v2), odd = hn::InterleaveLower(d, v1, v3);
      hn::Store(hn::InterleaveLower(d, even, odd), d, c[k][0].data());
      hn::Store(hn::InterleaveUpper(d, even, odd), d, c[k][1].data());
      hn::Store(hn::InterleaveLower(d, hn::InterleaveUpper(d, v0, v2), hn::InterleaveUpper(d, v1, v3)), d,
                c[k][2].data());
    }
#endif
  }

  /// One coordinate of the corners k of the triangles from `first` on.
  HWY_INLINE LeafVec load(std::size_t k, std::size_t axis, std::size_t first) const {
    const LeafTag d;
    const hn::Rebind<float, LeafTag> narrow;
    return hn::PromoteTo(d, hn::LoadU(narrow, c[k][axis].data() + first));
  }

#if HWY_TARGET != HWY_SCALAR
 private:
  /// Loads a vertex and whatever follows.
  static HWY_INLINE hn::Vec<hn::FixedTag<float, 4>> vertex(const MeshView& mesh, std::int32_t index) {
    const hn::FixedTag<float, 4> d;
    const auto v = static_cast<std::size_t>(index);
    if (v + 1 < mesh.vertices.size()) return hn::LoadU(d, mesh.vertices[v].data());
    alignas(16) const std::array<float, 4> end = {mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2], 0};
    return hn::Load(d, end.data());
  }
#endif
};

}  // namespace
}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
