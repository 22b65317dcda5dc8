// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/surface_features.h"
#include "broadphase/distance/box_distance.h"
#include "broadphase/distance/resting_pair.h"
#include "broadphase/separation/triangle_pair.h"
#include "broadphase/shape/shape.h"
#include "src/mesh/segments.h"

#include <encage/manifold.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace encage {
namespace manifold {

using Vector = Eigen::Vector3d;

constexpr double opposing = -0.25;     // cosine of normals that face each other
constexpr double region_slack = 1e-3;  // radians, by which a direction may leave an edge's region
constexpr double patch_cosine = 0.95;  // of normals of one patch

/// Which elements have been seen in this query.
class Marks {
 public:
  void begin(std::size_t count) {
    if (stamp_.size() < count) stamp_.resize(count, 0);
    if (++now_ == 0) {
      std::fill(stamp_.begin(), stamp_.end(), 0);
      now_ = 1;
    }
  }
  /// True the first time.
  bool mark(std::int32_t i) { return std::exchange(stamp_[static_cast<std::size_t>(i)], now_) != now_; }

 private:
  std::vector<std::uint32_t> stamp_;
  std::uint32_t now_ = 0;
};

/// One body in a query.
struct ContactBody {
  const Surface* surface = nullptr;
  const SurfaceFeatures* features = nullptr;
  double scale = 1;
  AffineMap to_common;  ///< from the local frame, scale included
  AffineMap to_other;   ///< to the other's local frame
  Marks triangles, vertices;
  std::vector<std::int32_t> near;  ///< triangles in leaves within the margin

  Vector corner(std::int32_t triangle, int k) const {
    return surface->vertex(static_cast<std::int32_t>(
        surface->mesh.triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)]));
  }
  TriangleD triangle(std::int32_t t) const {
    return {to_common(corner(t, 0)), to_common(corner(t, 1)), to_common(corner(t, 2))};
  }
  Vector direction(const Vector& local) const { return to_common.linear * local / scale; }
};

struct Candidate {
  Vector point_a, point_b, normal;  ///< common frame
  double separation;
  std::uint64_t feature;
  std::int32_t patch;
};

}  // namespace manifold

using manifold::Candidate;
using manifold::ContactBody;
using manifold::Vector;

class ManifoldCache::State {
 public:
  ContactBody a, b;
  std::vector<Candidate> candidates;
  std::unordered_map<const Surface*, SurfaceFeatures> features;  // TODO(shape): belongs to the shape
};

ManifoldCache::ManifoldCache() : state_(std::make_unique<State>()) {}
ManifoldCache::~ManifoldCache() = default;
ManifoldCache::ManifoldCache(ManifoldCache&& other) noexcept = default;
ManifoldCache& ManifoldCache::operator=(ManifoldCache&& other) noexcept = default;
void ManifoldCache::clear() noexcept { state_->candidates.clear(); }

namespace {

class Generator {
 public:
  Generator(ManifoldCache::State& state, const RestingPair& pair, const ManifoldOptions& options)
      : state_(state), a_(state.a), b_(state.b), pair_(pair), margin_(options.margin) {}

  void collect() {
    state_.candidates.clear();
    for (ContactBody* side : {&a_, &b_}) {
      side->near.clear();
      side->triangles.begin(side->surface->mesh.triangles.size());
      side->vertices.begin(side->surface->mesh.vertices.size());
    }
    const BoxDistance bounds(pair_.a, {a_.surface->radius, a_.surface->tree.grid, a_.scale}, pair_.b,
                             {b_.surface->radius, b_.surface->tree.grid, b_.scale}, pair_.error);
    limit_ = margin_ + 4 * pair_.error;
    visit_near_leaves(
        a_.surface->tree, b_.surface->tree, bounds, limit_,
        [](void* self, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
          return static_cast<Generator*>(self)->leaves(first_a, count_a, first_b, count_b);
        },
        this);
    vertices_of(a_, b_, true);
    vertices_of(b_, a_, false);
  }

 private:
  double leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
    const auto note = [](ContactBody& side, std::int32_t first, std::int32_t count) {
      for (std::int32_t i = 0; i < count; ++i) {
        const std::int32_t t = side.surface->tree.leaves[static_cast<std::size_t>(first + i)].triangle;
        if (side.triangles.mark(t)) side.near.push_back(t);
      }
    };
    note(a_, first_a, count_a);
    note(b_, first_b, count_b);
    for (std::int32_t i = 0; i < count_a; ++i) {
      for (std::int32_t j = 0; j < count_b; ++j) {
        edges_of(a_.surface->tree.leaves[static_cast<std::size_t>(first_a + i)].triangle,
                 b_.surface->tree.leaves[static_cast<std::size_t>(first_b + j)].triangle);
      }
    }
    return limit_;
  }

