// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/strategy.h"

#include "bench/tank/embree_tree.h"
#include "bench/tank/kdop_tree.h"

#include <encage/error.h>

#include <algorithm>
#include <utility>

namespace encage::tank {
namespace {

/// Trees over the swept triangles of every surviving body, then the common narrow phase.
template <class Tree>
class RebuildingFinder : public ContactFinder {
 public:
  RebuildingFinder(const TankBody& body, const ContactOptions& options) : body_(body), options_(options) {}

  std::vector<std::optional<Contact>> find(const bench::RecordedStep& step, const Survivors& survivors) override {
    if (trees_.size() < step.bodies.size()) trees_.resize(step.bodies.size());
    const double distance = options_.margin + options_.arc;
    for (std::size_t k = 0; k < survivors.bodies.size(); ++k) {
      trees_[k].build(make_sweep(body_.mesh, step.bodies[survivors.bodies[k]].motion, distance));
    }
    // Trees stand in the order of the surviving bodies: memory is used again as it becomes free.
    const auto tree_of = [&](std::int32_t body) -> const Tree& {
      const auto at = std::lower_bound(survivors.bodies.begin(), survivors.bodies.end(), body);
      return trees_[at - survivors.bodies.begin()];
    };
    std::vector<std::optional<Contact>> contacts;
    for (const IndexPair& pair : survivors.pairs) {
      candidates_.clear();
      Tree::overlaps(tree_of(pair.a), tree_of(pair.b), candidates_);
      PairContact narrow(*body_.shape, step.bodies[pair.a].motion, *body_.shape, step.bodies[pair.b].motion, options_);
      for (const TrianglePair& candidate : candidates_) narrow.test(candidate.a, candidate.b);
      contacts.push_back(narrow.first());
    }
    return contacts;
  }

 private:
  const TankBody& body_;
  ContactOptions options_;
  std::vector<Tree> trees_;
  std::vector<TrianglePair> candidates_;
};

class PrebuiltFinder : public ContactFinder {
 public:
  PrebuiltFinder(const TankBody& body, const ContactOptions& options) : body_(body), options_(options) {}

  std::vector<std::optional<Contact>> find(const bench::RecordedStep& step, const Survivors& survivors) override {
    std::vector<std::optional<Contact>> contacts;
    for (const IndexPair& pair : survivors.pairs) {
      contacts.push_back(
          first_contact(*body_.shape, step.bodies[pair.a].motion, *body_.shape, step.bodies[pair.b].motion, options_));
    }
    return contacts;
  }

 private:
  const TankBody& body_;
  ContactOptions options_;
};

std::unique_ptr<ContactFinder> make_finder(const TankBody& body, Baseline baseline, const ContactOptions& options) {
  switch (baseline) {
    case Baseline::rebuild_kdop: return std::make_unique<RebuildingFinder<KdopTree>>(body, options);
    case Baseline::rebuild_embree: return std::make_unique<RebuildingFinder<EmbreeTree>>(body, options);
    case Baseline::prebuilt: break;
  }
  return std::make_unique<PrebuiltFinder>(body, options);
}

}  // namespace

TankBody make_tank_body(CageHierarchy hierarchy) {
  if (hierarchy.fine.triangles.rows() == 0) throw Error("the hierarchy has no fine mesh");
  if (hierarchy.levels.empty()) throw Error("the hierarchy has no cage");
  ShapePtr shape = make_shape(hierarchy);
  return {std::move(shape), BodyMesh(std::move(hierarchy.fine), hierarchy.origin), hierarchy.fine_error};
}

StageCounts& StageCounts::operator+=(const StageCounts& other) {
  pairs += other.pairs;
  boxes += other.boxes;
  cages += other.cages;
  touching += other.touching;
  return *this;
}

PairFilter::PairFilter(const TankBody& body, bool cages, const StrategyOptions& options)
    : body_(body), cages_(cages), distance_(options.contact.margin + options.contact.arc) {
  cage_options_.boxes = false;
  cage_options_.cages = CageUse::always;
  cage_options_.finest_cage = options.finest_cage;
  cage_options_.coarsest_cage = options.coarsest_cage;
  cage_options_.fine = false;
}

Survivors PairFilter::run(const bench::RecordedStep& step, const std::vector<IndexPair>& left_out) const {
  const auto count = static_cast<std::int32_t>(step.bodies.size());
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<double> slack;
  for (const bench::RecordedBody& body : step.bodies) {
    slack.push_back(body_.mesh.slack(body.motion, distance_));
    const Eigen::AlignedBox3d box = world_box(*body_.shape, body.motion);
    boxes.emplace_back(box.min().array() - slack.back(), box.max().array() + slack.back());
  }
  Survivors survivors;
  std::vector<bool> survives(step.bodies.size());
  PairOptions cage_options = cage_options_;
  for (IndexPair pair; pair.a < count; ++pair.a) {
    for (pair.b = pair.a + 1; pair.b < count; ++pair.b) {
      if (std::binary_search(left_out.begin(), left_out.end(), pair)) continue;
      ++survivors.counts.pairs;
      if (!boxes[pair.a].intersects(boxes[pair.b])) continue;
      ++survivors.counts.boxes;
      // Cages enclose the source, from which the fine mesh may differ by rounding.
      cage_options.margin = slack[pair.a] + slack[pair.b] + 2 * body_.fine_error;
      if (cages_ &&
          separated(*body_.shape, step.bodies[pair.a].motion, *body_.shape, step.bodies[pair.b].motion, cage_options)
              .separated) {
        continue;
      }
      ++survivors.counts.cages;
      survivors.pairs.push_back(pair);
      survives[pair.a] = survives[pair.b] = true;
    }
  }
  for (std::int32_t i = 0; i < count; ++i) {
    if (survives[i]) survivors.bodies.push_back(i);
  }
  return survivors;
}

Detection Strategy::detect(const bench::RecordedStep& step, const std::vector<IndexPair>& left_out) {
  const Survivors survivors = filter_.run(step, left_out);
  const std::vector<std::optional<Contact>> contacts = finder_->find(step, survivors);
  Detection detection{survivors.counts, static_cast<std::int64_t>(survivors.bodies.size()), {}};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!contacts[i]) continue;
    const IndexPair pair = survivors.pairs[i];
    detection.contacts.push_back({step.bodies[pair.a].body, step.bodies[pair.b].body, *contacts[i]});
  }
  detection.counts.touching = static_cast<std::int64_t>(detection.contacts.size());
  return detection;
}

const char* name(Baseline baseline) noexcept {
  switch (baseline) {
    case Baseline::rebuild_kdop: return "rebuild_kdop";
    case Baseline::rebuild_embree: return "rebuild_embree";
    case Baseline::prebuilt: break;
  }
  return "prebuilt";
}

Strategy make_strategy(const TankBody& body, Baseline baseline, CageUse cages, const StrategyOptions& options) {
  const char* suffix = cages == CageUse::never ? "" : cages == CageUse::always ? "+cages" : "+policy";
  // As separated() decides: cages are not asked in front of fine trees that are there.
  const bool asks = cages == CageUse::always || (cages == CageUse::automatic && baseline != Baseline::prebuilt);
  return {name(baseline) + std::string(suffix), PairFilter(body, asks, options),
          make_finder(body, baseline, options.contact)};
}

}  // namespace encage::tank
