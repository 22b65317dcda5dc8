// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/collapse.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <vector>

namespace encage::makers {

namespace {

struct EdgeCandidate {
  double cost;
  std::int32_t u;
  std::int32_t v;
  std::uint32_t version;  ///< of u and v together, when the cost was found
  std::int32_t id;        ///< index into Queue::waiting_

  bool operator>(const EdgeCandidate& other) const {
    return std::tie(cost, u, v) > std::tie(other.cost, other.u, other.v);
  }
};

/// Edges by cost. Costs may be stale: they are the keys of a lazy queue.
class Queue {
 public:
  explicit Queue(CageEditor& cage)
      : cage_(cage), version_(static_cast<std::size_t>(cage.vertex_capacity()), 0), failed_(version_.size()) {}

  void fill() {
    heap_ = {};
    waiting_.clear();
    for (auto& list : failed_) list.clear();
    for (std::int32_t u = 0; u < cage_.vertex_capacity(); ++u) {
      if (!cage_.alive(u)) continue;
      cage_.neighbours(u, neighbours_);
      for (const std::int32_t v : neighbours_) {
        if (u < v) push(u, v, cage_.estimate_collapse(u, v));
      }
    }
  }

  void push(std::int32_t u, std::int32_t v, double cost) {
    if (!std::isfinite(cost)) return;
    heap_.push({cost, u, v, version_[u] + version_[v], static_cast<std::int32_t>(waiting_.size())});
    waiting_.push_back(false);
  }

  /// After a merge into u: its edges are new, and what failed next to it deserves another try.
  void refresh(std::int32_t u) {
    ++version_[u];
    cage_.neighbours(u, neighbours_);
    for (const std::int32_t v : neighbours_) {
      push(std::min(u, v), std::max(u, v), cage_.estimate_collapse(u, v));
      for (const EdgeCandidate& c : failed_[v]) {
        if (!waiting_[c.id]) continue;
        waiting_[c.id] = false;
        heap_.push(c);
      }
      failed_[v].clear();
    }
  }

  /// Sets a candidate aside until something changes next to it.
  void postpone(const EdgeCandidate& c) {
    waiting_[c.id] = true;
    failed_[c.u].push_back(c);
    failed_[c.v].push_back(c);
  }

  bool pop(EdgeCandidate& c) {
    while (!heap_.empty()) {
      c = heap_.top();
      heap_.pop();
      if (cage_.alive(c.u) && cage_.alive(c.v) && c.version == version_[c.u] + version_[c.v]) return true;
    }
    return false;
  }

  double next_cost() const { return heap_.empty() ? std::numeric_limits<double>::infinity() : heap_.top().cost; }

 private:
  CageEditor& cage_;
  std::vector<std::uint32_t> version_;
  std::vector<std::vector<EdgeCandidate>> failed_;  ///< per end: a candidate stands in two lists
  std::vector<bool> waiting_;                       ///< set aside and not back in the heap
  std::vector<std::int32_t> neighbours_;
  std::priority_queue<EdgeCandidate, std::vector<EdgeCandidate>, std::greater<>> heap_;
};

}  // namespace

bool collapse_edges(CageEditor& cage, const CollapseLimits& limits) {
  const std::int64_t first_count = cage.face_count();
  const std::uint64_t first_work = Obstacle::work();
  double added = 0;
  std::uint64_t plans = 0;
  Queue queue(cage);
  for (;;) {
    queue.fill();
    bool any = false;
    EdgeCandidate c;
    while (cage.face_count() > limits.faces && queue.pop(c)) {
      if (limits.work > 0 && Obstacle::work() - first_work > limits.work) return false;
      if (limits.progress && ++plans % 64 == 0) {
        limits.progress(static_cast<double>(first_count - cage.face_count()) /
                        static_cast<double>(std::max<std::int64_t>(1, first_count - limits.faces)));
      }
      const auto plan = cage.plan_collapse(c.u, c.v);
      if (!plan) {
        queue.postpone(c);
        continue;
      }
      // Costs in the queue may be stale or free of contacts: wait if the next one may be cheaper.
      if (plan->cost > c.cost && plan->cost > queue.next_cost()) {
        queue.push(c.u, c.v, plan->cost);
        continue;
      }
      cage.apply_collapse(c.u, c.v, plan->position);
      any = true;
      added += plan->cost;
      if (limits.added_volume > 0 && added > limits.added_volume) return false;
      queue.refresh(c.u);
    }
    if (cage.face_count() <= limits.faces) return true;
    if (!any) return false;
  }
}

double tighten(CageEditor& cage) {
  double gained = 0;
  std::vector<std::int32_t> neighbours;
  for (std::int32_t v = 0; v < cage.vertex_capacity(); ++v) {
    if (!cage.alive(v)) continue;
    cage.neighbours(v, neighbours);
    double length = 0;
    for (const std::int32_t w : neighbours) length += (cage.position(w) - cage.position(v)).norm();
    const auto plan = cage.plan_tightening(v, 0.3 * length / static_cast<double>(neighbours.size()));
    if (!plan) continue;
    cage.apply_move(v, plan->position);
    gained -= plan->cost;
  }
  return gained;
}

}  // namespace encage::makers
