// SPDX-License-Identifier: Apache-2.0
#include "broadphase/body_box.h"
#include "broadphase/chunks.h"
#include "broadphase/frame.h"
#include "broadphase/world_state.h"

#include <algorithm>
#include <atomic>

namespace encage {
namespace {

bool same(const PairOptions& a, const PairOptions& b) {
  return a.margin == b.margin && a.cages == b.cages && a.finest_cage == b.finest_cage &&
         a.coarsest_cage == b.coarsest_cage && a.fine == b.fine;
}

bool masks_allow(const Filter& a, const Filter& b) { return (a.category & b.mask) != 0 && (b.category & a.mask) != 0; }

Eigen::AlignedBox3d in_double(const FloatBox& box) {
  return {Eigen::Map<const Eigen::Vector3f>(box.lower.data()).cast<double>(),
          Eigen::Map<const Eigen::Vector3f>(box.upper.data()).cast<double>()};
}

/// By half as much again as before: few steps grow, then none.
template <class T>
void make_room(std::vector<T>& v, std::size_t size) {
  if (v.capacity() < size) v.reserve(std::max(size, v.capacity() + v.capacity() / 2));
}

}  // namespace

// ---- Pairs whose tree boxes overlap --------------------------------------

bool World::State::allowed(const Body& a, const Body& b) const noexcept {
  if (a.options.is_static && b.options.is_static) return false;
  if (a.options.group != 0 && a.options.group == b.options.group) return a.options.group > 0;
  return masks_allow(a.options.filter, b.options.filter);
}

void World::State::find_fresh_half_spaces(std::uint32_t n, std::size_t first_plane, double margin) {
  const Body& body = bodies_[n];
  if (body.options.is_static) return;
  const Eigen::AlignedBox3d box = in_double(tree_.box(body.leaf));
  for (std::size_t p = first_plane; p < planes_.size(); ++p) {
    // The box holds the body's margin already; twice is safe.
    if (masks_allow(body.options.filter, planes_[p].filter) &&
        !box_beyond(box, planes_[p].half_space, margin + body.options.margin)) {
      fresh_.push_back(key(n, half_space_bit | static_cast<std::uint32_t>(p)));
    }
  }
}

void World::State::find_fresh_pairs(double margin) {
  fresh_.clear();
  tree_.query_moved_pairs(margin * (1 + 1e-12), [&](std::uint32_t a, std::uint32_t b) {
    if (allowed(bodies_[a], bodies_[b])) fresh_.push_back(key(std::min(a, b), std::max(a, b)));
  });
  for (const BoxTree::Leaf leaf : tree_.moved()) find_fresh_half_spaces(tree_.item(leaf), 0, margin);
  if (collected_planes_ < planes_.size()) {
    for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
      if (outdated_[n] == 0) find_fresh_half_spaces(n, collected_planes_, margin);
    }
  }
  std::sort(fresh_.begin(), fresh_.end());
}

void World::State::merge_fresh_pairs() {
  merged_.clear();
  make_room(merged_, pairs_.size() + fresh_.size());
  auto fresh = fresh_.cbegin();
  for (const Pair& pair : pairs_) {
    if (outdated_[first(pair)] != 0 || (!has_half_space(pair) && outdated_[second(pair)] != 0)) continue;
    for (; fresh != fresh_.cend() && *fresh < pair.key; ++fresh) merged_.push_back({.key = *fresh});
    merged_.push_back(pair);
  }
  for (; fresh != fresh_.cend(); ++fresh) merged_.push_back({.key = *fresh});
  pairs_.swap(merged_);
  ++clock_;
}

void World::State::collect(double margin) {
  if (margin > collected_margin_) {
    for (std::size_t n = 0; n < bodies_.size(); ++n) {
      if (bodies_[n].leaf >= 0) tree_.touch(bodies_[n].leaf);
      outdated_[n] = 1;
    }
    collected_margin_ = margin;
  }
  if (tree_.moved().empty() && !has_stale_pairs_ && collected_planes_ == planes_.size()) return;
  // Nothing of the following is lost if memory runs out.
  find_fresh_pairs(collected_margin_);
  merge_fresh_pairs();
  for (const BoxTree::Leaf leaf : tree_.moved()) outdated_[tree_.item(leaf)] = 0;
  tree_.clear_moved();
  has_stale_pairs_ = false;
  collected_planes_ = planes_.size();
}

// ---- One pair ------------------------------------------------------------

double World::State::margin_of(const Pair& pair, double margin) const noexcept {
  const double sum = margin + bounds_[first(pair)].margin;
  return has_half_space(pair) ? sum : sum + bounds_[second(pair)].margin;
}

