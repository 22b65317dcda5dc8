// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/contact/nearest_point.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/contact/nearest_point.h"

#include "broadphase/shape/leaf_corners-inl.h"
#include "src/tree/visit.h"

#include <Eigen/Geometry>
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace {

// ---- Boxes ---------------------------------------------------------------------

using BoxLanes = hn::CappedTag<float, MeshNode::width>;

template <class Integer>
HWY_INLINE hn::Vec<BoxLanes> load_as_float(const Integer* from) {
  const BoxLanes d;
  const hn::Rebind<Integer, BoxLanes> from_type;
  const hn::Rebind<std::int32_t, BoxLanes> wide;
  return hn::ConvertTo(d, hn::PromoteTo(wide, hn::LoadU(from_type, from)));
}

/// Bounds from below, but for rounding, the squared distances in grid steps from p to what lies in the boxes and slabs:
/// by the box, by the slab, and along the line from the box's middle, on which box and slab count together.
HWY_INLINE void squared_distances_to_boxes(const MeshNode& node, const std::array<float, 3>& p,
                                           std::array<float, MeshNode::width>& squared) {
  const BoxLanes d;
  const auto zero = hn::Zero(d), one_half = hn::Set(d, 0.5F);
  const auto unit = hn::Set(d, static_cast<float>(MeshNode::slab_unit));
  for (std::size_t first = 0; first < static_cast<std::size_t>(MeshNode::width); first += hn::Lanes(d)) {
    auto sum = zero, height = zero, middle_height = zero, length = zero, line = zero;
    hn::Vec<BoxLanes> n[3], half[3], to[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto low = load_as_float(node.lower[axis] + first), high = load_as_float(node.upper[axis] + first);
      const auto middle = hn::Mul(one_half, hn::Add(low, high));
      half[axis] = hn::Mul(one_half, hn::Sub(high, low));
      to[axis] = hn::Sub(hn::Set(d, p[axis]), middle);
      line = hn::MulAdd(to[axis], to[axis], line);
      const auto beside = hn::Max(hn::Sub(hn::Abs(to[axis]), half[axis]), zero);
      sum = hn::MulAdd(beside, beside, sum);
      n[axis] = load_as_float(node.normal[axis] + first);
      height = hn::MulAdd(n[axis], to[axis], height);
      middle_height = hn::MulAdd(n[axis], middle, middle_height);
      length = hn::MulAdd(n[axis], n[axis], length);
    }
    // Heights of the slab over the box's middle.
    const auto low = hn::MulSub(load_as_float(node.slab_lower + first), unit, middle_height),
               high = hn::MulSub(load_as_float(node.slab_upper + first), unit, middle_height);
    const auto beside = hn::Max(hn::Max(hn::Sub(low, height), hn::Sub(height, high)), zero);
    // Unused lanes and nodes without a slab have normals of length 0.
    const auto has_slab = hn::Gt(length, zero);
    const auto per_length = hn::IfThenElseZero(has_slab, hn::Div(hn::Set(d, 1.0F), length));
    const auto from_slab = hn::Mul(hn::Mul(beside, beside), per_length);
    // The line is a part along the normal, on which the slab bounds, and a rest, on which the box does.
    const auto part = hn::Mul(height, per_length);
    auto gap = hn::NegMulAdd(part, hn::IfThenElse(hn::Gt(part, zero), high, low), line);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gap = hn::NegMulAdd(hn::Abs(hn::NegMulAdd(part, n[axis], to[axis])), half[axis], gap);
    }
    const auto on_line = hn::IfThenElseZero(hn::Gt(gap, zero), hn::Mul(gap, hn::Div(gap, line)));
    hn::StoreU(hn::Max(on_line, hn::Max(sum, from_slab)), d, squared.data() + first);
  }
}

// ---- Triangles of a leaf ---------------------------------------------------------

struct Vec3 {
  LeafVec x, y, z;
};

