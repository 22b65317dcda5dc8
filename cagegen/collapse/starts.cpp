// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/starts.h"

#include "cagegen/collapse/cage_editor.h"
#include "cagegen/geometry/qp3.h"
#include "src/mesh/rounding.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace encage::makers {

namespace {

std::array<std::int32_t, 3> indices(const TriangleMesh& mesh, std::int64_t t) {
  return {mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
}

Corners corners(const TriangleMesh& mesh, std::int64_t t) {
  return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
}

TriangleTree tree_of(const TriangleMesh& mesh) {
  std::vector<Eigen::AlignedBox3d> boxes(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (const Point& p : corners(mesh, static_cast<std::int64_t>(t))) boxes[t].extend(p);
  }
  return TriangleTree(boxes);
}

/// Which triangles of the cage touch the obstacle, and which touch the cage itself.
struct Contacts {
  std::vector<bool> obstacle;
  std::vector<bool> self;

  std::int64_t count() const {
    return std::count(obstacle.begin(), obstacle.end(), true) + std::count(self.begin(), self.end(), true);
  }
  bool none() const { return count() == 0; }
};

// Starts may come closer to themselves than edits are allowed to: short edges bring triangles together.
constexpr double start_self_clearances = 1e-3;

Contacts find_contacts(const Obstacle& obstacle, const TriangleMesh& cage, double clearance,
                       const std::vector<bool>* only) {
  const TriangleTree tree = tree_of(cage);
  const std::size_t count = static_cast<std::size_t>(cage.triangles.rows());
  Contacts contacts{std::vector<bool>(count), std::vector<bool>(count)};
  for (std::size_t t = 0; t < count; ++t) {
    if (only != nullptr && !(*only)[t]) continue;
    const Corners mine = corners(cage, static_cast<std::int64_t>(t));
    const Prism prism(mine);
    if (!prism.valid) {
      contacts.self[t] = true;
      continue;
    }
    if (obstacle.hit(prism, clearance)) contacts.obstacle[t] = true;
    tree.traverse(obstacle.near(prism, clearance), [&](std::int32_t other) {
      if (other == static_cast<std::int32_t>(t) || contacts.self[t]) return;
      if (!separated(indices(cage, static_cast<std::int64_t>(t)), mine, indices(cage, other), corners(cage, other),
                     start_self_clearances * clearance)) {
        contacts.self[t] = true;
        contacts.self[other] = true;
      }
    });
  }
  return contacts;
}

/// Heights that put the offset of each triangle above the part of the obstacle over it.
void raise_above(const Obstacle& obstacle, const TriangleMesh& base, double height, const std::vector<bool>& only,
                 std::vector<double>& heights) {
  for (std::int64_t t = 0; t < base.triangles.rows(); ++t) {
    if (!only[static_cast<std::size_t>(t)]) continue;
    const Corners c = corners(base, t);
    const Prism prism(c);
    if (!prism.valid) continue;
    // A decimation is off by less than the length of its edges; parts farther away belong to another strand.
    const double longest = std::max({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
    const double over = obstacle.highest(prism, longest / 3, 0);
    for (const std::int32_t v : indices(base, t)) heights[v] = std::max(heights[v], over + height);
  }
}

/// For each vertex the shortest move that lifts the planes of all its triangles by one, at most `longest`.
std::vector<Point> unit_lifts(const TriangleMesh& base, double longest) {
  std::vector<std::vector<Point>> normals(static_cast<std::size_t>(base.vertices.rows()));
  for (std::int64_t t = 0; t < base.triangles.rows(); ++t) {
    const Prism prism(corners(base, t));
    if (!prism.valid) continue;
    for (int k = 0; k < 3; ++k) normals[base.triangles(t, k)].push_back(prism.normal);
  }
  std::vector<Point> lifts(normals.size(), Point::Zero());
  std::vector<LinearConstraint> planes;
  for (std::size_t v = 0; v < normals.size(); ++v) {
    planes.clear();
    Point mean = Point::Zero();
    for (const Point& n : normals[v]) {
      planes.push_back({n, 1.0});
      mean += n;
    }
    const auto lift = solve_qp(Eigen::Matrix3d::Identity(), Point::Zero(), planes);
    if (lift && lift->norm() <= longest) {
      lifts[v] = *lift;
    } else if (mean.norm() > 0) {
      lifts[v] = mean.normalized() * (lift ? longest : 1.0);
    }
  }
  return lifts;
}

}  // namespace

bool clear(const Obstacle& obstacle, const TriangleMesh& cage, double clearance) {
  return find_contacts(obstacle, cage, clearance, nullptr).none();
}

namespace {

/// Moves the chosen vertices to the middle of their neighbours.
void smooth(TriangleMesh& mesh, const std::vector<bool>& chosen) {
  std::vector<Point> sum(chosen.size(), Point::Zero());
  std::vector<int> count(chosen.size(), 0);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = mesh.triangles(t, k);
      if (!chosen[v]) continue;
      sum[v] += mesh.corner(t, (k + 1) % 3);
      ++count[v];
    }
  }
  for (std::size_t v = 0; v < chosen.size(); ++v) {
    if (count[v] > 0) mesh.vertices.row(static_cast<std::int64_t>(v)) = (sum[v] / count[v]).transpose();
  }
}

}  // namespace

std::optional<TriangleMesh> offset_start(const Obstacle& obstacle, const TriangleMesh& surface, double height,
                                         bool grow, double clearance) {
  const int rounds = grow ? 14 : 5;
  // The obstacle's own corners have to be left however far that is; those of a likeness can be smoothed away.
  const double longest = grow ? 4 : 40;
  TriangleMesh base = surface;
  TriangleMesh cage = surface;
  const std::size_t vertex_count = static_cast<std::size_t>(base.vertices.rows());
  std::vector<Point> lifts = unit_lifts(base, longest);
  std::vector<double> heights(vertex_count, height);
  std::vector<bool> moved(vertex_count, true);
  std::vector<int> deep_rounds(vertex_count, 0);
  std::vector<bool> dirty(static_cast<std::size_t>(base.triangles.rows()), true);
  if (grow) raise_above(obstacle, base, height, dirty, heights);
  std::int64_t first_count = 0;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t v = 0; v < vertex_count; ++v) {
      if (!moved[v]) continue;
      const Point p = base.vertex(static_cast<std::int32_t>(v)) + heights[v] * lifts[v];
      cage.vertices.row(static_cast<std::int64_t>(v)) = round_to_float(p).transpose();
    }
    const Contacts contacts = find_contacts(obstacle, cage, clearance, &dirty);
    if (contacts.none()) return cage;
    // Smoothing only spreads self-contacts that the surface itself has: give up early.
    if (round == 1) first_count = contacts.count();
    if (round == 6 && contacts.count() > first_count / 2 + 10) return std::nullopt;
    std::vector<bool> self(vertex_count);
    std::vector<bool> deep(vertex_count);
    for (std::size_t t = 0; t < dirty.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const std::int32_t v = base.triangles(static_cast<std::int64_t>(t), k);
        if (contacts.self[t]) self[v] = true;
        if (contacts.obstacle[t]) deep[v] = true;
      }
    }
    // Folds, and vertices that no direction lifts clear of the obstacle, vanish by smoothing; strands that come too
    // close to each other need less height.
    const bool smooths = grow && round % 3 != 2;
    std::vector<bool> rough = self;
    for (std::size_t v = 0; v < vertex_count; ++v) {
      deep_rounds[v] = deep[v] ? deep_rounds[v] + 1 : 0;
      if (deep_rounds[v] > 2) rough[v] = true;
    }
    if (smooths) smooth(base, rough);
    for (std::size_t v = 0; v < vertex_count; ++v) {
      if (self[v] && !smooths) {
        heights[v] *= 0.5;
      } else if (deep[v]) {
        heights[v] *= grow ? 1.6 : 0.5;
      }
    }
    if (smooths) lifts = unit_lifts(base, longest);
    for (std::size_t t = 0; t < dirty.size(); ++t) {
      const auto corner = indices(base, static_cast<std::int64_t>(t));
      dirty[t] = false;
      for (const std::int32_t v : corner) {
        if (self[v] || deep[v]) dirty[t] = true;
      }
    }
    // Smoothing turns the lifts of neighbours too.
    moved.assign(vertex_count, false);
    for (std::size_t t = 0; t < dirty.size(); ++t) {
      if (!dirty[t]) continue;
      for (const std::int32_t v : indices(base, static_cast<std::int64_t>(t))) moved[v] = true;
    }
    for (std::size_t t = 0; t < dirty.size(); ++t) {
      for (const std::int32_t v : indices(base, static_cast<std::int64_t>(t))) {
        if (moved[v]) dirty[t] = true;
      }
    }
    if (smooths) raise_above(obstacle, base, height, dirty, heights);
  }
  return std::nullopt;
}

