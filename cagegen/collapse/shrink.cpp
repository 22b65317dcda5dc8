// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/shrink.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <thread>
#include <vector>

#include "cagegen/collapse/cage_editor.h"
#include "cagegen/geometry/closest.h"
#include "cagegen/geometry/rounding.h"
#include "cagegen/geometry/triangle_tree.h"

namespace encage::makers {

namespace {

constexpr std::int64_t kFaceTests = 120'000;  // budget of one call
constexpr int kIterations = 40;
constexpr int kRounds = 6;     // of contact generation in one iteration
constexpr int kSweeps = 40;    // of projected Gauss-Seidel in one solve
constexpr double kLift = 1.6;  // clearances that a contact asks for
constexpr std::size_t kHitLimit = 24;
constexpr double kThinnest = 1e-4;

using Index3 = std::array<std::int32_t, 3>;

/// A face of the cage and what it met: an obstacle triangle, or (negative: -1 - face) another face.
struct Pair {
  std::int32_t face;
  std::int32_t other;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// sum over k of weight[k] normal . Y[vertex[k]] >= offset
struct Contact {
  Pair pair;
  Point normal;
  std::array<std::int32_t, 6> vertex;
  std::array<double, 6> weight;
  int count;
  double offset;
  double norm2;
  double multiplier;
};

class Shrinker {
 public:
  Shrinker(const Obstacle& obstacle, const TriangleMesh& cage, double clearance, double self_clearance, int threads)
      : obstacle_(obstacle), clearance_(clearance), self_clearance_(self_clearance), threads_(threads) {
    for (std::int64_t v = 0; v < cage.vertices.rows(); ++v) {
      position_.push_back(cage.vertex(static_cast<std::int32_t>(v)));
    }
    incident_.resize(position_.size());
    for (std::int64_t t = 0; t < cage.triangles.rows(); ++t) {
      face_.push_back({cage.triangles(t, 0), cage.triangles(t, 1), cage.triangles(t, 2)});
      for (const std::int32_t v : face_.back()) incident_[v].push_back(static_cast<std::int32_t>(t));
    }
  }

  void run(const std::function<void()>& check) {
    double step = first_step();
    double volume = enclosed(position_);
    const double first_volume = volume;
    for (int iteration = 0; iteration < kIterations && budget_ > 0; ++iteration) {
      check();
      const double before = volume;
      std::vector<Point> next = advance(step, check);
      const double after = enclosed(next);
      if (after < before && encloses_all(next)) {
        position_ = std::move(next);
        volume = after;
      }
      if (before - volume < 0.02 * step * area()) step *= 0.6;
      if (before - volume < 1e-5 * (first_volume - volume) && iteration > 3) break;
      if (step < clearance_ * 0.1) break;
    }
  }

  const std::vector<Point>& positions() const { return position_; }

 private:
  Corners corners(const std::vector<Point>& y, std::int32_t f) const {
    return {y[face_[f][0]], y[face_[f][1]], y[face_[f][2]]};
  }

  double enclosed(const std::vector<Point>& y) const {
    const Point reference = y.front();
    double sum = 0;
    for (const Index3& f : face_) {
      sum += (y[f[0]] - reference).dot((y[f[1]] - reference).cross(y[f[2]] - reference));
    }
    return sum / 6;
  }

  double area() const {
    double sum = 0;
    for (const Index3& f : face_) {
      sum += (position_[f[1]] - position_[f[0]]).cross(position_[f[2]] - position_[f[0]]).norm() / 2;
    }
    return sum;
  }

  /// About the mean gap: the distance from a sample of the face centres to the obstacle is costly,
  /// a share of the edge length does as well, since steps adapt.
  double first_step() const { return 0.06 * std::sqrt(area() / static_cast<double>(face_.size())); }

  /// The gradient of the volume per vertex (an area vector), as a unit direction.
  std::vector<Point> outward() const {
    std::vector<Point> direction(position_.size(), Point::Zero());
    for (const Index3& f : face_) {
      const Point n = (position_[f[1]] - position_[f[0]]).cross(position_[f[2]] - position_[f[0]]);
      for (const std::int32_t v : f) direction[v] += n;
    }
    for (Point& d : direction) {
      if (d.norm() > 0) d.normalize();
    }
    return direction;
  }

  /// One step from the present valid state to the next.
  std::vector<Point> advance(double step, const std::function<void()>& check) {
    const std::vector<Point> direction = outward();
    std::vector<Point> wanted(position_.size());
    for (std::size_t v = 0; v < wanted.size(); ++v) wanted[v] = position_[v] - step * direction[v];
    // Contacts that pushed last time will push again.
    std::vector<Pair> known;
    for (const Contact& c : contacts_) {
      if (c.multiplier > 0) known.push_back(c.pair);
    }
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    contacts_.clear();
    for (const Pair& pair : known) add_contact(pair, false);
    std::vector<Point> y;
    std::vector<Pair> hits;
    for (int round = 0; round < kRounds; ++round) {
      check();
      y = project(wanted);
      for (Point& p : y) p = round_to_float(p);
      hits = find_hits(y);
      if (hits.empty()) return retreat(y, lost_cones(y));
      for (const Pair& pair : hits) {
        const bool again = std::binary_search(known.begin(), known.end(), pair);
        add_contact(pair, again);
      }
      known.insert(known.end(), hits.begin(), hits.end());
      std::sort(known.begin(), known.end());
      known.erase(std::unique(known.begin(), known.end()), known.end());
    }
    return retreat(std::move(y), std::move(hits));
  }