HWY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE LeafVec dot(const Vec3& a, const Vec3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3 repeat(const Eigen::Vector3d& v) {
  const LeafTag d;
  return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

HWY_INLINE Vec3 corner(const LeafCorners& corners, std::size_t k, std::size_t first) {
  return {corners.load(k, 0, first), corners.load(k, 1, first), corners.load(k, 2, first)};
}
HWY_INLINE Vec3 choose(const hn::Mask<LeafTag>& first, const Vec3& a, const Vec3& b) {
  return {hn::IfThenElse(first, a.x, b.x), hn::IfThenElse(first, a.y, b.y), hn::IfThenElse(first, a.z, b.z)};
}

/// Squared distances from p to the triangles; infinite where the normal does not pass the filter. The height over a
/// face is measured from the nearest point of its edges, beside which little of the normal's rounding counts. Triangles
/// too thin for that count as nearer than their edges by what their width allows, which is far below it but on them.
HWY_INLINE void squared_distances(const LeafCorners& corners, const Eigen::Vector3d& p, const NormalFilter& filter,
                                  std::array<double, MeshTree::leaf_size>& squared) {
  const LeafTag d;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1);
  const auto infinite = hn::Set(d, std::numeric_limits<double>::infinity());
  for (std::size_t first = 0; first < MeshTree::leaf_size; first += hn::Lanes(d)) {
    const Vec3 c[3] = {corner(corners, 0, first), corner(corners, 1, first), corner(corners, 2, first)};
    const Vec3 along[3] = {c[1] - c[0], c[2] - c[1], c[0] - c[2]};
    const Vec3 n = cross(along[0], along[1]);
    const auto nn = dot(n, n);
    auto above = hn::Gt(nn, zero);
    auto least = infinite;
    auto longest = zero;
    Vec3 from_edge = {zero, zero, zero};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 from = repeat(p) - c[k];
      above = hn::And(above, hn::Gt(dot(from, cross(n, along[k])), zero));
      const auto length = dot(along[k], along[k]);
      longest = hn::Max(longest, length);
      const auto part = hn::IfThenElseZero(hn::Gt(length, zero), hn::Div(dot(from, along[k]), length));
      const auto s = hn::Min(hn::Max(part, zero), one);
      const Vec3 rest = from - Vec3{hn::Mul(s, along[k].x), hn::Mul(s, along[k].y), hn::Mul(s, along[k].z)};
      const auto found = dot(rest, rest);
      from_edge = choose(hn::Lt(found, least), rest, from_edge);
      least = hn::Min(least, found);
    }
    const auto height = dot(from_edge, n);
    auto result = hn::IfThenElse(above, hn::Min(hn::Div(hn::Mul(height, height), nn), least), least);
    const auto thin = hn::Le(nn, hn::Mul(hn::Set(d, thin_square), hn::Mul(longest, longest)));
    if (!hn::AllFalse(d, thin)) {
      const auto width = hn::IfThenElseZero(hn::Gt(longest, zero), hn::Div(nn, longest));
      result = hn::IfThenElse(thin, hn::Max(hn::Sub(least, width), zero), result);
    }
    if (filter.most < 1) {
      const auto passes = hn::Lt(dot(n, repeat(filter.axis)), hn::Mul(hn::Set(d, filter.most), hn::Sqrt(nn)));
      result = hn::IfThenElse(passes, result, infinite);
    }
    hn::Store(result, d, squared.data() + first);
  }
}

}  // namespace

NearestTriangle nearest_triangle(const MeshArraysView& surface, const Eigen::Vector3d& p, double reach,
                                 const NormalFilter& filter) {
  const MeshTreeView& tree = surface.tree;
  const double step = static_cast<double>(tree.grid.step);
  std::array<float, 3> at;
  // Rounding to float may cost so many grid steps: of the point, of boxes of up to 2^15 steps, of their distance.
  double slack = 1 + 4 * tree.grid.rounding();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double coordinate = tree.grid.coordinate(static_cast<int>(axis), p[static_cast<Eigen::Index>(axis)]);
    at[axis] = static_cast<float>(coordinate);
    slack += 1e-6 * std::abs(coordinate);
  }
  struct Entry {
    float squared;
    std::uint32_t link;
  };
  std::array<Entry, traversal_stack_size> stack;
  std::size_t size = 0;
  stack[size++] = {0, 0};
  std::int32_t nearest = -1;
  double least = reach * reach;
  double limit = 0;
  const auto set_limit = [&] {
    const double steps = std::sqrt(least) / step + slack;
    limit = steps < 1e18 ? steps * steps : std::numeric_limits<double>::infinity();  // squares fit in float
  };
  set_limit();
  while (size > 0) {
    const Entry entry = stack[--size];
    if (static_cast<double>(entry.squared) > limit) continue;
    const int count = MeshNode::count_of(entry.link);
    const auto child = static_cast<std::size_t>(MeshNode::child_of(entry.link));
    if (count == MeshNode::inner) {
      const MeshNode& node = tree.nodes[child];
      std::array<float, MeshNode::width> to_box;
      squared_distances_to_boxes(node, at, to_box);
      const std::size_t bottom = size;
      for (std::size_t lane = 0; lane < to_box.size() && node.link[lane] < MeshNode::unused_link; ++lane) {
        if (static_cast<double>(to_box[lane]) > limit) continue;
        // The nearest one last, to be opened first.
        std::size_t place = size++;
        for (; place > bottom && stack[place - 1].squared < to_box[lane]; --place) stack[place] = stack[place - 1];
        stack[place] = {to_box[lane], node.link[lane]};
      }
      continue;
    }
    auto leaf = tree.leaves.subspan(child, static_cast<std::size_t>(count));
    const double before = least;
    while (!leaf.empty()) {
      const auto four = leaf.first(std::min<std::size_t>(leaf.size(), MeshTree::leaf_size));
      leaf = leaf.subspan(four.size());
      alignas(32) std::array<double, MeshTree::leaf_size> squared;
      squared_distances(LeafCorners(surface.mesh, four), p, filter, squared);
      for (std::size_t i = 0; i < four.size(); ++i) {
        if (!(squared[i] < least || (squared[i] == least && nearest > four[i].triangle))) continue;
        least = squared[i];
        nearest = four[i].triangle;
      }
    }
    if (least < before) set_limit();
  }
  return {nearest, least};
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {
namespace {

using Vector = Eigen::Vector3d;

Vector vertex(const MeshView& mesh, std::uint32_t v) {
  return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[v].data()).cast<double>();
}

HWY_EXPORT(nearest_triangle);

}  // namespace

