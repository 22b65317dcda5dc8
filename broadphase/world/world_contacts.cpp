// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/shape.h"
#include "broadphase/world/chunks.h"

#include <encage/world_contacts.h>

#include <algorithm>
#include <exception>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace encage {
namespace {

constexpr double largest_margin = 1e150;
constexpr int most_points_of_pair = 1024;

void check(const WorldContactOptions& options) {
  const auto check_margin = [](const char* name, double margin) {
    if (margin >= 0 && margin <= largest_margin) return;
    throw Error("contact options: " + std::string(name) + " " + std::to_string(margin) + " is not in [0, 1e150]");
  };
  check_margin("margin", options.margin);
  check_margin("first_margin", options.first_margin);
  if (options.most_points < 1 || options.most_points > most_points_of_pair) {
    throw Error("contact options: most_points " + std::to_string(options.most_points) + " is not in [1, 1024]");
  }
  if (options.most_per_patch < 1) {
    throw Error("contact options: most_per_patch " + std::to_string(options.most_per_patch) + " is not positive");
  }
}

bool has_fine_mesh(const Shape& shape) {
  return shape.is_compound() ? shape.compound().has_fine : shape.simple().has_fine();
}

}  // namespace

class WorldContacts::State {
 public:
  struct PairIds {
    BodyId a = BodyId::none, b = BodyId::none;
    HalfSpaceId half_space = HalfSpaceId::none;

    bool with_half_space() const { return b == BodyId::none; }
    /// In the order of World::find_candidates(); ids of different generations are different pairs, the older one first.
    auto key() const {
      return std::tuple(index(a), with_half_space(), with_half_space() ? index(half_space) : index(b), generation(a),
                        with_half_space() ? generation(half_space) : generation(b));
    }
  };

  struct Pair {
    PairIds ids;
    ManifoldCache cache;
    std::optional<Contact> first;
    int count = 0;          ///< of points
    bool touching = false;  ///< as the caller knows
  };

  WorldContactStatistics find(World& world, const WorldContactOptions& options,
                              void (*visit)(void*, const ContactPair&), void* context) {
    check(options);
    WorldContactStatistics statistics;
    statistics.search = search(world, options);
    join();
    compute(world, options);
    deliver(options, visit, context, statistics);
    return statistics;
  }

  void clear() noexcept {
    pairs_.clear();
    ended_.clear();
    ended_delivered_ = 0;
  }

 private:
  CandidateStatistics search(World& world, const WorldContactOptions& options) {
    found_.clear();
    CandidateOptions search;
    // Contacts need a traversal of their own, which costs no more than one that proves the meshes separated.
    search.pair.fine = false;
    search.pair.margin = std::max(options.margin, options.first_contacts ? options.first_margin : 0);
    search.accept = options.accept;
    search.executor = options.executor;
    return world.find_candidates(search, [&](const CandidatePair& pair) {
      found_.push_back({pair.a, pair.b, pair.half_space});
    });
  }

  /// Makes pairs of what was found, with the memories of those that were there before.
  void join() {
    ended_.erase(ended_.begin(), ended_.begin() + static_cast<std::ptrdiff_t>(ended_delivered_));
    ended_delivered_ = 0;
    // All that may throw comes first.
    joined_.clear();
    joined_.reserve(found_.size());
    ended_.reserve(ended_.size() + pairs_.size());
    spare_.reserve(found_.size() + pairs_.size());
    while (spare_.size() < found_.size()) spare_.emplace_back();
    auto before = pairs_.begin();
    const auto leave = [&] {
      if (before->touching) ended_.push_back(before->ids);
      before->cache.clear();
      spare_.push_back(std::move(before->cache));
      ++before;
    };
    for (const PairIds& ids : found_) {
      while (before != pairs_.end() && before->ids.key() < ids.key()) leave();
      if (before != pairs_.end() && before->ids.key() == ids.key()) {
        joined_.push_back(std::move(*before++));
      } else {
        joined_.push_back({.ids = ids, .cache = std::move(spare_.back()), .first = {}});
        spare_.pop_back();
      }
    }
    while (before != pairs_.end()) leave();
    pairs_.swap(joined_);
    joined_.clear();
    std::sort(ended_.begin(), ended_.end(), [](const PairIds& x, const PairIds& y) { return x.key() < y.key(); });
  }

  void compute(const World& world, const WorldContactOptions& options) {
    most_points_ = static_cast<std::size_t>(options.most_points);
    if (options.manifolds) points_.resize(std::max(points_.size(), pairs_.size() * most_points_));
    for (const Pair& pair : pairs_) {
      check_has_fine(world, pair.ids.a);
      if (!pair.ids.with_half_space()) check_has_fine(world, pair.ids.b);
    }
    std::size_t done = 0;
    if (options.executor.run && options.executor.threads > 1) {
      failed_.assign(pairs_.size(), 0);
      for_each_in_chunks(options.executor, 0, pairs_.size(), [&](std::size_t i) {
        try {
          compute(world, options, i);
        } catch (const std::exception&) {
          failed_[i] = 1;  // the calling thread, which may throw, tries again
        }
        return true;
      });
      for (; done < pairs_.size(); ++done) {
        if (failed_[done] != 0) compute(world, options, done);
      }
    }
    for (; done < pairs_.size(); ++done) compute(world, options, done);
  }

