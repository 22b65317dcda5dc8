// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/cage_editor.h"

#include "src/mesh/rounding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace encage::makers {

namespace {

constexpr int most_rounds = 8;               // of cutting planes for one placement
constexpr double lift_clearances = 3;        // clearances that a placement aims for
constexpr std::size_t hit_limit = 64;        // per triangle and round
constexpr double thinnest_shape = 1e-4;      // height / longest edge of a cage triangle
constexpr std::size_t spare_triangles = 64;  // for splits, until the tree is built anew
constexpr std::int32_t moved_vertex = -1;    // index of the vertex being placed

}  // namespace

CageEditor::CageEditor(const Obstacle& obstacle, const TriangleMesh& cage, const EditorOptions& options)
    : obstacle_(obstacle), options_(options) {
  position_.resize(static_cast<std::size_t>(cage.vertices.rows()));
  incident_.resize(position_.size());
  double magnitude = 0;
  for (std::size_t v = 0; v < position_.size(); ++v) {
    position_[v] = cage.vertices.row(static_cast<std::int64_t>(v)).transpose();
    assert(position_[v] == round_to_float(position_[v]));
    magnitude = std::max(magnitude, position_[v].cwiseAbs().maxCoeff());
  }
  rounding_ = magnitude * 0x1p-23;
  triangle_.resize(static_cast<std::size_t>(cage.triangles.rows()));
  for (std::size_t t = 0; t < triangle_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      triangle_[t][k] = cage.triangles(static_cast<std::int64_t>(t), k);
      incident_[triangle_[t][k]].push_back(static_cast<std::int32_t>(t));
    }
  }
  used_ = triangle_.size();
  face_count_ = static_cast<std::int64_t>(used_);
  rebuild_tree();
}

void CageEditor::rebuild_tree() {
  triangle_.resize(used_ + spare_triangles, {-1, -1, -1});
  mark_.resize(triangle_.size(), 0);
  std::vector<Eigen::AlignedBox3d> boxes(triangle_.size());
  for (std::size_t t = 0; t < triangle_.size(); ++t) {
    if (triangle_[t][0] < 0) continue;
    for (const std::int32_t v : triangle_[t]) boxes[t].extend(position_[v]);
  }
  // Spare triangles wait all over the tree, to enlarge few boxes when they are used.
  for (std::size_t i = 0; i < spare_triangles; ++i) {
    boxes[used_ + i].extend(position_[i * position_.size() / spare_triangles]);
  }
  tree_.build(boxes);
  built_for_ = face_count_;
  edits_ = 0;
}

void CageEditor::neighbours(std::int32_t vertex, std::vector<std::int32_t>& found) const {
  found.clear();
  for (const std::int32_t t : incident_[vertex]) {
    // Each neighbour follows the vertex in exactly one triangle.
    for (int k = 0; k < 3; ++k) {
      if (triangle_[t][k] == vertex) found.push_back(triangle_[t][(k + 1) % 3]);
    }
  }
}

bool CageEditor::make_collapse_patch(std::int32_t u, std::int32_t v, Patch& patch) const {
  patch.ring.clear();
  patch.old_triangles.clear();
  patch.replaced = {position_[u], position_[v]};
  patch.replaced_count = 2;
  int shared = 0;
  std::array<std::int32_t, 2> opposite{-1, -1};
  for (const std::int32_t vertex : {u, v}) {
    for (const std::int32_t t : incident_[vertex]) {
      const auto& corner = triangle_[t];
      int k = 0;
      while (corner[k] != vertex) ++k;
      const std::int32_t a = corner[(k + 1) % 3];
      const std::int32_t b = corner[(k + 2) % 3];
      const std::int32_t other = vertex == u ? v : u;
      if (a == other || b == other) {
        if (vertex == u) {
          if (shared == 2) return false;
          opposite[shared++] = a == other ? b : a;
          patch.old_triangles.push_back(t);
        }
        continue;
      }
      patch.ring.push_back({a, b, t});
      patch.old_triangles.push_back(t);
    }
  }
  if (shared != 2 || patch.ring.size() < 3) return false;
  // Link condition: u and v share no neighbour but the two opposite corners.
  std::vector<std::int32_t>& nu = scratch_.neighbours[0];
  std::vector<std::int32_t>& nv = scratch_.neighbours[1];
  neighbours(u, nu);
  neighbours(v, nv);
  for (const std::int32_t a : nu) {
    if (a == opposite[0] || a == opposite[1]) continue;
    if (std::find(nv.begin(), nv.end(), a) != nv.end()) return false;
  }
  // A tetrahedron cannot lose a vertex.
  for (const std::int32_t o : opposite) {
    if (incident_[o].size() <= 3) return false;
  }
  return true;
}

