// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/contact/contact_solver.h"

#include "cagegen/geometry/closest.h"
#include "cagegen/geometry/separation.h"
#include "cagegen/threads/parallel.h"
#include "src/mesh/rounding.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

namespace encage::makers {

namespace {

constexpr int most_rounds = 8;   // of contact generation in one step
constexpr int most_sweeps = 60;  // of projected Gauss-Seidel in one solve
constexpr int slow_sweeps = 400;
constexpr double lift_clearances = 1.6;  // clearances that a contact asks for
constexpr std::size_t hit_limit = 24;
constexpr std::size_t least_per_thread = 128;  // faces worth a thread
constexpr double thinnest_shape = 1e-4;

template <class Pairs>
void sort_unique(Pairs& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

template <class Pairs, class Pair>
bool contains(const Pairs& sorted, const Pair& pair) {
  return std::binary_search(sorted.begin(), sorted.end(), pair);
}

double largest_coordinate(const ContactSolver::Positions& positions) {
  double largest = 0;
  for (const Point& p : positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

Point at(const Corners& c, const std::array<double, 3>& w) { return w[0] * c[0] + w[1] * c[1] + w[2] * c[2]; }

/// The closest points of two faces that share vertices, apart from these: of the edge or corner of one that is not
/// shared and the other face.
ClosestPair closest_beside(const std::array<std::int32_t, 3>& index_s, const Corners& s,
                           const std::array<std::int32_t, 3>& index_t, const Corners& t) {
  const auto own = [](const auto& mine, const auto& theirs, const Corners& c, std::array<int, 3>& from) {
    int count = 0;
    for (int i = 0; i < 3; ++i) {
      if (std::find(theirs.begin(), theirs.end(), mine[i]) == theirs.end()) from[count++] = i;
    }
    for (int i = count; i < 3; ++i) from[i] = from[0];
    return Corners{c[from[0]], c[from[1]], c[from[2]]};
  };
  const auto back = [](const std::array<double, 3>& weight, const std::array<int, 3>& from) {
    std::array<double, 3> result{};
    for (int k = 0; k < 3; ++k) result[from[k]] += weight[k];
    return result;
  };
  std::array<int, 3> from_s{};
  std::array<int, 3> from_t{};
  const Corners own_s = own(index_s, index_t, s, from_s);
  const Corners own_t = own(index_t, index_s, t, from_t);
  ClosestPair a = closest_points(own_s, t);
  ClosestPair b = closest_points(s, own_t);
  a.weight_s = back(a.weight_s, from_s);
  b.weight_t = back(b.weight_t, from_t);
  return a.distance2 <= b.distance2 ? a : b;
}

}  // namespace

ContactSolver::ContactSolver(const TriangleMesh& cage, ContactSolverOptions options) : options_(std::move(options)) {
  for (std::int64_t v = 0; v < cage.vertices.rows(); ++v) {
    position_.push_back(cage.vertex(static_cast<std::int32_t>(v)));
  }
  incident_.resize(position_.size());
  for (std::int64_t t = 0; t < cage.triangles.rows(); ++t) {
    face_.push_back({cage.triangles(t, 0), cage.triangles(t, 1), cage.triangles(t, 2)});
    for (const std::int32_t v : face_.back()) incident_[v].push_back(static_cast<std::int32_t>(t));
  }
  box_.resize(face_.size());
  for (std::size_t f = 0; f < face_.size(); ++f) fit_box(position_, static_cast<std::int32_t>(f));
  tree_.build(box_);
  tested_ = position_;
  dirty_.assign(face_.size(), false);
}

TriangleMesh ContactSolver::mesh() const {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::int64_t>(position_.size()), 3);
  for (std::size_t v = 0; v < position_.size(); ++v) {
    mesh.vertices.row(static_cast<std::int64_t>(v)) = position_[v].transpose();
  }
  mesh.triangles.resize(static_cast<std::int64_t>(face_.size()), 3);
  for (std::size_t f = 0; f < face_.size(); ++f) {
    for (int k = 0; k < 3; ++k) mesh.triangles(static_cast<std::int64_t>(f), k) = face_[f][k];
  }
  return mesh;
}

ContactSolver::Positions ContactSolver::approach(const Obstacle& obstacle, const Positions& wanted,
                                                 const std::vector<double>& weights) {
  mobility_.assign(position_.size(), 1);
  for (std::size_t v = 0; v < weights.size(); ++v) mobility_[v] = 1 / weights[v];
  const Step step{obstacle, obstacle, false, 0};
  Positions y;
  resolve(step, wanted, y);
  retreat(step, y);
  return y;
}

std::optional<ContactSolver::Positions> ContactSolver::follow(const Obstacle& before, const Obstacle& after,
                                                              const Positions& wanted, double reach) {
  const Step step{before, after, true, reach};
  mobility_.assign(position_.size(), 1);
  Positions y;
  jammed_.clear();
  if (resolve(step, wanted, y)) return y;
  for (const Pair& pair : hits_) {
    jammed_.push_back(pair.face);
    if (pair.other < 0) jammed_.push_back(-1 - pair.other);
  }
  sort_unique(jammed_);
  return std::nullopt;
}

/// The QP with contacts made as they are met: true if nothing touches in the end.
bool ContactSolver::resolve(const Step& step, const Positions& wanted, Positions& y) {
  begin(step);
  for (int round = 0; round < most_rounds; ++round) {
    options_.check();
    project(wanted, step.reach > 0 ? slow_sweeps : most_sweeps, y);
    for (Point& p : y) p = round_to_float(p);
    retest(step, y);
    if (hits_.empty()) return true;
    bool added = false;
    for (const Pair& pair : hits_) {
      if (contains(strict_, pair)) continue;
      add_contact(step, pair, contains(known_, pair));
      added = true;
    }
    known_.insert(known_.end(), hits_.begin(), hits_.end());
    sort_unique(known_);
    sort_unique(strict_);
    if (!added) break;
  }
  return false;
}

void ContactSolver::fit_box(const Positions& y, std::int32_t f) {
  box_[f].setEmpty();
  for (const std::int32_t v : face_[f]) box_[f].extend(y[v]);
}

void ContactSolver::begin(const Step& step) {
  // Contacts that pushed last time will push again.
  known_.clear();
  strict_.clear();
  for (const Contact& c : contacts_) {
    if (c.multiplier > 0) known_.push_back(c.pair);
  }
  sort_unique(known_);
  contacts_.clear();
  magnitude_ = largest_coordinate(position_);
  // What was tested last need not have been taken.
  if (tested_ != position_) {
    for (std::size_t f = 0; f < face_.size(); ++f) fit_box(position_, static_cast<std::int32_t>(f));
    tree_.refit(box_);
    tested_ = position_;
  }
  if (step.reach > 0) {
    add_all_near(step);
  } else {
    for (const Pair& pair : known_) add_contact(step, pair, false);
  }
  hits_.clear();
  test_all_ = step.moves;
}

/// Linearises a pair at the present valid state. `strict`: all corners of the face stay beyond the plane between the
/// closest points, and the obstacle's triangle below it: two convex sets separated for sure.
void ContactSolver::add_contact(const Step& step, const Pair& pair, bool strict) {
  if (pair.other >= 0) {
    add_obstacle_contact(step, pair, strict);
  } else if (pair.other != -1 - pair.face) {
    if (strict) strict_.push_back(pair);
    add_self_contact(pair, strict);
  }
}

void ContactSolver::add_obstacle_contact(const Step& step, const Pair& pair, bool strict) {
  const Corners mine = corners(position_, pair.face);
  const Corners& theirs = step.before.corners(pair.other);
  const ClosestPair closest = closest_points(mine, theirs);
  const Point across = at(mine, closest.weight_s) - at(theirs, closest.weight_t);
  const double distance = across.norm();
  if (!(distance > 0)) return;
  const Point normal = across / distance;
  const Corners& target = step.after.corners(pair.other);
  // Never ask for more than there is: at rest, the present state must remain feasible.
  const double gap = std::min(lift_clearances * options_.clearance, distance);
  if (strict) {
    strict_.push_back(pair);
    const double highest = std::max({normal.dot(target[0]), normal.dot(target[1]), normal.dot(target[2])});
    for (int k = 0; k < 3; ++k) {
      Contact c{pair, normal, {}, {}, 1, highest + gap};
      c.vertex[0] = face_[pair.face][k];
      c.weight[0] = 1;
      add(c);
    }
    return;
  }
  Contact c{pair, normal, {}, {}, 3, normal.dot(at(target, closest.weight_t)) + gap};
  for (int k = 0; k < 3; ++k) {
    c.vertex[k] = face_[pair.face][k];
    c.weight[k] = closest.weight_s[k];
  }
  add(c);
}

void ContactSolver::add(Contact& c) {
  double move2 = 0;
  for (int k = 0; k < c.count; ++k) {
    const double move = c.weight[k] * mobility_[c.vertex[k]];
    c.response += c.weight[k] * move;
    move2 += move * move;
  }
  c.move = std::sqrt(move2);
  contacts_.push_back(c);
}

void ContactSolver::add_self_contact(const Pair& pair, bool strict) {
  const Index3& index_s = face_[pair.face];
  const Index3& index_t = face_[-1 - pair.other];
  const Corners s = corners(position_, pair.face);
  const Corners t = corners(position_, -1 - pair.other);
  const bool neighbours = std::any_of(index_s.begin(), index_s.end(), [&](std::int32_t v) {
    return std::find(index_t.begin(), index_t.end(), v) != index_t.end();
  });
  const ClosestPair closest = neighbours ? closest_beside(index_s, s, index_t, t) : closest_points(s, t);
  const Point across = at(s, closest.weight_s) - at(t, closest.weight_t);
  const double distance = across.norm();
  if (!(distance > 0)) return;
  const double gap = std::min(lift_clearances * options_.self_clearance, neighbours ? distance / 2 : distance);
  if (strict && !neighbours) {
    for (const std::int32_t a : index_s) {
      for (const std::int32_t b : index_t) add_pair(pair, across / distance, a, b, gap);
    }
    return;
  }
  Contact c{pair, across / distance, {}, {}, 6, gap};
  for (int k = 0; k < 3; ++k) {
    c.vertex[k] = index_s[k];
    c.weight[k] = closest.weight_s[k];
    c.vertex[3 + k] = index_t[k];
    c.weight[3 + k] = -closest.weight_t[k];
  }
  add(c);
}

/// Vertex a stays above vertex b.
void ContactSolver::add_pair(const Pair& pair, const Point& normal, std::int32_t a, std::int32_t b, double gap) {
  Contact c{pair, normal, {}, {}, 2, gap};
  c.vertex[0] = a;
  c.weight[0] = 1;
  c.vertex[1] = b;
  c.weight[1] = -1;
  add(c);
}

void ContactSolver::add_all_near(const Step& step) {
  constexpr std::size_t most = 256;  // a face; others are found as they touch
  known_.clear();
  std::vector<std::int32_t> near;
  for (std::size_t i = 0; i < face_.size(); ++i) {
    const auto f = static_cast<std::int32_t>(i);
    const Corners mine = corners(position_, f);
    const Prism prism(mine);
    near.clear();
    step.before.highest_hits(prism, step.reach, most, near);
    for (const std::int32_t t : near) known_.push_back({f, t});
    tree_.traverse(step.before.near(prism, step.reach, magnitude_), [&](std::int32_t other) {
      if (other <= f) return;
      if (!separated(face_[f], mine, face_[other], corners(position_, other), step.reach)) {
        known_.push_back({f, -1 - other});
      }
    });
  }
  work_ += static_cast<std::int64_t>(face_.size());
  sort_unique(known_);
  for (const Pair& pair : known_) add_contact(step, pair, true);
  sort_unique(strict_);
}

/// min |Y - wanted|^2 under the contacts, by projected Gauss-Seidel on the multipliers. Contacts none of whose vertices
/// moved since they were looked at are passed over.
void ContactSolver::project(const Positions& wanted, int sweeps, Positions& y) {
  y = wanted;
  for (const Contact& c : contacts_) {
    if (c.multiplier == 0) continue;
    for (int k = 0; k < c.count; ++k) {
      y[c.vertex[k]] += c.multiplier * c.weight[k] * mobility_[c.vertex[k]] * c.normal;
    }
  }
  const double tolerance = 0.15 * options_.clearance;
  const double least = 0.1 * tolerance;  // changes below it are not worth their consequences
  moved_at_.assign(y.size(), 1);
  seen_at_.assign(contacts_.size(), 0);
  std::int64_t now = 1;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double worst = 0;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      Contact& c = contacts_[i];
      bool stale = false;
      for (int k = 0; k < c.count; ++k) stale = stale || moved_at_[c.vertex[k]] > seen_at_[i];
      if (!stale) continue;
      seen_at_[i] = now;
      double value = 0;
      for (int k = 0; k < c.count; ++k) value += c.weight[k] * c.normal.dot(y[c.vertex[k]]);
      const double change = std::max((c.offset - value) / c.response, -c.multiplier);
      const double length = std::abs(change) * c.move;
      if (length <= least) continue;
      worst = std::max(worst, length);
      ++now;
      c.multiplier += change;
      for (int k = 0; k < c.count; ++k) {
        y[c.vertex[k]] += change * c.weight[k] * mobility_[c.vertex[k]] * c.normal;
        moved_at_[c.vertex[k]] = now;
      }
      seen_at_[i] = now;
    }
    if (worst < tolerance) break;
  }
}

/// Finds what touches at y. Only faces that moved since the last test are tested again, shared out among the threads;
/// the result is the same.
void ContactSolver::retest(const Step& step, const Positions& y) {
  std::vector<std::int32_t> faces;
  for (std::size_t f = 0; f < face_.size(); ++f) {
    const auto face = static_cast<std::int32_t>(f);
    dirty_[f] = corners(y, face) != corners(tested_, face);
    if (dirty_[f]) fit_box(y, face);
    if (dirty_[f] || test_all_) faces.push_back(face);
  }
  tree_.refit(box_);
  magnitude_ = largest_coordinate(y);
  work_ += static_cast<std::int64_t>(faces.size());
  std::erase_if(hits_,
                [&](const Pair& pair) { return dirty_[pair.face] || (pair.other < 0 && dirty_[-1 - pair.other]); });
  // The caller is charged for the work of all threads: its budget must not depend on which of them did it.
  const std::uint64_t work_before = Obstacle::work();
  std::uint64_t work_here = 0;
  std::mutex mutex;
  for_ranges(options_.threads, faces.size(), least_per_thread, [&](std::size_t first, std::size_t last) {
    const std::uint64_t before = Obstacle::work();
    std::vector<Pair> found;
    std::vector<std::int32_t> scratch;
    for (std::size_t i = first; i < last; ++i) test_face(step, y, faces[i], found, scratch);
    const std::lock_guard lock(mutex);
    work_here += Obstacle::work() - before;
    hits_.insert(hits_.end(), found.begin(), found.end());
  });
  Obstacle::work() = work_before + work_here;
  std::sort(hits_.begin(), hits_.end());
  tested_ = y;
  test_all_ = false;
}

void ContactSolver::test_face(const Step& step, const Positions& y, std::int32_t f, std::vector<Pair>& found,
                              std::vector<std::int32_t>& scratch) const {
  const Corners mine = corners(y, f);
  const Prism prism(mine);
  const bool moved = mine != corners(position_, f);
  if (moved) {
    double longest2 = 0;
    for (int k = 0; k < 3; ++k) longest2 = std::max(longest2, (mine[(k + 1) % 3] - mine[k]).squaredNorm());
    const double doubled = (mine[1] - mine[0]).cross(mine[2] - mine[0]).norm();
    if (!(prism.valid && doubled > thinnest_shape * longest2)) {
      found.push_back({f, -1 - f});
      return;
    }
  }
  if (moved || step.moves) {
    scratch.clear();
    step.after.highest_hits(prism, options_.clearance, hit_limit, scratch);
    for (const std::int32_t t : scratch) found.push_back({f, t});
  }
  if (!dirty_[f]) return;
  tree_.traverse(step.after.near(prism, options_.self_clearance, magnitude_), [&](std::int32_t other) {
    if (other == f || (other < f && dirty_[other])) return;
    const Corners theirs = corners(y, other);
    if (!moved && theirs == corners(position_, other)) return;
    if (separated(face_[f], mine, face_[other], theirs, options_.self_clearance)) return;
    found.push_back({std::min(f, other), -1 - std::max(f, other)});
  });
}

/// What still touches goes back to where it was; its neighbours may then touch in turn.
void ContactSolver::retreat(const Step& step, Positions& y) {
  if (hits_.empty()) add_lost_cones(y);
  while (!hits_.empty()) {
    for (const Pair& pair : hits_) {
      for (const std::int32_t v : face_[pair.face]) y[v] = position_[v];
      if (pair.other >= 0) continue;
      for (const std::int32_t v : face_[-1 - pair.other]) y[v] = position_[v];
    }
    // Faces that are back where they were touch nothing that is too.
    hits_.clear();
    retest(step, y);
    if (hits_.empty()) add_lost_cones(y);
  }
}

/// The faces around every vertex that would lose its cone of outward directions: the next coarser level could not start
/// there.
void ContactSolver::add_lost_cones(const Positions& y) {
  std::vector<Point> normals;
  const auto has_cone = [&](const Positions& positions, std::size_t v) {
    normals.clear();
    for (const std::int32_t f : incident_[v]) normals.push_back(Prism(corners(positions, f)).normal);
    return common_direction(normals);
  };
  for (std::size_t v = 0; v < incident_.size(); ++v) {
    bool changed = false;
    for (const std::int32_t f : incident_[v]) changed = changed || corners(y, f) != corners(position_, f);
    if (!changed || has_cone(y, v) || !has_cone(position_, v)) continue;
    for (const std::int32_t f : incident_[v]) hits_.push_back({f, -1 - f});
  }
}

bool ContactSolver::encloses_all(const Obstacle& obstacle, const Positions& y) {
  std::vector<Point> passed;
  for (std::size_t f = 0; f < face_.size(); ++f) {
    const auto face = static_cast<std::int32_t>(f);
    const Corners mine = corners(y, face);
    const Corners old = corners(position_, face);
    if (mine == old) continue;
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) box.extend(mine[k]).extend(old[k]);
    obstacle.representatives(box, passed);
  }
  const auto before = [](const Point& a, const Point& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(passed.begin(), passed.end(), before);
  passed.erase(std::unique(passed.begin(), passed.end()), passed.end());
  work_ += static_cast<std::int64_t>(face_.size() * passed.size() / 50);
  return std::all_of(passed.begin(), passed.end(), [&](const Point& x) { return encloses(y, x); });
}

bool ContactSolver::encloses(const Positions& y, const Point& x) const {
  double angle = 0;
  for (std::size_t f = 0; f < face_.size(); ++f) angle += solid_angle(x, corners(y, static_cast<std::int32_t>(f)));
  // 4 pi; 0 outside, 8 pi where a component of the cage has passed another one.
  return angle > 6 && angle < 19;
}

}  // namespace encage::makers
