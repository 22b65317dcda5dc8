// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "cagegen/flow/parallel.h"
#include "cagegen/flow/pull.h"
#include "cagegen/geometry/obstacle.h"
#include "cagegen/geometry/rounding.h"

namespace encage::makers {

namespace {

// Depth first asked for, in gaps: what conservative tests and rounding take from it.
constexpr double kFirstDepth = 1.25;
// Growth of the depth asked for, a step, at the corners of a triangle for which it was not enough; and its limit,
// in diagonals.
constexpr double kGrowth = 1.5;
constexpr double kGreatestDepth = 0.1;
// Longest move, in diagonals.
constexpr double kLongestMove = 0.03;
// Times that a move is halved before the vertex stays where it is.
constexpr int kHalvings = 4;
// Steps without fewer triangles touching before the stuck patch is smoothed, and passes of a smoothing.
constexpr int kPatience = 10;
constexpr int kPasses = 3;
// Items between two calls of the request's check.
constexpr std::size_t kBlock = 32768;

/// Collects indices, each once.
class IndexSet {
 public:
  void reset(std::size_t count) { has_.assign(count, 0); }
  void add(std::int32_t i) {
    if (has_[i]) return;
    has_[i] = 1;
    members_.push_back(i);
  }
  /// Empties the set. The result ascends.
  std::vector<std::int32_t> take() {
    for (const std::int32_t i : members_) has_[i] = 0;
    std::sort(members_.begin(), members_.end());
    return std::exchange(members_, {});
  }

 private:
  std::vector<char> has_;
  std::vector<std::int32_t> members_;
};

class Flow {
 public:
  explicit Flow(const FlowRequest& request);
  FlowResult run();

 private:
  struct Move {
    Point place = Point::Zero();
    Nearest nearest;
    bool made = false;
  };

  Corners corners(std::int32_t t) const {
    return {place_[triangles_(t, 0)], place_[triangles_(t, 1)], place_[triangles_(t, 2)]};
  }
  std::span<const std::int32_t> triangles_at(std::int32_t v) const {
    return {around_.data() + first_[v], around_.data() + first_[v + 1]};
  }
  std::vector<std::int32_t> dirty_vertices();

  /// Calls work(from, to) for blocks of [0, count) on all threads, and the request's check between them.
  template <class Work>
  void for_blocks(std::size_t count, const Work& work) const;
  template <class Work>
  void for_each(std::size_t count, const Work& work) const;

  void find_neighbours();
  bool is_dirty(std::int32_t t) const;
  void find_dirty(const std::vector<std::int32_t>& candidates);
  void step();
  Point jump(std::int32_t v, const std::vector<Pull>& pulls) const;
  Move move(std::int32_t v, Point jump) const;
  void apply(const std::vector<std::int32_t>& vertices, const std::vector<Move>& moves);
  void ask_for_more();
  void smooth();
  Point average_of_neighbours(std::int32_t v) const;

  const FlowRequest& request_;
  const Triangles& triangles_;
  SignedDistance surface_;
  Obstacle obstacle_;
  std::vector<std::int32_t> first_;  ///< the triangles at vertex v are around_[first_[v]] to around_[first_[v + 1]]
  std::vector<std::int32_t> around_;
  std::vector<Point> place_;
  std::vector<Nearest> nearest_;
  std::vector<double> depth_;        ///< asked for, of each vertex
  std::vector<std::int32_t> dirty_;  ///< triangles not proven inside, ascending
  std::vector<std::int32_t> slot_;   ///< of each triangle in dirty_, or -1
  IndexSet vertex_set_;
  IndexSet triangle_set_;
  FlowResult result_;
};

Flow::Flow(const FlowRequest& request)
    : request_(request),
      triangles_(request.fine->triangles),
      surface_(*request.coarse),
      obstacle_(*request.coarse),
      result_{false, {}, FlowHistory(request.fine->vertices), 0, {}} {
  find_neighbours();
  const auto vertices = static_cast<std::size_t>(request.fine->vertices.rows());
  place_.resize(vertices);
  nearest_.resize(vertices);
  depth_.assign(vertices, kFirstDepth * request.gap);
  for (std::size_t v = 0; v < vertices; ++v) place_[v] = request.fine->vertex(static_cast<std::int32_t>(v));
  vertex_set_.reset(vertices);
  triangle_set_.reset(static_cast<std::size_t>(triangles_.rows()));
  slot_.assign(static_cast<std::size_t>(triangles_.rows()), -1);
  // Vertices with near numbers lie near each other in most files: a good start.
  for_blocks(vertices, [&](std::size_t from, std::size_t to) {
    std::int32_t start = 0;
    for (std::size_t v = from; v < to; ++v) {
      if (first_[v] == first_[v + 1]) continue;
      nearest_[v] = surface_.nearest(place_[v], start);
      start = nearest_[v].triangle;
    }
  });
  std::vector<std::int32_t> all(slot_.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<std::int32_t>(t);
  find_dirty(all);
}

template <class Work>
void Flow::for_blocks(std::size_t count, const Work& work) const {
  for (std::size_t first = 0; first < count; first += kBlock) {
    if (request_.check) request_.check();
    for_ranges(request_.threads, std::min(kBlock, count - first),
               [&](std::size_t from, std::size_t to) { work(first + from, first + to); });
  }
}

template <class Work>
void Flow::for_each(std::size_t count, const Work& work) const {
  for_blocks(count, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) work(i);
  });
}

void Flow::find_neighbours() {
  const auto count = static_cast<std::int32_t>(triangles_.rows());
  first_.assign(static_cast<std::size_t>(request_.fine->vertices.rows()) + 1, 0);
  for (std::int32_t t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) ++first_[triangles_(t, k) + 1];
  }
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  around_.resize(3 * static_cast<std::size_t>(count));
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (std::int32_t t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) around_[next[triangles_(t, k)]++] = t;
  }
}