SurfacePoint nearest_in_triangle(const Vector& p, const TriangleD& t) {
  using Kind = SurfacePoint::Kind;
  SurfacePoint best;
  best.distance = std::numeric_limits<double>::infinity();
  const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
  bool above = true;
  double longest = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector &a = t[k], along = t[(k + 1) % 3] - a;
    above = above && n.cross(along).dot(p - a) > 0;
    const double length = along.squaredNorm();
    longest = std::max(longest, length);
    const double s = length > 0 ? std::clamp(along.dot(p - a) / length, 0.0, 1.0) : 0;
    const Vector q = s >= 1 ? t[(k + 1) % 3] : Vector(a + s * along);
    const double distance = (p - q).norm();
    if (distance >= best.distance) continue;
    best.point = q;
    best.distance = distance;
    best.kind = s <= 0 || s >= 1 ? Kind::vertex : Kind::edge;
    best.corner = s >= 1 ? (k + 1) % 3 : k;
  }
  const double squared = n.squaredNorm();
  if (!above || !(squared > thin_square * longest * longest)) return best;
  SurfacePoint on_face;
  on_face.point = p - (n.dot(p - best.point) / squared) * n;
  on_face.distance = (p - on_face.point).norm();
  return on_face;
}

bool nearest_point(const MeshArraysView& surface, const Vector& p, double reach, SurfacePoint& nearest,
                   const NormalFilter& filter) {
  const NearestTriangle found = HWY_DYNAMIC_DISPATCH(nearest_triangle)(surface, p, reach, filter);
  if (found.triangle < 0) {
    nearest.triangle = -1;
    return false;
  }
  const auto& t = surface.mesh.triangles[static_cast<std::size_t>(found.triangle)];
  nearest =
      nearest_in_triangle(p, {vertex(surface.mesh, t[0]), vertex(surface.mesh, t[1]), vertex(surface.mesh, t[2])});
  nearest.triangle = found.triangle;
  nearest.lower = std::min(nearest.distance, std::sqrt(found.squared));
  return true;
}

Vector feature_normal(const MeshArraysView& surface, const SurfaceFeatures& features, const SurfacePoint& point) {
  const MeshView& mesh = surface.mesh;
  switch (point.kind) {
    case SurfacePoint::Kind::vertex: {
      const std::uint32_t v =
          mesh.triangles[static_cast<std::size_t>(point.triangle)][static_cast<std::size_t>(point.corner)];
      return features.vertex_normal[v].cast<double>();
    }
    case SurfacePoint::Kind::edge: {
      const std::int32_t twin = features.twin_of(3 * point.triangle + point.corner);
      const auto normal = [&](std::int32_t t) {
        return features.face_normal[static_cast<std::size_t>(t)].cast<double>();
      };
      if (twin < 0) break;
      return (normal(point.triangle) + normal(twin / 3)).normalized();
    }
    case SurfacePoint::Kind::face: break;
  }
  return features.face_normal[static_cast<std::size_t>(point.triangle)].cast<double>();
}

}  // namespace encage
#endif
