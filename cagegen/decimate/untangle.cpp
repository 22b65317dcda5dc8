// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/decimate.h"
#include "cagegen/decimate/self_contact.h"
#include "cagegen/geometry/closest.h"
#include "src/mesh/rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage::makers {

namespace {

/// Sign of the volume of (ray, a, b) around a line through the origin, the same for both triangles of an edge.
bool passes_left(const Point& direction, std::int32_t ia, const Point& a, std::int32_t ib, const Point& b) {
  return ia < ib ? direction.dot(a.cross(b)) >= 0 : direction.dot(b.cross(a)) < 0;
}

/// +1 if the ray leaves through the triangle, -1 if it enters, 0 if it misses it.
int crossing(const Point& start, const Point& direction, const std::array<std::int32_t, 3>& index, const Corners& t) {
  const Corners x{t[0] - start, t[1] - start, t[2] - start};
  const bool left = passes_left(direction, index[0], x[0], index[1], x[1]);
  for (int k = 1; k < 3; ++k) {
    if (passes_left(direction, index[k], x[k], index[(k + 1) % 3], x[(k + 1) % 3]) != left) return 0;
  }
  const Point normal = (x[1] - x[0]).cross(x[2] - x[0]);
  const double ahead = normal.dot(x[0]);  // positive: the plane lies ahead of a ray that leaves through it
  if (left ? ahead <= 0 : ahead >= 0) return 0;
  return left ? 1 : -1;
}

/// The translation of s against t, as short as possible, after which they are separated.
Point shortest_way_out(const Corners& s, const Corners& t, const Point& side) {
  const std::array<Point, 3> es{s[1] - s[0], s[2] - s[1], s[0] - s[2]};
  const std::array<Point, 3> et{t[1] - t[0], t[2] - t[1], t[0] - t[2]};
  Point best = side;
  double least = std::numeric_limits<double>::infinity();
  const auto ask = [&](const Point& axis) {
    const double length = axis.norm();
    if (length == 0) return;
    const Point unit = axis.dot(side) < 0 ? Point(-axis / length) : Point(axis / length);
    if (unit.dot(side) < 0.2) return;
    const double depth = std::max({unit.dot(t[0]), unit.dot(t[1]), unit.dot(t[2])}) -
                         std::min({unit.dot(s[0]), unit.dot(s[1]), unit.dot(s[2])});
    if (depth >= least) return;
    least = depth;
    best = unit;
  };
  ask(side);
  ask(es[0].cross(es[1]));
  ask(et[0].cross(et[1]));
  for (const Point& e : es) {
    for (const Point& f : et) ask(e.cross(f));
  }
  return std::isfinite(least) ? Point(least * best) : Point::Zero();
}

/// From the nearest point of t to the nearest one of s; disjoint triangles.
Point shortest_line(const Corners& s, const Corners& t) {
  const ClosestPair closest = closest_points(s, t);
  Point line = Point::Zero();
  for (int k = 0; k < 3; ++k) line += closest.weight_s[k] * s[k] - closest.weight_t[k] * t[k];
  return line;
}

/// The middle of the line in which two triangles intersect.
std::optional<Point> common_point(const Prism& s, const Prism& t) {
  Point sum = Point::Zero();
  int count = 0;
  for (const auto& [edges, face] : {std::pair(&s, &t), std::pair(&t, &s)}) {
    for (int k = 0; k < 3; ++k) {
      const Point& a = edges->corner[k];
      const Point& b = edges->corner[(k + 1) % 3];
      const double ha = face->height(a);
      const double hb = face->height(b);
      if (ha * hb > 0 || ha == hb) continue;
      const Point p = a + ha / (ha - hb) * (b - a);
      bool inside = true;
      for (int i = 0; i < 3; ++i) inside = inside && face->side[i].dot(p - face->corner[i]) <= 0;
      if (!inside) continue;
      sum += p;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

bool neighbours(const std::array<std::int32_t, 3>& s, const std::array<std::int32_t, 3>& t) {
  return std::any_of(s.begin(), s.end(), [&](std::int32_t v) { return std::find(t.begin(), t.end(), v) != t.end(); });
}

/// Moves the vertices of a mesh until none of its triangles are in contact.
class Untangler {
 public:
  /// For the first `pushes` rounds, strands are only pushed apart; after that, their surface is smoothed as well.
  Untangler(const TriangleMesh& mesh, double gap, int pushes);
  bool run();
  TriangleMesh take() { return std::move(mesh_); }

 private:
  void find_contacts();
  void mark_rough();
  void smooth();
  void push();
  void push_pair(const TrianglePair& pair);
  Point way_apart(const Prism& s, const Prism& t, const TrianglePair& pair) const;
  int winding_outside(const Point& start, const Point& direction, const TrianglePair& skipped) const;
  void move(std::int32_t v, const Point& position);
  void settle();

  TriangleMesh mesh_;
  double gap_;
  int pushes_;
  std::vector<std::int32_t> first_;  ///< per vertex, into around_
  std::vector<std::int32_t> around_;
  SurfaceTree tree_;
  std::vector<TrianglePair> contacts_;
  std::vector<int> rough_;  ///< per vertex: how many rings from it are smoothed, times patience_steps
  std::vector<bool> moved_;
  std::vector<Point> shift_;
  std::vector<int> shifts_;
};

// Rounds of a spot in contact after which the next ring of vertices around it is smoothed as well.
constexpr int patience_steps = 4;
constexpr int most_rounds = 120;

Untangler::Untangler(const TriangleMesh& mesh, double gap, int pushes)
    : mesh_(mesh),
      gap_(gap),
      pushes_(pushes),
      first_(static_cast<std::size_t>(mesh.vertices.rows()) + 1),
      tree_(mesh_) {
  const auto vertices = static_cast<std::size_t>(mesh.vertices.rows());
  for (const std::int32_t v : mesh_.triangles.reshaped()) ++first_[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
  around_.resize(static_cast<std::size_t>(mesh.triangles.size()));
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (std::int32_t t = 0; t < mesh_.triangles.rows(); ++t) {
    for (const std::int32_t v : indices(mesh_, t)) around_[next[v]++] = t;
  }
  rough_.assign(vertices, -pushes_);
  moved_.assign(vertices, true);
  shift_.assign(vertices, Point::Zero());
  shifts_.resize(vertices);
}

/// Contacts of triangles that have moved; those that have not were free before.
void Untangler::find_contacts() {
  std::vector<bool> dirty(static_cast<std::size_t>(mesh_.triangles.rows()));
  for (const TrianglePair& pair : contacts_) dirty[pair[0]] = dirty[pair[1]] = true;
  for (std::size_t v = 0; v < moved_.size(); ++v) {
    if (!moved_[v]) continue;
    for (std::int32_t i = first_[v]; i < first_[v + 1]; ++i) dirty[around_[i]] = true;
  }
  moved_.assign(moved_.size(), false);
  contacts_.clear();
  for (std::int32_t s = 0; s < mesh_.triangles.rows(); ++s) {
    if (!dirty[s]) continue;
    const Prism prism(corners(mesh_, s));
    if (!prism.valid) {
      contacts_.push_back({s, s});
      continue;
    }
    tree_.near(prism, gap_, [&](std::int32_t t) {
      if (t == s || (dirty[t] && t < s)) return;
      if (!separated(indices(mesh_, s), prism.corner, indices(mesh_, t), corners(mesh_, t), gap_))
        contacts_.push_back({s, t});
    });
  }
}

void Untangler::mark_rough() {
  enum : char { free, pushed, folded };
  std::vector<char> state(rough_.size(), free);
  for (const TrianglePair& pair : contacts_) {
    const char now = neighbours(indices(mesh_, pair[0]), indices(mesh_, pair[1])) ? folded : pushed;
    for (const std::int32_t t : pair) {
      for (const std::int32_t v : indices(mesh_, t)) state[v] = std::max(state[v], now);
    }
  }
  for (std::size_t v = 0; v < rough_.size(); ++v) {
    switch (state[v]) {
      case folded: rough_[v] = std::max(rough_[v], 0) + 1; break;
      case pushed: ++rough_[v]; break;
      default: rough_[v] += rough_[v] > 0 ? -1 : rough_[v] > -pushes_ ? -1 : 0;
    }
  }
}

void Untangler::move(std::int32_t v, const Point& position) {
  mesh_.vertices.row(v) = round_to_float(position).transpose();
  moved_[v] = true;
}

void Untangler::settle() {
  for (std::int32_t v = 0; v < mesh_.vertices.rows(); ++v) {
    if (shifts_[v] == 0) continue;
    move(v, mesh_.vertex(v) + shift_[v] / shifts_[v]);
    shift_[v].setZero();
    shifts_[v] = 0;
  }
  for (std::size_t v = 0; v < moved_.size(); ++v) {
    if (!moved_[v]) continue;
    for (std::int32_t i = first_[v]; i < first_[v + 1]; ++i) tree_.update(around_[i]);
  }
}

/// Half-way to the middle of the neighbours, around spots in contact.
void Untangler::smooth() {
  std::vector<int> reach = rough_;
  for (int ring = 0; ring < most_rounds / patience_steps; ++ring) {
    bool grown = false;
    for (std::int64_t t = 0; t < mesh_.triangles.rows(); ++t) {
      const auto index = indices(mesh_, t);
      const int most = std::max({reach[index[0]], reach[index[1]], reach[index[2]]}) - patience_steps;
      for (const std::int32_t v : index) {
        if (reach[v] >= most) continue;
        reach[v] = most;
        grown = true;
      }
    }
    if (!grown) break;
  }
  for (std::int32_t v = 0; v < mesh_.vertices.rows(); ++v) {
    if (reach[v] <= 0) continue;
    Point sum = Point::Zero();
    for (std::int32_t i = first_[v]; i < first_[v + 1]; ++i) {
      for (const std::int32_t w : indices(mesh_, around_[i])) {
        if (w != v) sum += mesh_.vertex(w);
      }
    }
    shift_[v] += 0.5 * (sum / (2 * (first_[v + 1] - first_[v])) - mesh_.vertex(v));
    ++shifts_[v];
  }
  settle();
}

int Untangler::winding_outside(const Point& start, const Point& direction, const TrianglePair& skipped) const {
  int winding = 0;
  tree_.along(start, direction, [&](std::int32_t t) {
    if (t == skipped[0] || t == skipped[1]) return;
    winding += crossing(start, direction, indices(mesh_, t), corners(mesh_, t));
  });
  return winding;
}

Point Untangler::way_apart(const Prism& s, const Prism& t, const TrianglePair& pair) const {
  if (separated(s.corner, t.corner, 0)) {
    const Point between = shortest_line(s.corner, t.corner);
    return std::max(1.2 * gap_ / between.norm() - 1, 0.0) * between;
  }
  const auto crossing = common_point(s, t);
  if (!crossing) return Point::Zero();
  // Where two solids overlap, both retreat; where a solid is turned inside out, both advance.
  const Point outside = s.normal + t.normal;
  Point side = t.normal - s.normal;
  if (side.squaredNorm() == 0) return Point::Zero();
  if (outside.squaredNorm() > 0 && winding_outside(*crossing, outside, pair) < 0) side = -side;
  const Point way = shortest_way_out(s.corner, t.corner, side.normalized());
  return way * (1 + 1.2 * gap_ / std::max(way.norm(), 1e-3 * gap_));
}

void Untangler::push_pair(const TrianglePair& pair) {
  const auto index_s = indices(mesh_, pair[0]);
  const auto index_t = indices(mesh_, pair[1]);
  if (neighbours(index_s, index_t)) return;
  const Prism s(corners(mesh_, pair[0]));
  const Prism t(corners(mesh_, pair[1]));
  if (!s.valid || !t.valid) return;
  Point way = way_apart(s, t, pair);
  // Farther than this, the neighbours would be overtaken.
  const double size = std::max((s.corner[1] - s.corner[0]).norm(), (t.corner[1] - t.corner[0]).norm());
  const double length = way.norm();
  if (length > size / 2) way *= size / 2 / length;
  for (int k = 0; k < 3; ++k) {
    shift_[index_s[k]] += way / 2;
    ++shifts_[index_s[k]];
    shift_[index_t[k]] -= way / 2;
    ++shifts_[index_t[k]];
  }
}

void Untangler::push() {
  for (const TrianglePair& pair : contacts_) push_pair(pair);
  settle();
}

bool Untangler::run() {
  round_vertices(mesh_);
  tree_.rebuild();
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  int stale = 0;
  for (int round = 0; round < most_rounds; ++round) {
    find_contacts();
    if (contacts_.empty()) return true;
    // Not a few spots but the shape as a whole.
    if (contacts_.size() > static_cast<std::size_t>(mesh_.triangles.rows())) return false;
    if (contacts_.size() < fewest) {
      fewest = contacts_.size();
      stale = 0;
    } else if (++stale > 40) {
      return false;
    }
    mark_rough();
    if (round % 2 == 0) {
      push();
    } else {
      smooth();
    }
  }
  return false;
}

}  // namespace

std::optional<TriangleMesh> untangle(const TriangleMesh& mesh, double gap) {
  // Mostly the first will do, and changes less.
  for (const int pushes : {12, 0}) {
    Untangler untangler(mesh, gap, pushes);
    if (untangler.run()) return untangler.take();
  }
  return std::nullopt;
}

}  // namespace encage::makers