bool World::State::is_current(const Pair& pair) const noexcept {
  std::uint64_t changed_at = std::max(options_changed_at_, bounds_[first(pair)].changed_at);
  if (!has_half_space(pair)) changed_at = std::max(changed_at, bounds_[second(pair)].changed_at);
  return pair.tested_at > changed_at;
}

Eigen::AlignedBox3d World::State::tight_box(std::uint32_t n) noexcept {
  constexpr std::uint64_t nobody = ~std::uint64_t{0};
  Body& body = bodies_[n];
  const std::atomic_ref<std::uint64_t> box_of(body.box_of);
  const std::uint64_t wanted = bounds_[n].changed_at;
  std::uint64_t known = box_of.load(std::memory_order_acquire);
  if (known == wanted) return body.box;
  const Eigen::AlignedBox3d box = world_box(*shapes_[static_cast<std::uint32_t>(body.shape)].shape, body.motion);
  // Several threads may find the same box; one keeps it, none waits.
  if (known != nobody && box_of.compare_exchange_strong(known, nobody, std::memory_order_relaxed)) {
    body.box = box;
    box_of.store(wanted, std::memory_order_release);
  }
  return box;
}

bool World::State::boxes_are_apart(const Pair& pair, double margin) noexcept {
  const std::uint32_t a = first(pair), b = second(pair);
  if (has_half_space(pair)) {
    const HalfSpace& plane = planes_[b & ~half_space_bit].half_space;
    return box_beyond(bounds_[a].loose, plane, margin) || box_beyond(tight_box(a), plane, margin);
  }
  return boxes_apart(bounds_[a].loose, bounds_[b].loose, margin) || boxes_apart(tight_box(a), tight_box(b), margin);
}

CandidatePair World::State::candidate(const Pair& pair) const noexcept {
  CandidatePair result;
  result.a = static_cast<BodyId>(first(pair));
  if (has_half_space(pair)) {
    result.half_space = static_cast<HalfSpaceId>(second(pair) & ~half_space_bit);
  } else {
    result.b = static_cast<BodyId>(second(pair));
  }
  return result;
}

Verdict World::State::ask(const Pair& pair, PairOptions options) const noexcept {
  const Body& a = bodies_[first(pair)];
  const Shape& shape_a = *shapes_[static_cast<std::uint32_t>(a.shape)].shape;
  options.margin = margin_of(pair, options.margin);
  options.boxes = false;  // boxes_are_apart() has
  if (has_half_space(pair)) {
    return separated(shape_a, a.motion, planes_[second(pair) & ~half_space_bit].half_space, options.margin);
  }
  const Body& b = bodies_[second(pair)];
  return separated(shape_a, a.motion, *shapes_[static_cast<std::uint32_t>(b.shape)].shape, b.motion, options);
}

template <class Visit>
void World::State::for_each_triangle_pair(const Pair& pair, double margin, Visit&& visit) const {
  if (has_half_space(pair)) return;
  const Body& a = bodies_[first(pair)];
  const Body& b = bodies_[second(pair)];
  for_each_candidate(*shapes_[static_cast<std::uint32_t>(a.shape)].shape, a.motion,
                     *shapes_[static_cast<std::uint32_t>(b.shape)].shape, b.motion, margin_of(pair, margin), visit);
}

// ---- Search --------------------------------------------------------------

/// One search; the world is locked meanwhile. Tasks of the executor, if there is one, go through the pairs and leave
/// what they find there; then the calling thread goes through them in order as if it were
/// alone, and finds most of its work done.
class World::State::Search {
 public:
  Search(State& state, const CandidateOptions& options)
      : state_(state),
        options_(options),
        margin_(options.pair.margin),
        now_(++state.clock_),
        tested_(state.complete_at_ == now_ - 1),
        shared_(options.executor.run && options.executor.threads > 1 && state.pairs_.size() > 1 &&
                (!tested_ || options.triangles)) {
    state_.searching_ = true;
  }
  ~Search() { state_.searching_ = false; }
  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  CandidateStatistics run(void (*visit)(void*, const CandidatePair&), void* context) {
    if (options_.accept) call_accept();
    for (std::size_t next = 0; next < state_.pairs_.size();) next = deliver(next, prepare(next), visit, context);
    if (!options_.accept) state_.complete_at_ = now_;
    return counts_;
  }

 private:
  void test_boxes(Pair& pair) noexcept {
    if (state_.is_current(pair)) return;
    pair.apart = state_.boxes_are_apart(pair, state_.margin_of(pair, margin_));
    pair.asked = false;
    pair.tested_at = now_;
  }