  /// Vertices of one body, and the nearest features of the other one.
  void vertices_of(ContactBody& guest, ContactBody& host, bool guest_is_a) {
    for (const std::int32_t t : guest.near) {
      for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<std::int32_t>(
            guest.surface->mesh.triangles[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)]);
        if (guest.vertices.mark(v)) vertex(guest, host, t, k, guest_is_a);
      }
    }
  }

  void vertex(const ContactBody& guest, const ContactBody& host, std::int32_t t, int k, bool guest_is_a) {
    const auto v = static_cast<std::int32_t>(
        guest.surface->mesh.triangles[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)]);
    const Vector p = guest.to_other(guest.surface->vertex(v));
    SurfacePoint nearest;
    if (!nearest_point(*host.surface, p, limit_ / host.scale, nearest)) return;
    const Vector out = feature_normal(*host.surface, *host.features, nearest);
    const Vector away = p - nearest.point;
    const bool inside = out.dot(away) < 0;
    Vector normal;  // from the host towards the guest
    if (nearest.distance * host.scale > 4 * pair_.error) {
      normal = host.direction(inside ? -away : away).normalized();
      const Vector own = guest.direction(guest.features->vertex_normal[static_cast<std::size_t>(v)].cast<double>());
      if (own.dot(normal) > manifold::opposing) return;
    } else if (!opposite_faces(guest, t, k, host, nearest, normal)) {
      return;
    }
    Candidate c;
    const Vector on_guest = guest.to_common(guest.surface->vertex(v)), on_host = host.to_common(nearest.point);
    c.point_a = guest_is_a ? on_guest : on_host;
    c.point_b = guest_is_a ? on_host : on_guest;
    c.normal = guest_is_a ? normal : Vector(-normal);
    c.separation = (inside ? -1 : 1) * nearest.distance * host.scale;
    c.feature = static_cast<std::uint64_t>(guest_is_a ? 0 : 1) << 62 | static_cast<std::uint64_t>(v);
    c.patch = -1;
    state_.candidates.push_back(c);
  }

  /// Of features that touch, the normal of the two faces that face each other most; false if none do.
  static bool opposite_faces(const ContactBody& guest, std::int32_t t, int k, const ContactBody& host,
                             const SurfacePoint& point, Vector& normal) {
    double least = manifold::opposing;
    const auto compare = [&](std::int32_t on_host) {
      const Vector up = unit_normal(host.triangle(on_host));
      visit_around(*guest.features, t, k, [&](std::int32_t on_guest) {
        const double cosine = up.dot(unit_normal(guest.triangle(on_guest)));
        if (cosine >= least) return;
        least = cosine;
        normal = up;
      });
    };
    if (point.kind == SurfacePoint::Kind::vertex) {
      visit_around(*host.features, point.triangle, point.corner, compare);
    } else {
      compare(point.triangle);
      const std::int32_t twin = host.features->twin[static_cast<std::size_t>(3 * point.triangle + point.corner)];
      if (point.kind == SurfacePoint::Kind::edge && twin >= 0) compare(twin / 3);
    }
    return least < manifold::opposing;
  }

  void edges_of(std::int32_t ta, std::int32_t tb) {
    const unsigned owned_a = a_.surface->owned[static_cast<std::size_t>(ta)],
                   owned_b = b_.surface->owned[static_cast<std::size_t>(tb)];
    if ((owned_a >> 3) == 0 || (owned_b >> 3) == 0) return;
    const TriangleD a = a_.triangle(ta), b = b_.triangle(tb);
    for (unsigned i = 0; i < 3; ++i) {
      if ((owned_a >> (3 + i) & 1U) == 0) continue;
      for (unsigned j = 0; j < 3; ++j) {
        if ((owned_b >> (3 + j) & 1U) == 0) continue;
        const Vector &p = a[i], &q = b[j], u = a[(i + 1) % 3] - p, w = b[(j + 1) % 3] - q;
        const auto [s, r] = closest_parameters(u, w, p - q);
        if (!(s > 0 && s < 1 && r > 0 && r < 1)) continue;
        const Vector on_a = p + s * u, on_b = q + r * w, apart = on_a - on_b;
        const double distance = apart.norm();
        if (!(distance <= limit_) || distance <= 4 * pair_.error) continue;
        // Of edges that have passed each other the directions are reversed.
        const auto faces = [&](const Vector& way) {
          return in_region(a_, ta, static_cast<int>(i), -way) && in_region(b_, tb, static_cast<int>(j), way);
        };
        const double sign = faces(apart) ? 1 : faces(-apart) ? -1 : 0;
        if (sign == 0) continue;
        Candidate c;
        c.point_a = on_a;
        c.point_b = on_b;
        c.normal = (sign / distance) * apart;
        c.separation = sign * distance;
        c.feature = std::uint64_t{2} << 62 | static_cast<std::uint64_t>(3 * ta + static_cast<int>(i)) << 31 |
                    static_cast<std::uint64_t>(3 * tb + static_cast<int>(j));
        c.patch = -1;
        state_.candidates.push_back(c);
      }
    }
  }

  /// True if a point off an edge in this direction is nearer to the edge than to both its faces, and outside.
  static bool in_region(const ContactBody& side, std::int32_t t, int k, const Vector& direction) {
    const TriangleD own = side.triangle(t);
    const auto index = [](int i) { return static_cast<std::size_t>(i % 3); };
    const Vector along = own[index(k + 1)] - own[index(k)];
    const double slack = -manifold::region_slack * direction.norm();
    Vector normals = unit_normal(own);
    if (along.cross(normals).normalized().dot(direction) < slack) return false;
    const std::int32_t twin = side.features->twin[static_cast<std::size_t>(3 * t + k)];
    if (twin >= 0) {
      const TriangleD other = side.triangle(twin / 3);
      const Vector normal = unit_normal(other);
      if ((-along).cross(normal).normalized().dot(direction) < slack) return false;
      normals += normal;
    }
    return normals.dot(direction) > 0;
  }

  ManifoldCache::State& state_;
  ContactBody &a_, &b_;
  const RestingPair& pair_;
  double margin_, limit_ = 0;
};

