// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow_maker.h"

#include "cagegen/collapse/finish.h"
#include "cagegen/contact/minimize.h"
#include "cagegen/flow/coarse_sources.h"
#include "cagegen/flow/expand.h"
#include "cagegen/flow/flow.h"
#include "cagegen/flow/reinflate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double least_flow_gap = 1e-4;  // diagonals that F keeps to the coarse mesh; at least
constexpr double flow_clearances = 4;    // clearances
// Of the time that one coarse mesh takes, where a stage ends.
constexpr double decimate_share = 0.15;
constexpr double flow_share = 0.25;
constexpr double inflate_share = 0.4;
constexpr int flow_steps = 150;
constexpr int most_expansions = 10;
constexpr int competing_expansions = 2;
constexpr int expansion_patience = 3;
constexpr double expansion_reach = 1e-2;  // diagonals, of one expansion
constexpr double far_motion = 0.12;       // sizes of a coarse triangle, beyond which a wrap competes with decimations

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A coarse mesh with F flowed into it.
struct Flowed {
  Flowed(const TriangleMesh& coarse, FlowResult in) : cage(coarse), flow(std::move(in)) {}

  Candidate candidate;  ///< with its start and undeformed mesh
  TriangleMesh cage;    ///< expanded where the flow stalled
  FlowResult flow;
  double moved = 0;  ///< how far vertices of F are from home, on average
};

using FlowedPtr = std::unique_ptr<Flowed>;

class FlowMaker : public CandidateMaker {
 public:
  FlowMaker(const Obstacle& obstacle, const LevelRequest& request, const FlowChoices& choices, Control& control)
      : obstacle_(obstacle),
        request_(request),
        choices_(choices),
        control_(control),
        sources_(coarse_sources(request, choices_, [this] { control_.throw_if_cancelled(); })) {}

  std::vector<Candidate> next() override {
    const bool compete = request_.faces <= compete_faces;
    while (next_ < sources_.size()) {
      std::vector<FlowedPtr> flowed;
      done_ = 0;
      share_ = compete ? 1.0 / static_cast<double>(sources_.size()) : 1;
      do {
        flow_in_group(flowed);
      } while (compete && next_ < sources_.size() && !sources_[next_].last_resort);
      const bool doubtful = !compete && next_ < sources_.size() && moved_far(flowed);
      if (doubtful) {
        flow_in_group(flowed);
        share_ = 1.0 / static_cast<double>(flowed.size());
      }
      auto candidates = nest(std::move(flowed), compete || doubtful);
      if (!candidates.empty()) return candidates;
    }
    return {};
  }

  void finish(Candidate& candidate) override {
    const auto start = Clock::now();
    if (is_free()) {
      finish_by_volume(obstacle_, request_, control_, candidate);
    } else {
      // Long steps again, which frees coarse cages.
      for (int pass = 0; pass < (request_.faces <= 1000 ? 2 : 0); ++pass) {
        ContactSolver solver(candidate.cage, contact_options());
        minimize_final(solver, candidate.undeformed);
        candidate.cage = solver.mesh();
      }
      candidate.volume = signed_volume(candidate.cage);
    }
    candidate.reinflate_seconds += seconds_since(start);
  }

  void redistribute(Candidate& candidate) override {
    if (!is_free()) return;
    const auto start = Clock::now();
    redistribute_by_volume(obstacle_, request_, control_, candidate);
    candidate.reinflate_seconds += seconds_since(start);
  }

  std::string failure() const override { return failure_; }

 private:
  /// Faces and vertices serve the volume alone: nobody asked for certain meshes or another energy.
  bool is_free() const {
    return choices_.final == volume_energy() && choices_.coarse == nullptr && !choices_.decimator;
  }

  /// `fraction` of what there is to do with one coarse mesh.
  void report(double fraction) const { control_.fraction = done_ + share_ * fraction; }

  void fail(const std::string& source, const std::string& reason) {
    if (request_.log) request_.log("coarse mesh '" + source + "': " + reason);
    failure_ = source + ": " + reason;
  }

  void note(const Candidate& candidate, const std::string& what, int times) const {
    if (!request_.log) return;
    request_.log("coarse mesh '" + candidate.start + "': " + what + " " + std::to_string(times) +
                 (times == 1 ? " time" : " times"));
  }

  /// F flowed into all sources of the next group.
  void flow_in_group(std::vector<FlowedPtr>& flowed) {
    const int group = sources_[next_].group;
    for (; next_ < sources_.size() && sources_[next_].group == group; ++next_) {
      report(0);
      if (auto in = flow_in(sources_[next_])) flowed.push_back(std::move(in));
    }
    // The less F had to move, the tighter the cage will be.
    std::stable_sort(flowed.begin(), flowed.end(),
                     [](const FlowedPtr& a, const FlowedPtr& b) { return a->moved < b->moved; });
  }

