// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/cage_distance.h"

#include "cagegen/certify/exact.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace encage::proof {
namespace {

using Vector = Eigen::Vector3d;

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// The largest part of a bound that may be uncertain, where the work suffices. The estimate of the mean is on the low
/// side.
constexpr double max_tolerance = 0.01;
constexpr double mean_tolerance = 0.02;
/// Splits of pieces for a cage of so many triangles. The mean of a triangle that is never split has no estimate.
std::size_t most_splits(std::size_t triangles) {
  return std::max(16'000 + std::min<std::size_t>(10 * triangles, 100'000), 2 * triangles);
}

/// Triangles that cover() looks at before it gives up.
constexpr std::size_t most_covering = 48;
/// Of the largest coordinate: 512 units of rounding. A point of a piece is an average of 40 roundings at most, a
/// computed foot differs from a point of the surface by 10, and a distance by as many.
constexpr double rounding = 0x1p-44;

/// A point of triangle t, with weights between 0 and 1 that add up to 1 whatever the rounding: never nearer than the
/// nearest one.
Vector point_near(const Vector& p, const Corners& t) {
  const Vector u = t[1] - t[0];
  const Vector v = t[2] - t[0];
  const Vector w = p - t[0];
  const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm();
  const double wu = w.dot(u), wv = w.dot(v);
  const double det = uu * vv - uv * uv;
  if (det > 0) {
    const double b = (wu * vv - wv * uv) / det;
    const double c = (wv * uu - wu * uv) / det;
    // In a sliver the weights have no digits left, but the edges do.
    if (b >= 0 && c >= 0 && b + c <= 1 && det > 1e-20 * uu * vv) return t[0] + b * u + c * v;
  }
  Vector best = t[0];
  double least = unbounded;
  for (int k = 0; k < 3; ++k) {
    const Vector& a = t[k];
    const Vector along = t[(k + 1) % 3] - a;
    const double length2 = along.squaredNorm();
    const double s = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0;
    const Vector q = a + s * along;
    const double distance2 = (p - q).squaredNorm();
    if (distance2 < least) {
      least = distance2;
      best = q;
    }
  }
  return best;
}

double box_distance2(const BoxTree::Node& node, const Vector& p) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double beside = std::max({node.low[k] - p[k], p[k] - node.high[k], 0.0});
    sum += beside * beside;
  }
  return sum;
}

/// Heights of the surface over a flat region.
struct Heights {
  double low = unbounded;
  double high = -unbounded;
  double area = 0;      ///< of what has been looked at, in the plane; what is covered twice counts twice
  double integral = 0;  ///< of the heights over that area
};

/// A triangle Y in a frame: a plane, and half-planes of it. Every point of Y is within shift() of their intersection.
class Region {
 public:
  /// `up` is the unit normal of the plane, `along` a unit vector in it. `margin` exceeds the rounding of coordinates.
  Region(const Corners& y, const Vector& up, const Vector& along, double margin)
      : origin_(y[0]), u_(along), v_(up.cross(along)), up_(up), margin_(margin) {
    Flat least = Flat::Constant(unbounded), largest = -least;
    for (int k = 0; k < 3; ++k) {
      const Vector local = to_frame(y[k]);
      corner_[k] = local.head<2>();
      least = least.cwiseMin(corner_[k]);
      largest = largest.cwiseMax(corner_[k]);
      low_ = std::min(low_, local[2]);
      high_ = std::max(high_, local[2]);
    }
    const Flat e = corner_[1] - corner_[0], f = corner_[2] - corner_[0];
    const double turn = e.x() * f.y() - e.y() * f.x();
    const double width = (largest - least).maxCoeff();
    if (std::abs(turn) > 0.01 * width * width) {
      // Less by a margin, so that what merely begins at a side is out. Y shrinks towards the centre of its incircle.
      area_ = std::abs(turn) / 2;
      double around = 0;
      for (int k = 0; k < 3; ++k) {
        const Flat edge = (corner_[(k + 1) % 3] - corner_[k]) * (turn > 0 ? 1 : -1);
        const Flat outward = Flat(edge.y(), -edge.x()).normalized();
        around += edge.norm();
        side_[count_++] = {outward, outward.dot(corner_[k]) - margin};
      }
      const double radius = 2 * area_ / around;
      lost_ = 2 * margin / radius;
      shift_ = lost_ * around;
    } else {
      for (int axis = 0; axis < 2; ++axis) {
        side_[count_++] = {Flat::Unit(axis), largest[axis] + margin};
        side_[count_++] = {-Flat::Unit(axis), -least[axis] + margin};
      }
    }
  }