void CageEditor::make_vertex_patch(std::int32_t vertex, Patch& patch) const {
  patch.ring.clear();
  patch.old_triangles.clear();
  patch.replaced[0] = position_[vertex];
  patch.replaced_count = 1;
  for (const std::int32_t t : incident_[vertex]) {
    int k = 0;
    while (triangle_[t][k] != vertex) ++k;
    patch.ring.push_back({triangle_[t][(k + 1) % 3], triangle_[t][(k + 2) % 3], t});
    patch.old_triangles.push_back(t);
  }
}

bool CageEditor::make_split_patch(std::int32_t u, std::int32_t v, Patch& patch) const {
  patch.ring.clear();
  patch.old_triangles.clear();
  patch.replaced[0] = (position_[u] + position_[v]) / 2;
  patch.replaced_count = 1;
  for (const std::int32_t t : incident_[u]) {
    const auto& corner = triangle_[t];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = corner[k], b = corner[(k + 1) % 3], opposite = corner[(k + 2) % 3];
      if (!(a == u && b == v) && !(a == v && b == u)) continue;
      patch.ring.push_back({b, opposite, t});
      patch.ring.push_back({opposite, a, t});
      patch.old_triangles.push_back(t);
    }
  }
  return patch.old_triangles.size() == 2;
}

double CageEditor::Objective::cost(const Point& p) const {
  const Point x = p - centre;
  return 0.5 * x.dot(matrix * x) - vector.dot(x) + constant;
}

CageEditor::Objective CageEditor::objective(const Patch& patch, double quadric_weight) const {
  Objective result;
  for (int i = 0; i < patch.replaced_count; ++i) result.centre += patch.replaced[i] / patch.replaced_count;
  double area = 0;
  double quadric = 0;
  for (const std::int32_t t : patch.old_triangles) {
    const Corners c = corners(t);
    const Point cross = (c[1] - c[0]).cross(c[2] - c[0]);
    const double doubled = cross.norm();
    if (doubled == 0) continue;
    area += doubled / 2;
    const Point x = c[0] - result.centre;
    const Point n = cross / doubled;
    const double offset = n.dot(x);
    result.constant -= cross.dot(x) / 6;
    result.matrix += doubled * n * n.transpose();
    result.vector += doubled * offset * n;
    quadric += doubled / 2 * offset * offset;
  }
  const double scale = quadric_weight / std::sqrt(std::max(area, std::numeric_limits<double>::min()));
  result.matrix *= scale;
  result.vector *= scale;
  result.constant += scale * quadric;
  for (const RingEdge& edge : patch.ring) {
    result.vector -= (position_[edge.a] - result.centre).cross(position_[edge.b] - result.centre) / 6;
  }
  return result;
}

double CageEditor::estimate_collapse(std::int32_t u, std::int32_t v) const {
  Patch& patch = scratch_.patch;
  if (!make_collapse_patch(u, v, patch)) return std::numeric_limits<double>::infinity();
  const Objective whole = objective(patch, options_.quadric_weight);
  const Objective volume = objective(patch, 0);
  double best = std::numeric_limits<double>::infinity();
  for (const Point& p : {position_[u], position_[v], whole.centre}) {
    const double added = volume.cost(p);
    best = std::min(best, whole.cost(p) - added + std::abs(added));
  }
  return best;
}