  /// F had to fold to come into any of them, and may jam on its way back.
  bool moved_far(const std::vector<FlowedPtr>& flowed) const {
    if (flowed.empty()) return false;
    double area = 0;
    const TriangleMesh& mesh = flowed.front()->candidate.undeformed;
    for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
      area += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm() / 2;
    }
    return flowed.front()->moved > far_motion * std::sqrt(area / static_cast<double>(mesh.triangles.rows()));
  }

  /// Null if F cannot be brought in.
  FlowedPtr flow_in(const CoarseSource& source) {
    control_.throw_if_cancelled();
    auto coarse = source.make();
    if (!coarse) {
      fail(source.name,
           "no coarse mesh of " + std::to_string(request_.faces) + " faces without self-intersection comes of it");
      return nullptr;
    }
    report(decimate_share);
    const auto start = Clock::now();
    auto in = std::make_unique<Flowed>(*coarse, flow_into(*request_.inner, *coarse, flow_steps));
    in->candidate.start = source.name;
    in->candidate.undeformed = std::move(*coarse);
    const int expansions = in->flow.inside ? 0 : expand_and_flow(in->cage, in->flow);
    in->candidate.flow_seconds = seconds_since(start);
    if (!in->flow.inside) {
      fail(source.name, "the flow stalls: " + std::to_string(in->flow.stuck.size()) + " triangles stay outside after " +
                            std::to_string(in->flow.history.steps()) + " steps, also with the coarse mesh expanded " +
                            std::to_string(expansions) + " times");
      return nullptr;
    }
    if (in->flow.smoothing_steps > 0) note(in->candidate, "the flowing mesh was smoothed", in->flow.smoothing_steps);
    if (expansions > 0) note(in->candidate, "the flow stalled and the coarse mesh was expanded", expansions);
    in->candidate.method = Method::flow;
    in->moved = (in->flow.positions - request_.inner->vertices).rowwise().norm().mean();
    return in;
  }

  /// The first of them that can be nested, or (`all`) all that can.
  std::vector<Candidate> nest(std::vector<FlowedPtr> flowed, bool all) {
    std::vector<Candidate> nested;
    for (FlowedPtr& in : flowed) {
      if (inflate(*in)) nested.push_back(std::move(in->candidate));
      if (all) {
        done_ += share_;
      } else if (!nested.empty()) {
        break;
      }
    }
    return nested;
  }

  double flow_gap() const { return std::max(least_flow_gap * request_.diagonal, flow_clearances * request_.clearance); }

  /// Makes room where F is stuck, and lets it flow on from there. Returns how often.
  int expand_and_flow(TriangleMesh& cage, FlowResult& flowed) const {
    TriangleMesh fine = *request_.inner;
    std::size_t fewest = flowed.stuck.size();
    int last_gain = 0;
    int expansions = 0;
    const int most = choices_.competes ? competing_expansions : most_expansions;
    while (!flowed.inside && expansions < most && expansions < last_gain + expansion_patience) {
      fine.vertices = flowed.positions;
      cage = expand(cage, fine, flowed.stuck, flow_gap(), expansion_reach * request_.diagonal, contact_options());
      FlowResult more = flow_into(fine, cage, flow_steps / 3);
      flowed.history.append(more.history);
      more.history = std::move(flowed.history);
      more.smoothing_steps += flowed.smoothing_steps;
      flowed = std::move(more);
      ++expansions;
      if (flowed.stuck.size() < fewest) {
        fewest = flowed.stuck.size();
        last_gain = expansions;
      }
    }
    return expansions;
  }

  FlowResult flow_into(const TriangleMesh& fine, const TriangleMesh& cage, int most_steps) const {
    FlowRequest flow_request;
    flow_request.fine = &fine;
    flow_request.coarse = &cage;
    flow_request.diagonal = request_.diagonal;
    flow_request.gap = flow_gap();
    flow_request.threads = request_.threads;
    flow_request.most_steps = most_steps;
    flow_request.check = [this] { control_.throw_if_cancelled(); };
    return flow(flow_request);
  }

  bool inflate(Flowed& flowed) {
    const auto start = Clock::now();
    Candidate& candidate = flowed.candidate;
    Obstacle inside = obstacle_;
    inside.move(flowed.flow.positions);
    drop_empty_parts(candidate.undeformed, flowed.cage, inside);
    ContactSolver solver(flowed.cage, contact_options());
    ReinflateRequest reinflation;
    reinflation.fine = request_.inner;
    reinflation.rest = &candidate.undeformed;
    reinflation.flowed = &flowed.flow;
    reinflation.energy = choices_.inflate.get();
    reinflation.path = choices_.path;
    reinflation.origin = request_.origin;
    reinflation.progress = [&](double fraction) { report(flow_share + fraction * (inflate_share - flow_share)); };
    const ReinflateResult reached = reinflate(solver, reinflation, obstacle_);
    if (!reached.reached) {
      fail(candidate.start, reached.failure);
      return false;
    }
    if (reached.slow_steps > 0) note(candidate, "followed by the slow solver", reached.slow_steps);
    if (reached.reliefs > 0) note(candidate, "pinched, and relieved", reached.reliefs);
    minimize_final(solver, candidate.undeformed);
    candidate.cage = solver.mesh();
    candidate.volume = signed_volume(candidate.cage);
    candidate.reinflate_seconds = seconds_since(start);
    return true;
  }

  void minimize_final(ContactSolver& solver, const TriangleMesh& rest) const {
    MinimizeRequest minimization;
    minimization.fine = request_.inner;
    minimization.rest = &rest;
    minimization.energy = choices_.final.get();
    minimization.progress = [&](double fraction) { report(inflate_share + fraction * (1 - inflate_share)); };
    minimize(solver, obstacle_, minimization);
  }

  ContactSolverOptions contact_options() const {
    ContactSolverOptions options;
    options.clearance = request_.clearance;
    options.self_clearance = request_.self_clearance;
    options.threads = request_.threads;
    options.check = [this] { control_.throw_if_cancelled(); };
    return options;
  }

  const Obstacle& obstacle_;
  const LevelRequest& request_;
  const FlowChoices choices_;
  Control& control_;
  std::vector<CoarseSource> sources_;
  std::size_t next_ = 0;
  std::string failure_ = "no coarse mesh could be nested";
  double done_ = 0;
  double share_ = 1;
};

}  // namespace

std::unique_ptr<CandidateMaker> flow_maker(const Obstacle& obstacle, const LevelRequest& request,
                                           const FlowChoices& choices, Control& control) {
  return std::make_unique<FlowMaker>(obstacle, request, choices, control);
}

}  // namespace encage::makers
