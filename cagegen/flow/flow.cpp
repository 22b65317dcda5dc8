// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow.h"

#include "cagegen/flow/neighbours.h"
#include "cagegen/flow/pull.h"
#include "cagegen/geometry/obstacle.h"
#include "cagegen/threads/parallel.h"
#include "src/mesh/rounding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

// Depth first asked for, in gaps: what conservative tests and rounding take from it.
constexpr double first_depth = 1.25;
// Growth of the depth asked for, a step, at the corners of a triangle for which it was not enough; and its limit, in
// diagonals.
constexpr double depth_growth = 1.5;
constexpr double greatest_depth = 0.1;
// Longest move, in diagonals.
constexpr double longest_move = 0.03;
// Times that a move is halved before the vertex stays where it is.
constexpr int most_halvings = 4;
// Steps without fewer triangles touching before the stuck patch is smoothed, and passes of a smoothing.
constexpr int patience_steps = 8;
constexpr int smoothing_passes = 3;
// Steps without fewer triangles touching before stretched triangles climb; the move they ask for, in roots of their
// doubled area; sums of cosines without meaning, and triangles of C^ looked at for the direction.
constexpr int climb_after = 2;
constexpr double climb_move = 0.5;
constexpr double balanced_sum = 0.01;
constexpr std::size_t most_hits = 64;
// Items between two calls of the request's check.
constexpr std::size_t block_size = 32768;
// Items worth a thread.
constexpr std::size_t least_per_thread = 512;

class Flow {
 public:
  explicit Flow(const FlowRequest& request);
  FlowResult run();

 private:
  /// What a dirty triangle asks of its corners.
  struct Wish {
    Pull pull;
    bool climbs = false;
  };
  struct Move {
    Point position = Point::Zero();
    Nearest nearest;
    bool made = false;
  };

  Corners corners(std::int32_t t) const {
    return {position_[triangles_(t, 0)], position_[triangles_(t, 1)], position_[triangles_(t, 2)]};
  }
  std::vector<std::int32_t> dirty_vertices();

  /// Calls work(from, to) for blocks of [0, count) on all threads, and the request's check between them.
  template <class Work>
  void for_blocks(std::size_t count, const Work& work) const;
  template <class Work>
  void for_each(std::size_t count, const Work& work) const;

  bool is_dirty(std::int32_t t) const;
  void find_dirty(const std::vector<std::int32_t>& candidates);
  void step();
  bool is_stretched(std::int32_t t) const;
  Pull climb(std::int32_t t) const;
  Point jump(std::int32_t v, const std::vector<Wish>& wishes) const;
  Move move(std::int32_t v, Point jump) const;
  void apply(const std::vector<std::int32_t>& vertices, const std::vector<Move>& moves);
  void ask_for_more();
  void smooth();
  Point average_of_neighbours(std::int32_t v) const;

  const FlowRequest& request_;
  const Triangles& triangles_;
  SignedDistance surface_;
  Obstacle obstacle_;
  Neighbours neighbours_;
  std::vector<Point> position_;
  std::vector<Nearest> nearest_;
  std::vector<double> depth_;        ///< asked for, of each vertex
  std::vector<std::int32_t> dirty_;  ///< triangles not proven inside, ascending
  std::vector<std::int32_t> slot_;   ///< of each triangle in dirty_, or -1
  int waited_ = 0;                   ///< steps since fewer triangles touched than ever
  IndexSet vertex_set_;
  IndexSet triangle_set_;
  FlowResult result_;
};