  /// What still touches goes back to where it was; its neighbours may then touch in turn.
  std::vector<Point> retreat(std::vector<Point> y, std::vector<Pair> hits) {
    while (!hits.empty()) {
      for (const Pair& pair : hits) {
        for (const std::int32_t v : face_[pair.face]) y[v] = position_[v];
        if (pair.other >= 0) continue;
        for (const std::int32_t v : face_[-1 - pair.other]) y[v] = position_[v];
      }
      hits = find_hits(y);
      if (hits.empty()) hits = lost_cones(y);
    }
    return y;
  }

  /// False if a component of the obstacle has been passed as a whole, without a touch at the end of the
  /// step: a small one, or a surface parallel to the cage. A shorter step will meet it.
  bool encloses_all(const std::vector<Point>& y) {
    std::vector<Point> passed;
    for (std::size_t f = 0; f < face_.size(); ++f) {
      const auto face = static_cast<std::int32_t>(f);
      const Corners mine = corners(y, face);
      const Corners old = corners(position_, face);
      if (mine == old) continue;
      Eigen::AlignedBox3d box;
      for (int k = 0; k < 3; ++k) box.extend(mine[k]).extend(old[k]);
      obstacle_.representatives(box, passed);
    }
    const auto before = [](const Point& a, const Point& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    std::sort(passed.begin(), passed.end(), before);
    passed.erase(std::unique(passed.begin(), passed.end()), passed.end());
    budget_ -= static_cast<std::int64_t>(face_.size() * passed.size() / 50);
    return std::all_of(passed.begin(), passed.end(), [&](const Point& x) {
      double angle = 0;
      for (std::size_t f = 0; f < face_.size(); ++f) angle += solid_angle(x, corners(y, static_cast<std::int32_t>(f)));
      return angle > 6;  // 4 pi, or 0 outside
    });
  }

  /// The faces around every vertex that would lose its cone of outward directions: the next coarser
  /// level could not start there.
  std::vector<Pair> lost_cones(const std::vector<Point>& y) const {
    std::vector<Pair> found;
    std::vector<Point> normals;
    const auto has_cone = [&](const std::vector<Point>& positions, std::size_t v) {
      normals.clear();
      for (const std::int32_t f : incident_[v]) normals.push_back(Prism(corners(positions, f)).normal);
      return common_direction(normals);
    };
    for (std::size_t v = 0; v < incident_.size(); ++v) {
      bool changed = false;
      for (const std::int32_t f : incident_[v]) changed = changed || corners(y, f) != corners(position_, f);
      if (!changed || has_cone(y, v) || !has_cone(position_, v)) continue;
      for (const std::int32_t f : incident_[v]) found.push_back({f, -1 - f});
    }
    return found;
  }

  /// Linearises a pair at the present valid state. `strict`: all corners of the face stay beyond the
  /// plane between the closest points, which separates two convex sets for sure.
  void add_contact(const Pair& pair, bool strict) {
    const Corners mine = corners(position_, pair.face);
    const bool self = pair.other < 0;
    const std::int32_t other_face = -1 - pair.other;
    const Corners theirs = self ? corners(position_, other_face) : obstacle_.corners(pair.other);
    if (self) {
      for (const std::int32_t v : face_[pair.face]) {
        for (const std::int32_t w : face_[other_face]) {
          if (v == w) return;  // neighbours: no gap to keep; such hits are taken back
        }
      }
    }
    const ClosestPair closest = closest_points(mine, theirs);
    Point p = Point::Zero();
    Point q = Point::Zero();
    for (int k = 0; k < 3; ++k) {
      p += closest.weight_s[k] * mine[k];
      q += closest.weight_t[k] * theirs[k];
    }
    const double distance = (p - q).norm();
    if (!(distance > 0)) return;
    const Point normal = (p - q) / distance;
    // Never ask for more than there is: the present state must remain feasible.
    const double gap = std::min(kLift * (self ? self_clearance_ : clearance_), distance);
    if (strict && !self) {
      for (int k = 0; k < 3; ++k) {
        Contact c{pair, normal, {}, {}, 1, normal.dot(q) + gap, 1, 0};
        c.vertex[0] = face_[pair.face][k];
        c.weight[0] = 1;
        contacts_.push_back(c);
      }
      return;
    }
    Contact c{pair, normal, {}, {}, 3, gap, 0, 0};
    for (int k = 0; k < 3; ++k) {
      c.vertex[k] = face_[pair.face][k];
      c.weight[k] = closest.weight_s[k];
    }
    if (self) {
      c.count = 6;
      for (int k = 0; k < 3; ++k) {
        c.vertex[3 + k] = face_[other_face][k];
        c.weight[3 + k] = -closest.weight_t[k];
      }
    } else {
      c.offset += normal.dot(q);
    }
    for (int k = 0; k < c.count; ++k) c.norm2 += c.weight[k] * c.weight[k];
    contacts_.push_back(c);
  }

  /// min |Y - wanted|^2 under the contacts, by projected Gauss-Seidel on the multipliers.
  std::vector<Point> project(const std::vector<Point>& wanted) {
    std::vector<Point> y = wanted;
    for (const Contact& c : contacts_) {
      for (int k = 0; k < c.count; ++k) y[c.vertex[k]] += c.multiplier * c.weight[k] * c.normal;
    }
    const double tolerance = 0.05 * clearance_;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      double worst = 0;
      for (Contact& c : contacts_) {
        double value = 0;
        for (int k = 0; k < c.count; ++k) value += c.weight[k] * c.normal.dot(y[c.vertex[k]]);
        const double change = std::max((c.offset - value) / c.norm2, -c.multiplier);
        if (change == 0) continue;
        worst = std::max(worst, std::abs(change) * std::sqrt(c.norm2));
        c.multiplier += change;
        for (int k = 0; k < c.count; ++k) y[c.vertex[k]] += change * c.weight[k] * c.normal;
      }
      if (worst < tolerance) break;
    }
    return y;
  }