  /// Two coordinates in the plane, then the height.
  Vector to_frame(const Vector& p) const {
    const Vector d = p - origin_;
    return {d.dot(u_), d.dot(v_), d.dot(up_)};
  }

  double low() const { return low_; }    ///< the least height of Y's corners
  double high() const { return high_; }  ///< the largest
  double area() const { return area_; }  ///< of Y; 0 if it is next to a segment
  double lost() const { return lost_; }  ///< part of Y's area that is not in the intersection
  double shift() const { return shift_; }

  /// False only if the segment misses Y.
  bool meets(const Vector& a, const Vector& b) const {
    for (int s = 0; s < count_; ++s) {
      if (side_[s].above(a) > 0 && side_[s].above(b) > 0) return false;
    }
    const Flat along = (b - a).head<2>();
    const Flat across(-along.y(), along.x());
    const double reach = margin_ * across.cwiseAbs().sum();
    double low = unbounded, high = -unbounded;
    for (const Flat& corner : corner_) {
      const double x = across.dot(corner - a.head<2>());
      low = std::min(low, x);
      high = std::max(high, x);
    }
    return low <= reach && high >= -reach;
  }

  /// Adds the part of a triangle that lies over the region to the heights; false if there is none.
  bool clip(const Vector (&triangle)[3], Heights& heights) const {
    Vector buffer[2][8];
    std::copy(triangle, triangle + 3, buffer[0]);
    int from = 0;
    int size = 3;
    for (int s = 0; s < count_; ++s) {
      Vector* const out = buffer[1 - from];
      const Vector* const in = buffer[from];
      int kept = 0;
      double above = side_[s].above(in[size - 1]);
      for (int i = 0; i < size; ++i) {
        const Vector& last = in[i == 0 ? size - 1 : i - 1];
        const double next = side_[s].above(in[i]);
        if ((above <= 0) != (next <= 0)) out[kept++] = last + above / (above - next) * (in[i] - last);
        if (next <= 0) out[kept++] = in[i];
        above = next;
      }
      if (kept == 0) return false;
      size = kept;
      from = 1 - from;
    }
    const Vector* const part = buffer[from];
    for (int i = 0; i < size; ++i) {
      heights.low = std::min(heights.low, part[i][2]);
      heights.high = std::max(heights.high, part[i][2]);
      if (i < 2) continue;
      const Flat e = (part[i - 1] - part[0]).head<2>(), f = (part[i] - part[0]).head<2>();
      const double area = std::abs(e.x() * f.y() - e.y() * f.x()) / 2;
      heights.area += area;
      heights.integral += area * (part[0][2] + part[i - 1][2] + part[i][2]) / 3;
    }
    return true;
  }

 private:
  using Flat = Eigen::Vector2d;
  struct Side {
    Flat outward;
    double offset;
    double above(const Vector& p) const { return outward.x() * p.x() + outward.y() * p.y() - offset; }
  };
  Vector origin_, u_, v_, up_;
  double margin_;
  Flat corner_[3];
  Side side_[4];
  int count_ = 0;
  double low_ = unbounded;
  double high_ = -unbounded;
  double area_ = 0;
  double lost_ = 0;
  double shift_ = 0;
};