std::optional<VertexPlacement> CageEditor::plan_collapse(std::int32_t u, std::int32_t v) {
  assert(options_.quadric_weight > 0);  // the volume alone is linear: it has no minimum
  Patch& patch = scratch_.patch;
  if (!make_collapse_patch(u, v, patch)) return std::nullopt;
  const Objective o = objective(patch, options_.quadric_weight);
  // A weak pull to the middle settles flat patches, where the quadric leaves p free; a strong one is tried if the weak
  // one made a bad fan.
  for (const double pull : {1e-3, 1e-1}) {
    Eigen::Matrix3d a = o.matrix;
    a.diagonal().array() += pull * o.matrix.trace() + std::numeric_limits<double>::min();
    const auto p = place(patch, a, o.vector, o.centre);
    if (!p) return std::nullopt;
    if (acceptable(patch, *p)) return VertexPlacement{*p, o.cost(*p)};
  }
  return std::nullopt;
}

std::optional<VertexPlacement> CageEditor::plan_tightening(std::int32_t vertex, double reach) {
  Patch& patch = scratch_.patch;
  make_vertex_patch(vertex, patch);
  return plan_inward(patch, reach);
}

std::optional<VertexPlacement> CageEditor::plan_split(std::int32_t u, std::int32_t v, double reach) {
  Patch& patch = scratch_.patch;
  if (!make_split_patch(u, v, patch)) return std::nullopt;
  return plan_inward(patch, reach);
}

std::optional<VertexPlacement> CageEditor::plan_inward(const Patch& patch, double reach) {
  const Objective o = objective(patch, 0);
  // Volume is linear in p: a quadratic term makes the free step `reach` long.
  const double slope = o.vector.norm();
  if (slope == 0) return std::nullopt;
  const Eigen::Matrix3d a = Eigen::Matrix3d::Identity() * (slope / reach);
  const auto p = place(patch, a, o.vector, o.centre);
  if (!p || *p == patch.replaced[0]) return std::nullopt;
  const double cost = o.cost(*p);
  if (!(cost < 0) || !acceptable(patch, *p)) return std::nullopt;
  return VertexPlacement{*p, cost};
}

std::optional<Point> CageEditor::place(const Patch& patch, const Eigen::Matrix3d& a, const Point& b,
                                       const Point& centre) {
  const double clearance = options_.clearance;
  const double lift = lift_clearances * clearance + 4 * rounding_;
  // For each ring edge the steepest of the planes through it that clear the obstacle.
  std::vector<LinearConstraint>& planes = scratch_.planes;
  std::vector<LinearConstraint>& active = scratch_.active;
  std::vector<std::int32_t>& found = scratch_.hits;
  planes.assign(patch.ring.size(), {Point::Zero(), 0});
  Point last = Point::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int round = 0; round < most_rounds; ++round) {
    active.clear();
    for (const LinearConstraint& plane : planes) {
      if (!plane.normal.isZero(0)) active.push_back({plane.normal, plane.offset - plane.normal.dot(centre)});
    }
    const auto relative = solve_qp(a, b, active);
    if (!relative || !relative->allFinite()) return std::nullopt;
    const Point p = round_to_float(*relative + centre);
    if (p == last) return std::nullopt;
    last = p;
    bool cut = false;
    const auto add_plane = [&](std::size_t i, const Prism& prism, double slope) {
      const Point normal = (prism.normal + slope * prism.side[1]).normalized();
      const double offset = normal.dot(prism.corner[1]) + 2 * rounding_;
      // It replaces the plane of earlier rounds, which is less steep, and which p kept to.
      planes[i] = {normal, offset};
      cut = true;
    };
    for (std::size_t i = 0; i < patch.ring.size(); ++i) {
      const RingEdge& edge = patch.ring[i];
      const Prism prism({p, position_[edge.a], position_[edge.b]});
      if (!prism.valid) return std::nullopt;
      double ceiling = lift;
      for (int m = 0; m < patch.replaced_count; ++m) ceiling = std::max(ceiling, prism.height(patch.replaced[m]));
      const double slope = obstacle_.steepest(prism, lift, ceiling, 0);
      // A turn too small to matter against the lift is left to the test below.
      if (slope * prism.side[1].dot(prism.corner[1] - p) > 0.1 * lift) {
        add_plane(i, prism, slope);
        continue;
      }
      found.clear();
      obstacle_.hits(prism, clearance, hit_limit, found);
      if (found.empty()) continue;
      double needed = 0;
      for (const std::int32_t t : found) {
        needed = std::max(needed, Obstacle::steepest(prism, obstacle_.corners(t), lift, ceiling + lift, needed));
      }
      if (needed <= 0) return std::nullopt;  // touched from a side: no turn about the edge helps
      add_plane(i, prism, needed);
    }
    if (!cut) return p;
  }
  return std::nullopt;
}