  void ask(Pair& pair) noexcept {
    if (pair.asked) return;
    pair.verdict = state_.ask(pair, options_.pair);
    pair.asked = true;
    pair.counted = false;
  }

  void call_accept() {
    std::vector<Pair>& pairs = state_.pairs_;
    if (shared_) {
      for_each_in_chunks(options_.executor, 0, pairs.size(), [&](std::size_t i) {
        test_boxes(pairs[i]);
        return true;
      });
    }
    for (Pair& pair : pairs) {
      test_boxes(pair);
      if (!pair.apart) pair.refused = !options_.accept(state_.candidate(pair));
    }
    tested_ = true;
  }

  bool is_open(const Pair& pair) const noexcept { return !pair.apart && !(options_.accept && pair.refused); }

  /// Lets tasks find out about pairs from `first` on. Returns the end of those they went through; of all, if there are
  /// no tasks.
  std::size_t prepare(std::size_t first) {
    std::vector<Pair>& pairs = state_.pairs_;
    if (!shared_) return pairs.size();
    if (options_.triangles) {
      state_.lists_.clear();
      make_room(state_.list_, pairs.size());
      state_.list_.resize(pairs.size());
    }
    const std::size_t last = for_each_in_chunks(options_.executor, first, pairs.size(), [&](std::size_t i) {
      test_boxes(pairs[i]);
      if (is_open(pairs[i])) ask(pairs[i]);
      return !options_.triangles || list_triangles(i);
    });
    // An executor may have run nothing.
    shared_ = last > first;
    return shared_ ? last : pairs.size();
  }

  /// False if there was no room.
  bool list_triangles(std::size_t i) noexcept {
    const Pair& pair = state_.pairs_[i];
    TriangleLists::Writer writer(state_.lists_);
    if (is_open(pair) && !pair.verdict.separated) {
      state_.for_each_triangle_pair(pair, margin_, [&](TrianglePair found) { return writer.push(found); });
    }
    state_.list_[i] = writer.list();
    return writer.list().complete();
  }

  std::span<const TrianglePair> triangles(std::size_t i) {
    if (shared_ && state_.list_[i].complete()) return state_.lists_.read(state_.list_[i], state_.triangles_);
    state_.triangles_.clear();
    state_.for_each_triangle_pair(state_.pairs_[i], margin_, [&](TrianglePair found) {
      state_.triangles_.push_back(found);
      return true;
    });
    return state_.triangles_;
  }

  /// Visits the candidates of [first, last). Returns the end of those it went through: at least one pair, and those
  /// whose triangles are listed.
  std::size_t deliver(std::size_t first, std::size_t last, void (*visit)(void*, const CandidatePair&), void* context) {
    const bool listed = shared_ && options_.triangles, accepting = static_cast<bool>(options_.accept);
    const bool tested = tested_ || shared_;
    const std::span<Pair> pairs = state_.pairs_;
    CandidateStatistics counts = counts_;
    for (std::size_t i = first; i < last; ++i) {
      Pair& pair = pairs[i];
      if (listed && i > first && !state_.list_[i].complete()) {
        last = i;
        break;
      }
      if (!tested) test_boxes(pair);
      if (pair.apart) continue;
      ++counts.overlapping;
      if (accepting && pair.refused) {
        ++counts.refused;
        continue;
      }
      ask(pair);
      if (!pair.counted) {
        pair.counted = true;
        ++counts.asked;
      }
      if (pair.verdict.separated) {
        ++counts.separated[static_cast<std::size_t>(pair.verdict.stage)];
        continue;
      }
      ++counts.candidates;
      CandidatePair result = state_.candidate(pair);
      result.verdict = pair.verdict;
      if (options_.triangles) result.triangles = triangles(i);
      visit(context, result);
    }
    counts_ = counts;
    return last;
  }

  State& state_;
  const CandidateOptions& options_;
  double margin_;
  std::uint64_t now_;
  bool tested_;  // the boxes of all pairs
  bool shared_;  // among tasks
  CandidateStatistics counts_;
};

CandidateStatistics World::State::search(const CandidateOptions& options, void (*visit)(void*, const CandidatePair&),
                                         void* context) {
  check_unlocked();
  if (!(options.pair.margin >= 0 && options.pair.margin <= 1e150)) {
    throw Error("candidate options: the margin is negative or not finite");
  }
  if (options.executor.threads < 1) throw Error("candidate options: the number of threads is not positive");
  collect(options.pair.margin);
  if (!same(options.pair, last_options_)) {
    last_options_ = options.pair;
    options_changed_at_ = ++clock_;
  }
  return Search(*this, options).run(visit, context);
}

}  // namespace encage