/// Proves that every point of the region lies under or over a point of the surface, at heights between `low` and
/// `high`, and adds up those heights. It walks from triangle to triangle through every edge that the region meets. If
/// all of them face the same side and none of the edges is an open one, then what they cover of the region is open and
/// closed in it, hence all of it.
bool cover(const DistanceSurface& surface, const Region& region, const std::array<std::int32_t, 3>& starts,
           double margin, double low, double high, Heights& heights) {
  std::int32_t found[most_covering];
  std::size_t count = 0;
  double side = 0;
  const auto corners_of = [&](std::int32_t t, Vector(&corner)[3]) {
    for (int k = 0; k < 3; ++k) corner[k] = region.to_frame(surface.mesh().corner(t, k));
  };
  const auto turn_of = [&](const Vector(&corner)[3]) {
    const Vector e = corner[1] - corner[0], f = corner[2] - corner[0];
    const double turn = e.x() * f.y() - e.y() * f.x();
    return std::abs(turn) > margin * (e.lpNorm<1>() + f.lpNorm<1>()) ? turn : 0;
  };
  for (const std::int32_t t : starts) {
    Vector corner[3];
    corners_of(t, corner);
    Heights ignored;
    const double turn = turn_of(corner);
    if (turn == 0 || !region.clip(corner, ignored)) continue;
    side = turn > 0 ? 1 : -1;
    found[count++] = t;
    break;
  }
  for (std::size_t next = 0; next < count; ++next) {
    const std::int32_t t = found[next];
    Vector corner[3];
    corners_of(t, corner);
    if (!region.clip(corner, heights)) continue;
    if (heights.low < low || heights.high > high) return false;
    if (!(side * turn_of(corner) > 0)) return false;
    for (int k = 0; k < 3; ++k) {
      if (!region.meets(corner[k], corner[(k + 1) % 3])) continue;
      const std::int32_t other = surface.neighbour(t, k);
      if (other < 0) return false;
      if (std::find(found, found + count, other) != found + count) continue;
      if (count == most_covering) return false;
      found[count++] = other;
    }
  }
  return count > 0;
}

/// A mean over a triangle of the positive part of a linear function.
double mean_above_zero(double a, double b, double c) {
  if (a < b) std::swap(a, b);
  if (b < c) std::swap(b, c);
  if (a < b) std::swap(a, b);
  if (!(a > 0)) return 0;
  if (c >= 0) return (a + b + c) / 3;
  if (b <= 0) return a * a * a / (3 * (a - b) * (a - c));
  return (a + b + c) / 3 - c * c * c / (3 * (c - a) * (c - b));
}

/// Upper bounds over a triangle.
struct Bound {
  double max = unbounded;
  double mean = unbounded;

  void offer(const Vector& at_corners) {
    max = std::min(max, at_corners.maxCoeff());
    mean = std::min(mean, at_corners.mean());
  }
};

/// Two functions that lie below the linear ones with these values at the corners: so does the smaller of both.
void offer_both(const Vector& a, const Vector& b, Bound& bound) {
  // The largest of the smaller is at most that of any weighted mean, and the best weights make two corners equal.
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 3; ++j) {
      const double rise = (a[i] - b[i]) - (a[j] - b[j]);
      if (rise == 0) continue;
      const double weight = std::clamp((b[j] - b[i]) / rise, 0.0, 1.0);
      bound.max = std::min(bound.max, (weight * a + (1 - weight) * b).maxCoeff());
    }
  }
  const Vector d = a - b;
  bound.mean = std::min(bound.mean, a.mean() - mean_above_zero(d[0], d[1], d[2]));
}

/// Adaptive subdivision of a cage's triangles.
class Subdivision {
 public:
  Subdivision(const DistanceSurface& surface, const TriangleMesh& cage) : surface_(surface) {
    magnitude_ = std::max(cage.vertices.cwiseAbs().maxCoeff(), surface.mesh().vertices.cwiseAbs().maxCoeff());
    splits_left_ = most_splits(static_cast<std::size_t>(cage.triangles.rows()));
    std::int32_t near = 0;
    for (Eigen::Index v = 0; v < cage.vertices.rows(); ++v) near = add_sample(cage.vertices.row(v), near).foot.triangle;
    for (std::int32_t t = 0; t < cage.triangles.rows(); ++t) {
      const Vector normal = (cage.corner(t, 1) - cage.corner(t, 0)).cross(cage.corner(t, 2) - cage.corner(t, 0));
      Piece piece;
      piece.corner = {cage.triangles(t, 0), cage.triangles(t, 1), cage.triangles(t, 2)};
      piece.area = normal.norm() / 2;
      piece.defect = unbounded;  // until its edges' middles are known
      bound(piece, unbounded);
      pieces_.push_back(piece);
    }
  }