/// False only if the triangle lies inside and keeps the gap.
bool Flow::is_dirty(std::int32_t t) const {
  const Corners c = corners(t);
  bool clear = false;
  for (int k = 0; k < 3; ++k) {
    const double distance = nearest_[triangles_(t, k)].distance;
    if (distance > -request_.gap) return true;
    // The ball around a corner without surface in it may hold the whole triangle.
    const double reach2 = std::max((c[(k + 1) % 3] - c[k]).squaredNorm(), (c[(k + 2) % 3] - c[k]).squaredNorm());
    clear = clear || -distance - request_.gap > std::sqrt(reach2);
  }
  if (clear) return false;
  Prism prism(c);
  prism.valid = !is_thin(c);  // the planes of thin ones have no use
  return obstacle_.hit(prism, request_.gap);
}

/// `candidates` hold all triangles that were dirty or have moved, ascending.
void Flow::find_dirty(const std::vector<std::int32_t>& candidates) {
  std::vector<char> found(candidates.size());
  for_each(candidates.size(), [&](std::size_t i) { found[i] = is_dirty(candidates[i]); });
  for (const std::int32_t t : dirty_) slot_[t] = -1;
  dirty_.clear();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!found[i]) continue;
    slot_[candidates[i]] = static_cast<std::int32_t>(dirty_.size());
    dirty_.push_back(candidates[i]);
  }
}

std::vector<std::int32_t> Flow::dirty_vertices() {
  for (const std::int32_t t : dirty_) {
    for (int k = 0; k < 3; ++k) vertex_set_.add(triangles_(t, k));
  }
  return vertex_set_.take();
}

void Flow::step() {
  std::vector<Pull> pulls(dirty_.size());
  for_each(dirty_.size(), [&](std::size_t i) {
    std::array<double, 3> depth;
    std::array<std::int32_t, 3> start;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = triangles_(dirty_[i], k);
      depth[k] = depth_[v];
      start[k] = nearest_[v].triangle;
    }
    pulls[i] = pull(surface_, corners(dirty_[i]), depth, start);
  });
  const std::vector<std::int32_t> vertices = dirty_vertices();
  std::vector<Move> moves(vertices.size());
  for_each(vertices.size(), [&](std::size_t i) { moves[i] = move(vertices[i], jump(vertices[i], pulls)); });
  apply(vertices, moves);
  ask_for_more();
}

/// Average of the Newton jumps of the vertex and of the quadrature points around it, where the depth is missed.
/// Every dirty triangle counts the same, and the vertex as much as all of them: degenerate triangles must move too.
Point Flow::jump(std::int32_t v, const std::vector<Pull>& pulls) const {
  Point sum = Point::Zero();
  double weight = 0;
  double own_weight = 0;
  for (const std::int32_t t : triangles_at(v)) {
    if (slot_[t] < 0) continue;
    const Pull& pull = pulls[slot_[t]];
    for (int k = 0; k < 3; ++k) {
      if (triangles_(t, k) != v) continue;
      sum -= pull.jump[k];
      weight += pull.weight[k];
      own_weight += 1.0 / 3;
    }
  }
  const double missing = nearest_[v].distance + depth_[v];
  if (missing > 0) {
    sum -= own_weight * missing * nearest_[v].direction;
    weight += own_weight;
  }
  return weight > 0 ? Point(sum / weight) : Point(Point::Zero());
}

