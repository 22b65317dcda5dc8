// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/turned_box.h"
#include "broadphase/world/chunks.h"
#include "broadphase/world/room.h"
#include "broadphase/world/state.h"
#include "src/limits.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <string>

namespace encage {
namespace {

bool same(const PairOptions& a, const PairOptions& b) {
  return a.margin == b.margin && a.cages == b.cages && a.finest_cage == b.finest_cage &&
         a.coarsest_cage == b.coarsest_cage && a.fine == b.fine && a.most_steps == b.most_steps;
}

void check_threads(const char* what, const Executor& executor) {
  if (executor.threads >= 1) return;
  throw Error(std::string(what) + ": the number of threads " + std::to_string(executor.threads) + " is not positive");
}

/// Unlocks a world at the end of a scope.
struct Unlock {
  bool& locked;
  ~Unlock() { locked = false; }
};

/// Exceeds the rounding of a sum of all margins of a pair, and of this product.
constexpr double rounded_up = 1 + 8 * eps;

}  // namespace

// ---- One pair ------------------------------------------------------------

double World::State::margin_of(std::uint64_t key, double margin) const noexcept {
  const double sum = margin + bounds_[first_of(key)].margin;
  return rounded_up * (has_half_space(key) ? sum : sum + bounds_[second_of(key)].margin);
}

bool World::State::is_current(const Pair& pair) const noexcept { return pair.tested_at > options_changed_at_; }

bool World::State::boxes_are_apart(std::uint64_t key, double margin) const noexcept {
  const Eigen::AlignedBox3d& a = bounds_[first_of(key)].box;
  if (has_half_space(key)) return box_beyond(a, planes_[half_space_of(key)].half_space, margin);
  const Eigen::AlignedBox3d& b = bounds_[second_of(key)].box;
  return !a.intersects(b) && boxes_apart(a, b, margin);
}

CandidatePair World::State::candidate(const Pair& pair) const noexcept {
  CandidatePair result;
  result.a = body_ids_.at(first_of(pair.key));
  if (has_half_space(pair.key)) {
    result.half_space = plane_ids_.at(half_space_of(pair.key));
  } else {
    result.b = body_ids_.at(second_of(pair.key));
  }
  result.event = pair.candidate ? PairEvent::persist : PairEvent::begin;
  return result;
}

Verdict World::State::ask(const Pair& pair, PairOptions options) const noexcept {
  // There is nothing to test, so the data of the bodies need not be fetched.
  if (!has_half_space(pair.key) && !options.fine && options.cages == CageUse::never &&
      ((traits_[first_of(pair.key)] | traits_[second_of(pair.key)]) & is_compound) == 0) {
    return {};
  }
  const Body& a = bodies_[first_of(pair.key)];
  const Shape& shape_a = *shape_of(a);
  options.margin = margin_of(pair.key, options.margin);
  options.boxes = false;  // boxes_are_apart() has tested them
  if (has_half_space(pair.key)) {
    return separated(shape_a, a.motion, planes_[half_space_of(pair.key)].half_space, options.margin);
  }
  const Body& b = bodies_[second_of(pair.key)];
  return separated(shape_a, a.motion, *shape_of(b), b.motion, options);
}

template <class Visit>
void World::State::for_each_triangle_pair(const Pair& pair, double margin, Visit&& visit) const {
  if (has_half_space(pair.key)) return;
  const Body& a = bodies_[first_of(pair.key)];
  const Body& b = bodies_[second_of(pair.key)];
  encage::for_each_triangle_pair(*shape_of(a), a.motion, *shape_of(b), b.motion, margin_of(pair.key, margin), visit);
}

// ---- Search --------------------------------------------------------------

/// One search; the world is locked meanwhile. Tasks of the executor, if there is one, process the pairs and store their
/// findings with them. The calling thread then goes through the pairs in order as if it were alone, and finds most of
/// its work done.
class World::State::Search {
 public:
  Search(State& state, const CandidateOptions& options)
      : state_(state),
        options_(options),
        margin_(options.pair.margin),
        now_(++state.clock_),
        tested_(state.complete_at_ == now_ - 1),
        shared_(options.executor.run && options.executor.threads > 1 && state.pairs_.size() > 1 &&
                (!tested_ || options.triangles)) {}

  CandidateStatistics run(void (*visit)(void*, const CandidatePair&), void* context) {
    if (options_.accept) call_accept();
    for (std::size_t next = 0; next < state_.pairs_.size();) next = deliver(next, prepare(next), visit, context);
    visit_ended(~std::uint64_t{0});
    finish();
    return counts_;
  }