  DistanceBounds run() {
    DistanceBounds result;
    result.max_distance = refine_max(splits_left_ / 2);
    refine_mean();
    double area = 0, sum = 0, largest = 0;
    for (const Piece& piece : pieces_) {
      if (piece.split) continue;
      area += piece.area;
      sum += piece.area * piece.bound.mean;
      largest = std::max(largest, piece.bound.max);
    }
    const double slack = 1 + 1e-9;  // for the sums
    result.max_distance = std::min(result.max_distance, largest) * slack + rounding * magnitude_;
    result.mean_distance = std::min(result.max_distance, sum / area * slack + rounding * magnitude_);
    return result;
  }

 private:
  struct Sample {
    Vector point;
    DistanceSurface::Foot foot;
  };
  struct Piece {
    std::array<std::int32_t, 3> corner;  ///< samples
    double area = 0;
    Bound bound;
    double estimate = 0;  ///< of the mean
    double defect = 0;    ///< what the mean of the corners is believed to exceed the mean by
    bool split = false;

    double uncertain() const { return area * std::abs(bound.mean - estimate); }
  };

  const Sample& add_sample(const Vector& p, std::int32_t near) {
    samples_.push_back({p, surface_.nearest(p, near)});
    reached_ = std::max(reached_, samples_.back().foot.distance);
    return samples_.back();
  }