TriangleMesh simplify(const TriangleMesh& mesh, std::int64_t faces) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  std::vector<float> positions;
  std::vector<unsigned int> triangles;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      positions.push_back(static_cast<float>(mesh.vertices(v, axis) - box.center()[axis]));
    }
  }
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) triangles.push_back(static_cast<unsigned int>(mesh.triangles(t, k)));
  }
  std::vector<unsigned int> simplified(triangles.size());
  simplified.resize(meshopt_simplify(simplified.data(), triangles.data(), triangles.size(), positions.data(),
                                     static_cast<std::size_t>(mesh.vertices.rows()), 3 * sizeof(float),
                                     std::min(static_cast<std::size_t>(faces) * 3, triangles.size()), 1.0f, 0,
                                     nullptr));
  TriangleMesh result;
  result.vertices = mesh.vertices;
  result.triangles.resize(static_cast<std::int64_t>(simplified.size() / 3), 3);
  for (std::size_t i = 0; i < simplified.size(); ++i) {
    result.triangles(static_cast<std::int64_t>(i / 3), static_cast<int>(i % 3)) =
        static_cast<std::int32_t>(simplified[i]);
  }
  return make_manifold(result);
}

TriangleMesh keep_components(const TriangleMesh& mesh, std::span<const std::int32_t> label,
                             const std::vector<bool>& kept) {
  TriangleMesh result;
  std::vector<std::int32_t> number(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  std::vector<std::int32_t> used;
  std::vector<std::int64_t> rows;
  for (std::size_t t = 0; t < label.size(); ++t) {
    if (!kept[label[t]]) continue;
    rows.push_back(static_cast<std::int64_t>(t));
    for (const std::int32_t v : indices(mesh, rows.back())) {
      if (number[v] >= 0) continue;
      number[v] = static_cast<std::int32_t>(used.size());
      used.push_back(v);
    }
  }
  result.vertices.resize(static_cast<std::int64_t>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v)
    result.vertices.row(static_cast<std::int64_t>(v)) = mesh.vertices.row(used[v]);
  result.triangles.resize(static_cast<std::int64_t>(rows.size()), 3);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (int k = 0; k < 3; ++k) result.triangles(static_cast<std::int64_t>(r), k) = number[mesh.triangles(rows[r], k)];
  }
  return result;
}