  /// All pairs that touch at y, sorted. Faces are shared out among the threads; the order is the same.
  std::vector<Pair> find_hits(const std::vector<Point>& y) {
    budget_ -= static_cast<std::int64_t>(face_.size());
    std::vector<Eigen::AlignedBox3d> boxes(face_.size());
    for (std::size_t f = 0; f < face_.size(); ++f) {
      for (const std::int32_t v : face_[f]) boxes[f].extend(y[v]);
    }
    const TriangleTree tree(boxes);
    const int parts = face_.size() < 256 ? 1 : std::max(1, threads_);
    std::vector<std::vector<Pair>> found(static_cast<std::size_t>(parts));
    const auto work = [&](int part) {
      const std::size_t first = face_.size() * part / parts;
      const std::size_t last = face_.size() * (part + 1) / parts;
      for (std::size_t f = first; f < last; ++f) face_hits(y, tree, static_cast<std::int32_t>(f), found[part]);
    };
    std::vector<std::thread> threads;
    for (int part = 1; part < parts; ++part) threads.emplace_back(work, part);
    work(0);
    for (std::thread& thread : threads) thread.join();
    std::vector<Pair> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    std::sort(all.begin(), all.end());
    return all;
  }

  void face_hits(const std::vector<Point>& y, const TriangleTree& tree, std::int32_t f,
                 std::vector<Pair>& found) const {
    const Corners mine = corners(y, f);
    const Corners old = corners(position_, f);
    const Prism prism(mine);
    double longest2 = 0;
    for (int k = 0; k < 3; ++k) longest2 = std::max(longest2, (mine[(k + 1) % 3] - mine[k]).squaredNorm());
    const double doubled = (mine[1] - mine[0]).cross(mine[2] - mine[0]).norm();
    const bool unchanged = mine == old;
    if (!unchanged && !(prism.valid && doubled > kThinnest * longest2)) {
      found.push_back({f, -1 - f});
      return;
    }
    thread_local std::vector<std::int32_t> triangles;
    triangles.clear();
    if (!unchanged) obstacle_.hits(prism, clearance_, kHitLimit, triangles);
    for (const std::int32_t t : triangles) found.push_back({f, t});
    tree.traverse(obstacle_.near(prism, self_clearance_), [&](std::int32_t other) {
      if (other <= f) return;
      const Corners theirs = corners(y, other);
      if (unchanged && theirs == corners(position_, other)) return;
      if (!separated(face_[f], mine, face_[other], theirs, self_clearance_)) found.push_back({f, -1 - other});
    });
  }

  const Obstacle& obstacle_;
  double clearance_;
  double self_clearance_;
  int threads_;
  std::vector<Point> position_;
  std::vector<Index3> face_;
  std::vector<std::vector<std::int32_t>> incident_;  ///< faces of each vertex
  std::vector<Contact> contacts_;
  std::int64_t budget_ = kFaceTests;
};

}  // namespace

TriangleMesh shrink(const Obstacle& obstacle, const TriangleMesh& cage, double clearance, double self_clearance,
                    int threads, const std::function<void()>& check) {
  Shrinker shrinker(obstacle, cage, clearance, self_clearance, threads);
  shrinker.run(check);
  TriangleMesh result = cage;
  for (std::int64_t v = 0; v < result.vertices.rows(); ++v) {
    result.vertices.row(v) = shrinker.positions()[static_cast<std::size_t>(v)].transpose();
  }
  return result;
}

}  // namespace encage::makers