  std::int32_t middle(std::int32_t a, std::int32_t b) {
    const auto [low, high] = std::minmax(a, b);
    const std::uint64_t key = static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high);
    const auto [it, added] = middles_.try_emplace(key, static_cast<std::int32_t>(samples_.size()));
    if (added) {
      const Vector p = (samples_[low].point + samples_[high].point) / 2;
      const DistanceSurface::Foot other = surface_.foot(p, samples_[high].foot.triangle);
      const bool nearer = other.distance < surface_.foot(p, samples_[low].foot.triangle).distance;
      add_sample(p, samples_[nearer ? high : low].foot.triangle);
    }
    return it->second;
  }

  /// Bounds over a piece. `limit` bounds the maximum: that over the piece it is a part of.
  void bound(Piece& piece, double limit) {
    const Sample* const s[3] = {&samples_[piece.corner[0]], &samples_[piece.corner[1]], &samples_[piece.corner[2]]};
    const Vector nearest(s[0]->foot.distance, s[1]->foot.distance, s[2]->foot.distance);
    piece.bound = {limit, unbounded};
    // The distance to one triangle is a convex function: it lies below the linear one with its values at the corners.
    Vector row[3];
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        row[k][i] = i == k ? nearest[k] : surface_.foot(s[i]->point, s[k]->foot.triangle).distance;
      }
      piece.bound.offer(row[k]);
    }
    for (int k = 0; k < 3; ++k) offer_both(row[k], row[(k + 1) % 3], piece.bound);
    const double mean = nearest.mean();
    piece.estimate = std::min(mean, std::max(0.0, mean - piece.defect));
    if (piece.bound.mean > mean * (1 + max_tolerance / 4) ||
        piece.bound.max > nearest.maxCoeff() * (1 + max_tolerance / 4)) {
      offer_covered(s, piece.bound);
    }
  }

  /// The nearest points of the corners span a triangle Y; the point with weights w of the piece is moved to that with
  /// weights w of Y, then along a fixed direction to the surface. How far that is, is a convex function of w and of the
  /// height of the surface, so that the corners bound it. Unlike the distance to one triangle, it is tight where the
  /// surface is flat but has many triangles.
  void offer_covered(const Sample* const (&s)[3], Bound& bound) const {
    const Corners y{s[0]->foot.point, s[1]->foot.point, s[2]->foot.point};
    Vector out = Vector::Zero();
    Vector longest = Vector::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vector edge = y[(k + 1) % 3] - y[k];
      if (edge.squaredNorm() > longest.squaredNorm()) longest = edge;
      if (s[k]->foot.distance > 0) out += (s[k]->point - y[k]) / s[k]->foot.distance;
    }
    const double length = longest.norm();
    if (!(length > 1e-9 * magnitude_) || !(out.norm() > 0.3)) return;
    const Vector along = longest / length;
    out.normalize();
    Vector up = (y[1] - y[0]).cross(y[2] - y[0]);
    if (up.norm() > 1e-3 * length * length) {
      if (up.dot(out) < 0) up = -up;
    } else {
      up = out - out.dot(along) * along;
      if (!(up.norm() > 0.3)) return;
    }
    up.normalize();
    if (!(up.dot(out) > 0.3)) return;
    up = (up - up.dot(along) * along).normalized();
    const double margin = rounding * magnitude_;
    const Region region(y, up, along, margin);
    Vector d[3];
    double middle_height = 0;
    for (int k = 0; k < 3; ++k) {
      d[k] = s[k]->point - y[k];
      middle_height += d[k].dot(up) / 3;
    }
    // Heights beyond these make the mean of the lengths larger than what is known.
    const double useful = std::max(bound.max, bound.mean);
    Heights heights;
    const std::array<std::int32_t, 3> starts{s[0]->foot.triangle, s[1]->foot.triangle, s[2]->foot.triangle};
    if (!cover(surface_, region, starts, margin, middle_height - useful, middle_height + useful, heights)) return;
    const double low = heights.low - region.high() - margin;
    const double high = heights.high - region.low() + margin;
    Vector at_low, at_high;
    for (int k = 0; k < 3; ++k) {
      at_low[k] = (d[k] - low * up).norm() + margin + region.shift();
      at_high[k] = (d[k] - high * up).norm() + margin + region.shift();
    }
    bound.offer(at_low.cwiseMax(at_high));
    // The length is convex in the height as well: below the chord from the least to the largest, for each corner.
    constexpr double overlap = 1e-6;
    if (!(heights.area < region.area() * (1 + overlap))) return;
    const double mean_height = heights.integral / region.area() - region.low();
    const double part = std::clamp((mean_height - low) / (high - low), 0.0, 1.0);
    const double change = (at_high - at_low).maxCoeff();
    const double unsure = 2 * overlap + region.lost() + (region.high() - region.low() + 2 * margin) / (high - low);
    bound.mean = std::min(bound.mean, at_low.mean() + part * change + unsure * std::abs(change));
  }

  void split(std::size_t index) {
    --splits_left_;
    Piece& parent = pieces_[index];
    parent.split = true;
    const std::array<std::int32_t, 3> a = parent.corner;
    const std::array<std::int32_t, 3> m{middle(a[0], a[1]), middle(a[1], a[2]), middle(a[2], a[0])};
    const auto mean = [&](const std::array<std::int32_t, 3>& at) {
      return (samples_[at[0]].foot.distance + samples_[at[1]].foot.distance + samples_[at[2]].foot.distance) / 3;
    };
    Piece child;
    child.area = parent.area / 4;
    // The mean of the edges' middles is that of a quadratic function. At creases a part is no better than the whole.
    child.defect = std::abs(mean(a) - mean(m));
    const double limit = parent.bound.max;
    for (int k = 0; k < 4; ++k) {
      child.corner = k == 3 ? m : std::array<std::int32_t, 3>{a[k], m[k], m[(k + 2) % 3]};
      bound(child, limit);
      pieces_.push_back(child);
    }
  }

  /// Splits where the maximum may lie. Returns a bound of it.
  double refine_max(std::size_t splits) {
    std::priority_queue<std::pair<double, std::size_t>> queue;
    const auto push = [&](std::size_t i) { queue.emplace(pieces_[i].bound.max, i); };
    for (std::size_t i = 0; i < pieces_.size(); ++i) push(i);
    while (splits > 0 && queue.top().first > reached_ * (1 + max_tolerance)) {
      const std::size_t index = queue.top().second;
      queue.pop();
      split(index);
      --splits;
      for (std::size_t i = pieces_.size() - 4; i < pieces_.size(); ++i) push(i);
    }
    return queue.top().first;
  }

  /// Splits where the mean is least certain.
  void refine_mean() {
    std::priority_queue<std::pair<double, std::size_t>> queue;
    double sum = 0, uncertain = 0;
    const auto add = [&](std::size_t i) {
      queue.emplace(pieces_[i].uncertain(), i);
      sum += pieces_[i].area * pieces_[i].bound.mean;
      uncertain += pieces_[i].uncertain();
    };
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (!pieces_[i].split) add(i);
    }
    while (splits_left_ > 0 && uncertain > mean_tolerance * sum) {
      const std::size_t index = queue.top().second;
      queue.pop();
      sum -= pieces_[index].area * pieces_[index].bound.mean;
      uncertain -= pieces_[index].uncertain();
      split(index);
      for (std::size_t i = pieces_.size() - 4; i < pieces_.size(); ++i) add(i);
    }
  }

  const DistanceSurface& surface_;
  double magnitude_ = 0;
  double reached_ = 0;  ///< the largest distance of a sample
  std::size_t splits_left_ = 0;
  std::vector<Sample> samples_;
  std::unordered_map<std::uint64_t, std::int32_t> middles_;
  std::vector<Piece> pieces_;
};