Flow::Flow(const FlowRequest& request)
    : request_(request),
      triangles_(request.fine->triangles),
      surface_(*request.coarse),
      obstacle_(*request.coarse),
      neighbours_(*request.fine),
      vertex_set_(static_cast<std::size_t>(request.fine->vertices.rows())),
      triangle_set_(static_cast<std::size_t>(request.fine->triangles.rows())),
      result_{false, {}, FlowHistory(request.fine->vertices), 0, {}} {
  const auto vertices = static_cast<std::size_t>(request.fine->vertices.rows());
  position_.resize(vertices);
  nearest_.resize(vertices);
  depth_.assign(vertices, first_depth * request.gap);
  for (std::size_t v = 0; v < vertices; ++v) position_[v] = request.fine->vertex(static_cast<std::int32_t>(v));
  slot_.assign(static_cast<std::size_t>(triangles_.rows()), -1);
  // Vertices with near numbers lie near each other in most files: a good start.
  for_blocks(vertices, [&](std::size_t from, std::size_t to) {
    std::int32_t start = 0;
    for (std::size_t v = from; v < to; ++v) {
      if (neighbours_(static_cast<std::int32_t>(v)).empty()) continue;
      nearest_[v] = surface_.nearest(position_[v], start);
      start = nearest_[v].triangle;
    }
  });
  std::vector<std::int32_t> all(slot_.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<std::int32_t>(t);
  find_dirty(all);
}

template <class Work>
void Flow::for_blocks(std::size_t count, const Work& work) const {
  for (std::size_t first = 0; first < count; first += block_size) {
    if (request_.check) request_.check();
    for_ranges(request_.threads, std::min(block_size, count - first), least_per_thread,
               [&](std::size_t from, std::size_t to) { work(first + from, first + to); });
  }
}

template <class Work>
void Flow::for_each(std::size_t count, const Work& work) const {
  for_blocks(count, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) work(i);
  });
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
  const bool may_climb = waited_ >= climb_after;
  std::vector<Wish> wishes(dirty_.size());
  for_each(dirty_.size(), [&](std::size_t i) {
    if (may_climb && is_stretched(dirty_[i])) {
      wishes[i] = {climb(dirty_[i]), true};
      return;
    }
    std::array<double, 3> depth;
    std::array<std::int32_t, 3> start;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = triangles_(dirty_[i], k);
      depth[k] = depth_[v];
      start[k] = nearest_[v].triangle;
    }
    wishes[i].pull = pull(surface_, corners(dirty_[i]), depth, start);
  });
  const std::vector<std::int32_t> vertices = dirty_vertices();
  std::vector<Move> moves(vertices.size());
  for_each(vertices.size(), [&](std::size_t i) {
    const std::int32_t v = vertices[i];
    moves[i] = move(v, jump(v, wishes));
    // What the triangles ask for may lead nowhere; its own way in is free.
    const double missing = nearest_[v].distance + first_depth * request_.gap;
    if (!moves[i].made && missing > 0) moves[i] = move(v, -missing * nearest_[v].direction);
  });
  apply(vertices, moves);
  ask_for_more();
}

/// Stuck across a gap of C^: its corners are inside, to the left and to the right.
bool Flow::is_stretched(std::int32_t t) const {
  for (int k = 0; k < 3; ++k) {
    if (nearest_[triangles_(t, k)].distance > -request_.gap) return false;
  }
  return !is_thin(corners(t));
}

/// Along the triangle's normal, to the end of the gap, where C^ closes: against the normals of what it hits. The walls,
/// nearly at right angles to the triangle, count little, and where all is in balance it goes inward. Distances would
/// draw it to either wall. (Intersection contours shrink on the same way: Volino and Magnenat-Thalmann 2006.)
Pull Flow::climb(std::int32_t t) const {
  const Corners c = corners(t);
  const Prism prism(c);
  std::vector<std::int32_t> hits;
  obstacle_.hits(prism, request_.gap, most_hits, hits);
  double facing = 0;
  for (const std::int32_t hit : hits) {
    const Prism wall(obstacle_.corners(hit));
    if (wall.valid) facing += wall.normal.dot(prism.normal);
  }
  const double length = climb_move * std::sqrt((c[1] - c[0]).cross(c[2] - c[0]).norm());
  Pull result;
  result.jump.fill((facing < -balanced_sum ? -length : length) * prism.normal);
  result.weight.fill(1);
  return result;
}

/// Average of the Newton jumps of the vertex and of the quadrature points around it, where the depth is missed. Every
/// dirty triangle counts the same, and the vertex as much as all of them: degenerate triangles must move too.
Point Flow::jump(std::int32_t v, const std::vector<Wish>& wishes) const {
  Point sum = Point::Zero();
  double weight = 0;
  double own_weight = 0;
  bool climbing = false;
  for (const std::int32_t t : neighbours_(v)) {
    if (slot_[t] < 0) continue;
    const auto& [pull, climbs] = wishes[slot_[t]];
    climbing = climbing || climbs;
    for (int k = 0; k < 3; ++k) {
      if (triangles_(t, k) != v) continue;
      sum -= pull.jump[k];
      weight += pull.weight[k];
      own_weight += 1.0 / 3;
    }
  }
  const double missing = nearest_[v].distance + (climbing ? first_depth * request_.gap : depth_[v]);
  if (missing > 0) {
    sum -= own_weight * missing * nearest_[v].direction;
    weight += own_weight;
  }
  return weight > 0 ? Point(sum / weight) : Point(Point::Zero());
}