bool CageEditor::acceptable(const Patch& patch, const Point& p) const {
  return well_shaped(patch, p) && (!options_.keep_cones || cones_hold(patch, p)) && keeps_representatives(patch, p) &&
         clear_of_itself(patch, p);
}

bool CageEditor::well_shaped(const Patch& patch, const Point& p) const {
  for (const RingEdge& edge : patch.ring) {
    const Point e = position_[edge.b] - position_[edge.a];
    const Point f = p - position_[edge.a];
    const double longest2 = std::max({e.squaredNorm(), f.squaredNorm(), (p - position_[edge.b]).squaredNorm()});
    if (!(e.cross(f).norm() > thinnest_shape * longest2)) return false;
  }
  return true;
}

bool CageEditor::cones_hold(const Patch& patch, const Point& p) const {
  std::vector<Point>& normals = scratch_.normals;
  const auto normal_of = [](const Point& x, const Point& y, const Point& z) {
    return (y - x).cross(z - x).normalized();
  };
  std::vector<Point>& fan = scratch_.fan;
  fan.clear();
  for (const RingEdge& edge : patch.ring) fan.push_back(normal_of(p, position_[edge.a], position_[edge.b]));
  if (!common_direction(fan)) return false;
  ++stamp_;
  for (const std::int32_t t : patch.old_triangles) mark_[t] = stamp_;
  for (const RingEdge& edge : patch.ring) {
    normals.clear();
    const std::int32_t v = edge.a;
    for (const std::int32_t t : incident_[v]) {
      if (mark_[t] == stamp_) continue;
      const Corners c = corners(t);
      normals.push_back(normal_of(c[0], c[1], c[2]));
    }
    for (std::size_t i = 0; i < patch.ring.size(); ++i) {
      if (patch.ring[i].a == v || patch.ring[i].b == v) normals.push_back(fan[i]);
    }
    if (!common_direction(normals)) return false;
  }
  return true;
}

bool CageEditor::keeps_representatives(const Patch& patch, const Point& p) const {
  Eigen::AlignedBox3d box;
  box.extend(p);
  for (int m = 0; m < patch.replaced_count; ++m) box.extend(patch.replaced[m]);
  for (const RingEdge& edge : patch.ring) box.extend(position_[edge.a]);
  std::vector<Point>& points = scratch_.representatives;
  points.clear();
  obstacle_.representatives(box, points);
  // A point between the old and the new patch would change sides.
  for (const Point& x : points) {
    double angle = 0;
    for (const RingEdge& edge : patch.ring) angle += solid_angle(x, {p, position_[edge.a], position_[edge.b]});
    for (const std::int32_t t : patch.old_triangles) angle -= solid_angle(x, corners(t));
    if (std::abs(angle) > 1) return false;
  }
  return true;
}