std::vector<std::array<std::int32_t, 3>> find_neighbours(const TriangleMesh& mesh) {
  struct Edge {
    std::int32_t low, high, triangle, side;
    bool forward;
  };
  std::vector<Edge> edges;
  edges.reserve(static_cast<std::size_t>(mesh.triangles.size()));
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.triangle, a.side) < std::tie(b.low, b.high, b.triangle, b.side);
  });
  std::vector<std::array<std::int32_t, 3>> result(static_cast<std::size_t>(mesh.triangles.rows()), {-1, -1, -1});
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high) ++last;
    if (last - first != 2 || edges[first].forward == edges[first + 1].forward) continue;
    result[edges[first].triangle][edges[first].side] = edges[first + 1].triangle;
    result[edges[first + 1].triangle][edges[first + 1].side] = edges[first].triangle;
  }
  return result;
}

}  // namespace

DistanceSurface::DistanceSurface(const TriangleMesh& mesh)
    : mesh_(mesh), tree_(mesh), neighbour_(find_neighbours(mesh)) {}

DistanceSurface::Foot DistanceSurface::foot(const Eigen::Vector3d& p, std::int32_t triangle) const {
  Foot result;
  result.point = point_near(p, {mesh_.corner(triangle, 0), mesh_.corner(triangle, 1), mesh_.corner(triangle, 2)});
  result.triangle = triangle;
  result.distance = (p - result.point).norm();
  return result;
}

DistanceSurface::Foot DistanceSurface::nearest(const Eigen::Vector3d& p, std::int32_t start) const {
  Foot best = foot(p, start);
  double least2 = best.distance * best.distance;
  std::pair<double, std::int32_t> stack[128];
  int size = 0;
  stack[size++] = {box_distance2(tree_.nodes[0], p), 0};
  while (size > 0) {
    const auto [distance2, index] = stack[--size];
    if (distance2 >= least2) continue;
    const BoxTree::Node& node = tree_.nodes[index];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const Foot other = foot(p, tree_.order[i]);
        if (!(other.distance < best.distance)) continue;
        best = other;
        least2 = best.distance * best.distance;
      }
      continue;
    }
    std::pair<double, std::int32_t> near{box_distance2(tree_.nodes[node.first], p), node.first};
    std::pair<double, std::int32_t> far{box_distance2(tree_.nodes[node.first + 1], p), node.first + 1};
    if (far.first < near.first) std::swap(near, far);
    stack[size++] = far;
    stack[size++] = near;
  }
  return best;
}

DistanceBounds distance_bounds(const DistanceSurface& surface, const TriangleMesh& cage) {
  return Subdivision(surface, cage).run();
}

}  // namespace encage::proof

namespace encage {

DistanceBounds distance_bounds(const TriangleMesh& surface, const TriangleMesh& cage) {
  if (surface.triangles.rows() == 0) throw Error("distance bounds: the surface has no triangles");
  if (cage.triangles.rows() == 0) throw Error("distance bounds: the cage has no triangles");
  return proof::distance_bounds(proof::DistanceSurface(surface), cage);
}

}  // namespace encage