Flow::Move Flow::move(std::int32_t v, Point jump) const {
  const double length = jump.norm();
  const double longest = kLongestMove * request_.diagonal;
  if (length > longest) jump *= longest / length;
  Move result;
  for (int i = 0; i <= kHalvings && !result.made; ++i, jump /= 2) {
    result.place = round_to_float(place_[v] + jump);
    if (result.place == place_[v]) break;
    result.nearest = surface_.nearest(result.place, nearest_[v].triangle);
    result.made = may_go(surface_, place_[v], nearest_[v], result.place, result.nearest);
  }
  return result;
}

void Flow::apply(const std::vector<std::int32_t>& vertices, const std::vector<Move>& moves) {
  std::vector<std::int32_t> moved;
  std::vector<Eigen::Vector3f> places;
  for (const std::int32_t t : dirty_) triangle_set_.add(t);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!moves[i].made) continue;
    const std::int32_t v = vertices[i];
    place_[v] = moves[i].place;
    nearest_[v] = moves[i].nearest;
    moved.push_back(v);
    places.push_back(moves[i].place.cast<float>());
    for (const std::int32_t t : triangles_at(v)) triangle_set_.add(t);
  }
  moved.shrink_to_fit();
  places.shrink_to_fit();
  result_.history.push(std::move(moved), std::move(places));
  find_dirty(triangle_set_.take());
}

void Flow::ask_for_more() {
  for (const std::int32_t v : dirty_vertices()) {
    depth_[v] = std::min(kGrowth * depth_[v], kGreatestDepth * request_.diagonal);
  }
}

Point Flow::average_of_neighbours(std::int32_t v) const {
  Point sum = Point::Zero();
  int count = 0;
  for (const std::int32_t t : triangles_at(v)) {
    for (int k = 0; k < 3; ++k) {
      if (triangles_(t, k) == v) continue;
      sum += place_[triangles_(t, k)];
      ++count;
    }
  }
  return count > 0 ? Point(sum / count) : place_[v];
}

/// Uniform Laplacian steps of the stuck vertices and their neighbours, which may lead through C^.
void Flow::smooth() {
  for (const std::int32_t v : dirty_vertices()) {
    for (const std::int32_t t : triangles_at(v)) {
      for (int k = 0; k < 3; ++k) vertex_set_.add(triangles_(t, k));
    }
  }
  const std::vector<std::int32_t> patch = vertex_set_.take();
  std::vector<Move> moves(patch.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = 0; i < patch.size(); ++i) moves[i].place = round_to_float(average_of_neighbours(patch[i]));
    for (std::size_t i = 0; i < patch.size(); ++i) place_[patch[i]] = moves[i].place;
  }
  for_each(patch.size(), [&](std::size_t i) {
    moves[i].nearest = surface_.nearest(moves[i].place, nearest_[patch[i]].triangle);
    moves[i].made = true;
  });
  for (const std::int32_t v : patch) depth_[v] = kFirstDepth * request_.gap;
  apply(patch, moves);
  ++result_.smoothing_steps;
}

FlowResult Flow::run() {
  std::size_t fewest = dirty_.size() + 1;
  int waited = 0;
  while (!dirty_.empty() && result_.history.steps() < request_.most_steps) {
    if (dirty_.size() < fewest) {
      fewest = dirty_.size();
      waited = 0;
    } else if (++waited > kPatience) {
      if (result_.smoothing_steps >= request_.most_smoothings) break;
      smooth();
      fewest = dirty_.size() + 1;
      waited = 0;
      continue;
    }
    step();
  }
  result_.inside = dirty_.empty();
  result_.stuck = dirty_;
  result_.positions.resize(request_.fine->vertices.rows(), 3);
  for (std::size_t v = 0; v < place_.size(); ++v) {
    result_.positions.row(static_cast<Eigen::Index>(v)) = place_[v].transpose();
  }
  return std::move(result_);
}

}  // namespace

FlowResult flow(const FlowRequest& request) {
  assert(request.fine != nullptr && request.coarse != nullptr && request.diagonal > 0 && request.gap > 0);
  return Flow(request).run();
}

}  // namespace encage::makers
