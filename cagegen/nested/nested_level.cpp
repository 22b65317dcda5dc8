// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/nested/nested_level.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "cagegen/collapse/collapse.h"
#include "cagegen/contact/minimize.h"
#include "cagegen/flow/flow.h"
#include "cagegen/nested/coarse_sources.h"
#include "cagegen/nested/expand.h"
#include "cagegen/nested/reinflate.h"

namespace encage::makers {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFlowGap = 1e-4;      // diagonals that F keeps to the coarse mesh; at least
constexpr double kFlowClearances = 4;  // clearances
// Of the time that one coarse mesh takes, where a stage ends.
constexpr double kDecimateShare = 0.15;
constexpr double kFlowShare = 0.25;
constexpr double kInflateShare = 0.4;
constexpr int kFlowSteps = 150;
constexpr int kExpansions = 10;
constexpr int kExpansionPatience = 3;
constexpr double kExpansionReach = 1e-2;  // diagonals, of one expansion
constexpr std::int64_t kCompete = 300;    // faces up to which all coarse meshes are nested, and the tightest kept
constexpr double kSelfClearance = 6;      // clearances: the next level must fit between two strands of this one

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

class NestedLevel {
 public:
  NestedLevel(const Obstacle& obstacle, const NestedRequest& request, Control& control)
      : obstacle_(obstacle), request_(request), control_(control) {}

  std::optional<NestedResult> run(const std::function<bool(const Candidate&)>& accept, std::string& failure) {
    const auto check = [this] { control_.throw_if_cancelled(); };
    const bool compete = request_.faces <= kCompete;
    std::vector<NestedResult> nested;
    const std::vector<CoarseSource> sources = coarse_sources(obstacle_, request_, check);
    share_ = compete ? 1.0 / static_cast<double>(sources.size()) : 1;
    for (const CoarseSource& source : sources) {
      check();
      report(0);
      auto coarse = source.make();
      if (!coarse) {
        fail(source.name,
             "no coarse mesh of " + std::to_string(request_.faces) + " faces without self-intersection comes of it",
             failure);
        continue;
      }
      NestedResult result;
      result.candidate.start = source.name;
      std::string reason;
      if (!nest(*coarse, result, reason)) {
        fail(source.name, reason, failure);
        if (compete) done_ += share_;
        continue;
      }
      result.undeformed = std::move(*coarse);
      nested.push_back(std::move(result));
      if (!compete) break;
      done_ += share_;
    }
    std::stable_sort(nested.begin(), nested.end(), [](const NestedResult& a, const NestedResult& b) {
      return a.candidate.volume < b.candidate.volume;
    });
    for (NestedResult& result : nested) {
      finish(result);
      if (accept(result.candidate)) return std::move(result);
      fail(result.candidate.start, "the certificate refuses the cage", failure);
    }
    return std::nullopt;
  }

 private:
  /// `fraction` of what there is to do with one coarse mesh.
  void report(double fraction) const { control_.fraction = done_ + share_ * fraction; }

  void fail(const std::string& source, const std::string& reason, std::string& failure) const {
    if (request_.log) request_.log("coarse mesh '" + source + "': " + reason);
    failure = source + ": " + reason;
  }

  /// Drops parts of the coarse mesh that stay empty.
  bool nest(TriangleMesh& coarse, NestedResult& result, std::string& reason) {
    TriangleMesh cage = coarse;
    const auto start = Clock::now();
    report(kDecimateShare);
    FlowResult flowed = flow_into(*request_.inner, cage, kFlowSteps);
    const int expansions = flowed.inside ? 0 : expand_and_flow(cage, flowed);
    result.flow_seconds += seconds_since(start);
    if (!flowed.inside) {
      reason = "the flow stalls: " + std::to_string(flowed.stuck.size()) + " triangles stay outside after " +
               std::to_string(flowed.history.steps()) + " steps, also with the coarse mesh expanded " +
               std::to_string(expansions) + " times";
      return false;
    }
    if (flowed.smoothing_steps > 0) note(result, "the flowing mesh was smoothed", flowed.smoothing_steps);
    if (expansions > 0) note(result, "the flow stalled and the coarse mesh was expanded", expansions);
    const auto inflate_start = Clock::now();
    Obstacle inside = obstacle_;
    inside.move(flowed.positions);
    drop_empty_parts(coarse, cage, inside);
    const bool nested = inflate(cage, coarse, flowed, result, reason);
    result.reinflate_seconds += seconds_since(inflate_start);
    return nested;
  }