bool CageEditor::clear_of_itself(const Patch& patch, const Point& p) const {
  const std::size_t n = patch.ring.size();
  // Within the fan: neighbours share an edge, all others the corner p.
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const RingEdge& e = patch.ring[i];
      const RingEdge& f = patch.ring[j];
      if (!separated({moved_vertex, e.a, e.b}, {p, position_[e.a], position_[e.b]}, {moved_vertex, f.a, f.b},
                     {p, position_[f.a], position_[f.b]}, options_.self_clearance)) {
        return false;
      }
    }
  }
  ++stamp_;
  for (const std::int32_t t : patch.old_triangles) mark_[t] = stamp_;
  for (const RingEdge& edge : patch.ring) {
    const Corners mine{p, position_[edge.a], position_[edge.b]};
    const Prism prism(mine);
    const double clearance = options_.self_clearance;
    const BoxFilter filter = obstacle_.near(prism, clearance);
    bool clear = true;
    tree_.traverse(filter, [&](std::int32_t t) {
      if (mark_[t] == stamp_ || triangle_[t][0] < 0) return false;
      ++Obstacle::work();
      clear = separated({moved_vertex, edge.a, edge.b}, mine, triangle_[t], corners(t), clearance);
      return !clear;
    });
    if (!clear) return false;
  }
  return true;
}

void CageEditor::update_box(std::int32_t t) {
  Eigen::AlignedBox3d box;
  for (const std::int32_t v : triangle_[t]) box.extend(position_[v]);
  tree_.update(t, box);
}

std::int32_t CageEditor::apply_split(std::int32_t u, std::int32_t v, const Point& position) {
  Patch& patch = scratch_.patch;
  if (!make_split_patch(u, v, patch)) assert(false);
  if (used_ + 2 > triangle_.size()) rebuild_tree();
  const auto p = static_cast<std::int32_t>(position_.size());
  position_.push_back(position);
  incident_.emplace_back();
  for (const std::int32_t t : patch.old_triangles) {
    for (const std::int32_t w : triangle_[t]) std::erase(incident_[w], t);
  }
  for (std::size_t i = 0; i < patch.ring.size(); ++i) {
    const RingEdge& edge = patch.ring[i];
    // The first of each old triangle's two takes its place.
    const std::int32_t t = i % 2 == 0 ? edge.triangle : static_cast<std::int32_t>(used_++);
    triangle_[t] = {p, edge.a, edge.b};
    for (const std::int32_t w : triangle_[t]) incident_[w].push_back(t);
    update_box(t);
  }
  face_count_ += 2;
  return p;
}

void CageEditor::apply_move(std::int32_t vertex, const Point& position) {
  position_[vertex] = position;
  for (const std::int32_t t : incident_[vertex]) update_box(t);
  if (++edits_ > face_count_ + 64) rebuild_tree();
}

void CageEditor::apply_collapse(std::int32_t u, std::int32_t v, const Point& position) {
  std::vector<std::int32_t> kept;
  for (const std::int32_t t : incident_[u]) {
    auto& corner = triangle_[t];
    if (std::find(corner.begin(), corner.end(), v) == corner.end()) {
      kept.push_back(t);
      continue;
    }
    for (const std::int32_t w : corner) {
      if (w != u) std::erase(incident_[w], t);
    }
    tree_.remove(t);
    corner[0] = -1;
    --face_count_;
  }
  for (const std::int32_t t : incident_[v]) {
    for (std::int32_t& w : triangle_[t]) {
      if (w == v) w = u;
    }
    kept.push_back(t);
  }
  incident_[u] = std::move(kept);
  incident_[v].clear();
  apply_move(u, position);
  if (face_count_ < built_for_ * 7 / 10) rebuild_tree();
}

TriangleMesh CageEditor::extract() const {
  std::vector<std::int32_t> number(position_.size(), -1);
  std::int32_t count = 0;
  for (std::size_t v = 0; v < position_.size(); ++v) {
    if (!incident_[v].empty()) number[v] = count++;
  }
  TriangleMesh mesh;
  mesh.vertices.resize(count, 3);
  mesh.triangles.resize(face_count_, 3);
  for (std::size_t v = 0; v < position_.size(); ++v) {
    if (number[v] >= 0) mesh.vertices.row(number[v]) = position_[v].transpose();
  }
  std::int64_t row = 0;
  for (const auto& corner : triangle_) {
    if (corner[0] < 0) continue;
    for (int k = 0; k < 3; ++k) mesh.triangles(row, k) = number[corner[k]];
    ++row;
  }
  assert(row == face_count_);
  return mesh;
}

}  // namespace encage::makers