  static void check_has_fine(const World& world, BodyId body) {
    if (has_fine_mesh(*world.shape(body))) return;
    throw Error("body " + std::to_string(index(body)) +
                ": its shape has no fine mesh, which contacts need; bake it with the mesh in the asset");
  }

  static double margin_of(const World& world, BodyId body) {
    const BodyOptions& options = world.options(body);
    return options.margin + world.margin(world.shape_id(body)) + world.deformation(body) +
           correction_margin(*world.shape(body), world.pose_deviation(body), options.scale);
  }
  static double arc_of(const World& world, BodyId body) {
    if (!world.options().arcs) return 0;
    return arc_margin(*world.shape(body), world.motion(body), world.options(body).pivot);
  }

  void compute(const World& world, const WorldContactOptions& options, std::size_t i) {
    Pair& pair = pairs_[i];
    pair.count = 0;
    pair.first.reset();
    const PairIds& ids = pair.ids;
    double own = margin_of(world, ids.a), arc = arc_of(world, ids.a);
    if (!ids.with_half_space()) {
      own += margin_of(world, ids.b);
      arc += arc_of(world, ids.b);
    }
    const Shape& a = *world.shape(ids.a);
    const Motion& motion_a = world.motion(ids.a);
    const ManifoldOptions manifold{
        .margin = options.margin + own, .most_points = options.most_points, .most_per_patch = options.most_per_patch};
    const ContactOptions first{.margin = options.first_margin + own, .arc = arc};
    const std::span<ManifoldPoint> room = points(i, most_points_);
    if (ids.with_half_space()) {
      const HalfSpace& plane = world.half_space(ids.half_space);
      if (options.manifolds) pair.count = contact_manifold(a, motion_a, plane, manifold, pair.cache, room);
      if (options.first_contacts) pair.first = first_contact(a, motion_a, plane, first);
    } else {
      const Shape& b = *world.shape(ids.b);
      const Motion& motion_b = world.motion(ids.b);
      if (options.manifolds) pair.count = contact_manifold(a, motion_a, b, motion_b, manifold, pair.cache, room);
      if (options.first_contacts) pair.first = first_contact(a, motion_a, b, motion_b, first);
    }
  }

  std::span<ManifoldPoint> points(std::size_t pair, std::size_t count) {
    return points_.empty() ? std::span<ManifoldPoint>() : std::span(points_).subspan(pair * most_points_, count);
  }

  void deliver(const WorldContactOptions& options, void (*visit)(void*, const ContactPair&), void* context,
               WorldContactStatistics& statistics) {
    const auto end = [&](const PairIds& ids) {
      if (options.ended) options.ended({.a = ids.a, .b = ids.b, .half_space = ids.half_space, .event = PairEvent::end});
    };
    const auto end_before = [&](const PairIds* next) {
      while (ended_delivered_ < ended_.size() && (next == nullptr || ended_[ended_delivered_].key() < next->key())) {
        end(ended_[ended_delivered_++]);
      }
    };
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      Pair& pair = pairs_[i];
      end_before(&pair.ids);
      const bool touched = std::exchange(pair.touching, pair.count > 0 || pair.first);
      if (pair.touching) {
        ++statistics.pairs;
        statistics.points += pair.count;
        visit(context, {.a = pair.ids.a,
                        .b = pair.ids.b,
                        .half_space = pair.ids.half_space,
                        .event = touched ? PairEvent::persist : PairEvent::begin,
                        .points = points(i, static_cast<std::size_t>(pair.count)),
                        .first = pair.first});
      } else if (touched) {
        end(pair.ids);
      }
    }
    end_before(nullptr);
  }

  std::vector<PairIds> found_;
  std::vector<Pair> pairs_;     // of the last call, in order
  std::vector<Pair> joined_;    // of the next one, while it is made
  std::vector<PairIds> ended_;  // pairs that were touching and are no candidates any more
  std::size_t ended_delivered_ = 0;
  std::vector<ManifoldCache> spare_;
  std::vector<ManifoldPoint> points_;  // most_points_ for each pair
  std::vector<char> failed_;
  std::size_t most_points_ = 0;
};

WorldContacts::WorldContacts() : state_(std::make_unique<State>()) {}
WorldContacts::~WorldContacts() = default;
WorldContacts::WorldContacts(const WorldContacts& other) : state_(std::make_unique<State>(*other.state_)) {}
WorldContacts& WorldContacts::operator=(const WorldContacts& other) {
  if (this != &other) *state_ = *other.state_;
  return *this;
}
WorldContacts::WorldContacts(WorldContacts&&) noexcept = default;
WorldContacts& WorldContacts::operator=(WorldContacts&&) noexcept = default;

WorldContactStatistics WorldContacts::visit_contacts(World& world, const WorldContactOptions& options,
                                                     void (*visit)(void*, const ContactPair&), void* context) {
  return state_->find(world, options, visit, context);
}

void WorldContacts::clear() noexcept { state_->clear(); }

}  // namespace encage