Flow::Move Flow::move(std::int32_t v, Point jump) const {
  const double length = jump.norm();
  const double longest = longest_move * request_.diagonal;
  if (length > longest) jump *= longest / length;
  Move result;
  for (int i = 0; i <= most_halvings && !result.made; ++i, jump /= 2) {
    result.position = round_to_float(position_[v] + jump);
    if (result.position == position_[v]) break;
    result.nearest = surface_.nearest(result.position, nearest_[v].triangle);
    result.made = may_go(surface_, position_[v], nearest_[v], result.position, result.nearest);
  }
  return result;
}

void Flow::apply(const std::vector<std::int32_t>& vertices, const std::vector<Move>& moves) {
  std::vector<std::int32_t> moved;
  std::vector<Eigen::Vector3f> positions;
  for (const std::int32_t t : dirty_) triangle_set_.add(t);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!moves[i].made) continue;
    const std::int32_t v = vertices[i];
    position_[v] = moves[i].position;
    nearest_[v] = moves[i].nearest;
    moved.push_back(v);
    positions.push_back(moves[i].position.cast<float>());
    for (const std::int32_t t : neighbours_(v)) triangle_set_.add(t);
  }
  moved.shrink_to_fit();
  positions.shrink_to_fit();
  result_.history.push(std::move(moved), std::move(positions));
  find_dirty(triangle_set_.take());
}

void Flow::ask_for_more() {
  for (const std::int32_t v : dirty_vertices()) {
    depth_[v] = std::min(depth_growth * depth_[v], greatest_depth * request_.diagonal);
  }
}

Point Flow::average_of_neighbours(std::int32_t v) const {
  Point sum = Point::Zero();
  int count = 0;
  for (const std::int32_t t : neighbours_(v)) {
    for (int k = 0; k < 3; ++k) {
      if (triangles_(t, k) == v) continue;
      sum += position_[triangles_(t, k)];
      ++count;
    }
  }
  return count > 0 ? Point(sum / count) : position_[v];
}

/// Uniform Laplacian steps of the stuck vertices and their neighbours, which may lead through C^.
void Flow::smooth() {
  for (const std::int32_t v : dirty_vertices()) {
    for (const std::int32_t t : neighbours_(v)) {
      for (int k = 0; k < 3; ++k) vertex_set_.add(triangles_(t, k));
    }
  }
  const std::vector<std::int32_t> patch = vertex_set_.take();
  std::vector<Move> moves(patch.size());
  for (int pass = 0; pass < smoothing_passes; ++pass) {
    for (std::size_t i = 0; i < patch.size(); ++i) moves[i].position = round_to_float(average_of_neighbours(patch[i]));
    for (std::size_t i = 0; i < patch.size(); ++i) position_[patch[i]] = moves[i].position;
  }
  for_each(patch.size(), [&](std::size_t i) {
    moves[i].nearest = surface_.nearest(moves[i].position, nearest_[patch[i]].triangle);
    moves[i].made = true;
  });
  for (const std::int32_t v : patch) depth_[v] = first_depth * request_.gap;
  apply(patch, moves);
  ++result_.smoothing_steps;
}

FlowResult Flow::run() {
  std::size_t fewest = dirty_.size() + 1;
  while (!dirty_.empty() && result_.history.steps() < request_.most_steps) {
    if (dirty_.size() < fewest) {
      fewest = dirty_.size();
      waited_ = 0;
    } else if (++waited_ > patience_steps) {
      if (result_.smoothing_steps >= request_.most_smoothings) break;
      smooth();
      fewest = dirty_.size() + 1;
      waited_ = 0;
      continue;
    }
    step();
  }
  result_.inside = dirty_.empty();
  result_.stuck = dirty_;
  result_.positions.resize(request_.fine->vertices.rows(), 3);
  for (std::size_t v = 0; v < position_.size(); ++v) {
    result_.positions.row(static_cast<Eigen::Index>(v)) = position_[v].transpose();
  }
  return std::move(result_);
}

}  // namespace

FlowResult flow(const FlowRequest& request) {
  assert(request.fine != nullptr && request.coarse != nullptr && request.diagonal > 0 && request.gap > 0);
  return Flow(request).run();
}

}  // namespace encage::makers