  double flow_gap() const { return std::max(kFlowGap * request_.diagonal, kFlowClearances * request_.clearance); }

  /// Makes room where F is stuck, and lets it flow on from there. Returns how often.
  int expand_and_flow(TriangleMesh& cage, FlowResult& flowed) const {
    TriangleMesh fine = *request_.inner;
    std::size_t fewest = flowed.stuck.size();
    int last_gain = 0;
    int expansions = 0;
    while (!flowed.inside && expansions < kExpansions && expansions < last_gain + kExpansionPatience) {
      fine.vertices = flowed.positions;
      cage = expand(cage, fine, flowed.stuck, flow_gap(), kExpansionReach * request_.diagonal, contact_options());
      FlowResult more = flow_into(fine, cage, kFlowSteps / 3);
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

  void note(const NestedResult& result, const std::string& what, int times) const {
    if (!request_.log) return;
    request_.log("coarse mesh '" + result.candidate.start + "': " + what + " " + std::to_string(times) +
                 (times == 1 ? " time" : " times"));
  }

  bool inflate(const TriangleMesh& cage, const TriangleMesh& coarse, const FlowResult& flowed, NestedResult& result,
               std::string& reason) {
    ContactSolver solver(cage, contact_options());
    ReinflateRequest reinflation;
    reinflation.fine = request_.inner;
    reinflation.rest = &coarse;
    reinflation.flowed = &flowed;
    reinflation.energy = request_.inflate.get();
    reinflation.path = request_.path;
    reinflation.origin = request_.origin;
    reinflation.progress = [&](double fraction) { report(kFlowShare + fraction * (kInflateShare - kFlowShare)); };
    const ReinflateResult reached = reinflate(solver, reinflation, obstacle_);
    if (!reached.reached) {
      reason = reached.failure;
      return false;
    }
    if (reached.reliefs > 0) note(result, "pinched, and relieved", reached.reliefs);
    minimize_final(solver, coarse);
    result.candidate.cage = solver.mesh();
    result.candidate.volume = signed_volume(result.candidate.cage);
    return true;
  }

  void minimize_final(ContactSolver& solver, const TriangleMesh& rest) const {
    MinimizeRequest minimization;
    minimization.fine = request_.inner;
    minimization.rest = &rest;
    minimization.energy = request_.final.get();
    minimization.progress = [&](double fraction) { report(kInflateShare + fraction * (1 - kInflateShare)); };
    minimize(solver, obstacle_, minimization);
  }

  /// More of the final energy, from long steps again, which frees coarse cages; for the volume, vertex by vertex too.
  void finish(NestedResult& result) const {
    const auto start = Clock::now();
    TriangleMesh& cage = result.candidate.cage;
    const bool volume = request_.final->name() == "volume";
    const int passes = request_.faces <= 1000 ? 2 : 0;
    for (int pass = 0; pass <= passes; ++pass) {
      if (pass > 0) {
        ContactSolver solver(cage, contact_options());
        minimize_final(solver, result.undeformed);
        cage = solver.mesh();
      }
      if (!volume) continue;
      EditorOptions editing;
      editing.clearance = request_.clearance;
      editing.self_clearance = kSelfClearance * request_.clearance;
      CageEditor editor(obstacle_, cage, editing);
      tighten(editor);
      cage = editor.extract();
    }
    result.candidate.volume = signed_volume(cage);
    result.reinflate_seconds += seconds_since(start);
  }

  ContactOptions contact_options() const {
    ContactOptions options;
    options.clearance = request_.clearance;
    options.self_clearance = kSelfClearance * request_.clearance;
    options.threads = request_.threads;
    options.check = [this] { control_.throw_if_cancelled(); };
    return options;
  }

  const Obstacle& obstacle_;
  const NestedRequest& request_;
  Control& control_;
  double done_ = 0;
  double share_ = 1;
};

}  // namespace

std::optional<NestedResult> build_nested_level(const Obstacle& obstacle, const NestedRequest& request, Control& control,
                                               const std::function<bool(const Candidate&)>& accept,
                                               std::string& failure) {
  return NestedLevel(obstacle, request, control).run(accept, failure);
}

}  // namespace encage::makers