/// Groups candidates of similar normals; the deepest of each patch comes first, then those that spread farthest.
int reduce(std::vector<Candidate>& candidates, const ManifoldOptions& options, const RestingPair& pair,
           std::span<ManifoldPoint> points) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& x, const Candidate& y) {
    return std::tie(x.separation, x.feature) < std::tie(y.separation, y.feature);
  });
  int count = 0, patches = 0;
  const int most = std::min(options.most_points, static_cast<int>(points.size()));
  for (std::size_t first = 0; first < candidates.size() && count < most; ++first) {
    if (candidates[first].patch >= 0) continue;
    const int patch = patches++;
    const int begin = count;
    for (Candidate& c : candidates) {
      if (c.patch < 0 && c.normal.dot(candidates[first].normal) > manifold::patch_cosine) c.patch = patch;
    }
    const auto add = [&](const Candidate& c) {
      ManifoldPoint& out = points[static_cast<std::size_t>(count++)];
      out.point_a = pair.origin + c.point_a;
      out.point_b = pair.origin + c.point_b;
      out.normal = c.normal;
      out.separation = c.separation;
      out.feature = c.feature;
      out.patch = patch;
    };
    add(candidates[first]);
    while (count < most && count - begin < options.most_per_patch) {
      double farthest = 0;
      const Candidate* next = nullptr;
      for (const Candidate& c : candidates) {
        if (c.patch != patch) continue;
        double nearest = std::numeric_limits<double>::infinity();
        for (int i = begin; i < count; ++i) {
          nearest = std::min(nearest, (points[static_cast<std::size_t>(i)].point_b - pair.origin - c.point_b).norm());
        }
        if (nearest > farthest) {
          farthest = nearest;
          next = &c;
        }
      }
      if (next == nullptr || farthest <= 1e-9) break;
      add(*next);
    }
  }
  return count;
}

}  // namespace

int contact_manifold(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                     const ManifoldOptions& options, ManifoldCache& cache, std::span<ManifoldPoint> points) {
  ManifoldCache::State& state = cache.state();
  const SimpleShape &simple_a = a.simple(), &simple_b = b.simple();
  const RestingPair pair(simple_a.frame, motion_a, simple_b.frame, motion_b);
  const auto place = [&](ContactBody& side, const SimpleShape& shape, double scale, const AffineMap& common,
                         const AffineMap& other) {
    side.surface = &shape.fine;
    side.scale = scale;
    side.to_common = {scale * common.linear, common.offset};
    side.to_other = other;
    const auto [found, added] = state.features.try_emplace(&shape.fine);
    if (added) found->second = make_surface_features(shape.fine.mesh);
    side.features = &found->second;
  };
  const auto scaled = [](const AffineMap& map, double from, double to) {
    return AffineMap{map.linear * (from / to), map.offset / to};
  };
  place(state.a, simple_a, motion_a.scale, pair.a, scaled(pair.a_to_b(), motion_a.scale, motion_b.scale));
  place(state.b, simple_b, motion_b.scale, pair.b, scaled(pair.b_to_a(), motion_b.scale, motion_a.scale));
  Generator(state, pair, options).collect();
  return reduce(state.candidates, options, pair, points);
}

int contact_manifold(const Shape&, const Motion&, const HalfSpace&, const ManifoldOptions&, ManifoldCache&,
                     std::span<ManifoldPoint>) {
  return 0;
}

}  // namespace encage