TriangleMesh outermost_components(const TriangleMesh& cage) {
  std::vector<std::int32_t> label;
  const int components = triangle_components(cage, label);
  if (components == 1) return cage;
  std::vector<TriangleMesh> part(static_cast<std::size_t>(components));
  std::vector<std::int64_t> count(part.size(), 0);
  for (const std::int32_t c : label) ++count[c];
  for (std::size_t c = 0; c < part.size(); ++c) {
    part[c].vertices = cage.vertices;
    part[c].triangles.resize(count[c], 3);
    count[c] = 0;
  }
  for (std::size_t t = 0; t < label.size(); ++t) {
    part[label[t]].triangles.row(count[label[t]]++) = cage.triangles.row(static_cast<std::int64_t>(t));
  }
  // Whether one component lies inside another, by the solid angle its surface fills: these surfaces do not touch, so
  // that the sum is far from the threshold.
  const auto inside = [&](std::size_t inner, std::size_t outer) {
    const Point x = part[inner].corner(0, 0);
    if (!bounds(part[outer]).contains(x)) return false;
    double angle = 0;
    for (std::int64_t t = 0; t < part[outer].triangles.rows(); ++t) angle += solid_angle(x, corners(part[outer], t));
    return std::abs(angle) > 6;
  };
  std::vector<bool> kept(part.size(), true);
  for (std::size_t c = 0; c < part.size(); ++c) {
    if (signed_volume(part[c]) <= 0) kept[c] = false;
    for (std::size_t other = 0; other < part.size() && kept[c]; ++other) {
      if (other != c && inside(c, other)) kept[c] = false;
    }
  }
  return keep_components(cage, label, kept);
}

}  // namespace encage::makers