 private:
  void test_boxes(Pair& pair) noexcept {
    if (state_.is_current(pair)) return;
    pair.apart = state_.boxes_are_apart(pair.key, state_.margin_of(pair.key, margin_));
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

  /// Lets tasks process pairs from `first` on. Returns the end of the processed range, or of all pairs if there are no
  /// tasks.
  std::size_t prepare(std::size_t first) {
    std::vector<Pair>& pairs = state_.pairs_;
    if (!shared_) return pairs.size();
    if (options_.triangles) {
      state_.scratch_.lists.clear();
      make_room(state_.scratch_.list, pairs.size());
      state_.scratch_.list.resize(pairs.size());
    }
    const std::size_t last = for_each_in_chunks(options_.executor, first, pairs.size(), [&](std::size_t i) {
      test_boxes(pairs[i]);
      if (is_open(pairs[i])) ask(pairs[i]);
      return !options_.triangles || list_triangles(i);
    });
    // The executor may have run no task.
    shared_ = last > first;
    return shared_ ? last : pairs.size();
  }

  /// Returns false if there was no room.
  bool list_triangles(std::size_t i) noexcept {
    const Pair& pair = state_.pairs_[i];
    TriangleLists::Writer writer(state_.scratch_.lists);
    if (is_open(pair) && !pair.verdict.separated) {
      try {
        state_.for_each_triangle_pair(pair, margin_, [&](TrianglePair found) { return writer.push(found); });
      } catch (const std::exception&) {
        // A mesh on demand cannot be read: the calling thread, which may throw, tries again.
        state_.scratch_.list[i] = {.first_block = -1, .size = -1};
        return false;
      }
    }
    state_.scratch_.list[i] = writer.list();
    return writer.list().complete();
  }

  std::span<const TrianglePair> triangles(std::size_t i) {
    if (shared_ && state_.scratch_.list[i].complete())
      return state_.scratch_.lists.read(state_.scratch_.list[i], state_.scratch_.triangles);
    state_.scratch_.triangles.clear();
    state_.for_each_triangle_pair(state_.pairs_[i], margin_, [&](TrianglePair found) {
      state_.scratch_.triangles.push_back(found);
      return true;
    });
    return state_.scratch_.triangles;
  }

  /// True if the pair is a candidate; updates the counts.
  bool judge(Pair& pair, bool accepting, CandidateStatistics& counts) noexcept {
    if (pair.apart) return false;
    ++counts.overlapping;
    if (accepting && pair.refused) {
      ++counts.refused;
      return false;
    }
    ask(pair);
    if (!pair.counted) {
      pair.counted = true;
      ++counts.asked;
    }
    if (pair.verdict.separated) {
      ++counts.separated[static_cast<std::size_t>(pair.verdict.stage)];
      return false;
    }
    ++counts.candidates;
    return true;
  }

  /// Visits the candidates of [first, last), and pairs that have ended. Stops at a pair, other than the first one,
  /// whose list of triangles is incomplete. Returns the end of the range that it delivered.
  std::size_t deliver(std::size_t first, std::size_t last, void (*visit)(void*, const CandidatePair&), void* context) {
    const bool listed = shared_ && options_.triangles, accepting = static_cast<bool>(options_.accept);
    const bool tested = tested_ || shared_;
    const std::span<Pair> pairs = state_.pairs_;
    CandidateStatistics counts = counts_;
    for (std::size_t i = first; i < last; ++i) {
      Pair& pair = pairs[i];
      if (listed && i > first && !state_.scratch_.list[i].complete()) {
        last = i;
        break;
      }
      visit_ended(pair.key);
      if (!tested) test_boxes(pair);
      if (!judge(pair, accepting, counts)) {
        if (pair.candidate) end(pair);
        continue;
      }
      CandidatePair result = state_.candidate(pair);
      pair.candidate = true;
      result.verdict = pair.verdict;
      if (options_.triangles) result.triangles = triangles(i);
      visit(context, result);
    }
    counts.listed += static_cast<std::int64_t>(last - first);
    counts_ = counts;
    return last;
  }

  /// Ends a pair that was a candidate and no longer is.
  void end(Pair& pair) {
    pair.candidate = false;
    if (!options_.ended) return;
    CandidatePair result = state_.candidate(pair);
    result.event = PairEvent::end;
    if (pair.apart) {
      result.verdict = {true, Stage::box, -1};
    } else if (pair.asked) {
      result.verdict = pair.verdict;
    }
    options_.ended(result);
  }

  /// Visits the ended pairs that are no longer kept and come no later than `key`.
  void visit_ended(std::uint64_t key) {
    const std::vector<Ended>& ended = state_.ended_;
    while (state_.ended_visited_ < ended.size() && ended[state_.ended_visited_].key <= key) {
      const Ended& pair = ended[state_.ended_visited_++];
      if (options_.ended) {
        options_.ended({.a = pair.a,
                        .b = pair.b,
                        .half_space = pair.half_space,
                        .event = PairEvent::end,
                        .verdict = {pair.apart, Stage::box, -1}});
      }
    }
  }

  void finish() noexcept {
    if (!options_.accept) state_.complete_at_ = now_;
    state_.searched_at_ = now_;
    state_.left_out_margin_ = std::min(state_.left_out_margin_, margin_);
    state_.has_stale_pairs_ = state_.has_stirred_;
    state_.has_stirred_ = false;
  }

  State& state_;
  const CandidateOptions& options_;
  double margin_;
  std::uint64_t now_;
  bool tested_;  // of the boxes of all pairs
  bool shared_;  // with tasks
  CandidateStatistics counts_;
};

void World::State::update_boxes(const Executor& executor) {
  check_unlocked();
  check_threads("update of boxes", executor);
  scratch_.searching = true;
  const Unlock unlock{scratch_.searching};
  find_boxes(executor);
}

CandidateStatistics World::State::search(const CandidateOptions& options, void (*visit)(void*, const CandidatePair&),
                                         void* context) {
  check_unlocked();
  if (const double margin = options.pair.margin; !(margin >= 0 && margin <= largest_length)) {
    throw Error("candidate options: " + length_defect("margin", margin));
  }
  check_threads("candidate options", options.executor);
  if (options.pair.margin > left_out_margin_) stir_sleepers();
  scratch_.searching = true;
  const Unlock unlock{scratch_.searching};
  collect(options.pair.margin, options.executor);
  if (!same(options.pair, last_options_)) {
    last_options_ = options.pair;
    options_changed_at_ = ++clock_;
  }
  return Search(*this, options).run(visit, context);
}

}  // namespace encage
