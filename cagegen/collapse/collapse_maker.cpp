// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/collapse_maker.h"

#include "cagegen/collapse/cage_editor.h"
#include "cagegen/collapse/collapse.h"
#include "cagegen/collapse/convex_hull.h"
#include "cagegen/collapse/convex_starts.h"
#include "cagegen/collapse/finish.h"
#include "cagegen/collapse/starts.h"
#include "cagegen/threads/parallel.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

// Decided by experiment on octopus, fandisk, elephant and armadillo.
constexpr double collapse_quadric_weight = 10;
constexpr double offset_height = 2e-4;                   // height of an offset start, diagonals
constexpr double offset_clearances = 3;                  // and at least as many clearances
constexpr std::int64_t most_hull_faces = 8;              // of the target's, above which a hull is decimated
constexpr std::uint64_t work_per_level = 2'000'000'000;  // triangle tests of one candidate
constexpr double rivals_excess = 1.5;                    // that settling may make up for, in the tightest's
constexpr double explosion_factor = 20;                  // a candidate may grow to so many times its start

struct Start {
  enum class Kind { decimate, wrap, hull, box, tetrahedron } kind;
  double parameter = 0;  ///< faces relative to the target, or diagonals relative to alpha
  double fallback = 0;   ///< of a decimation that fails: a wrap's parameter, 0 for none
};

using Phase = std::vector<Start>;

/// What to try: all starts of a phase compete; the next phase only runs if none came through.
std::vector<Phase> portfolio(const LevelRequest& request) {
  using Kind = Start::Kind;
  const bool decimates = request.manifold && request.topology != Topology::simplify;
  std::vector<Phase> phases;
  const auto add = [&](Phase decimations, Phase wraps) {
    Phase phase;
    if (decimates) phase = std::move(decimations);
    if (request.topology != Topology::keep) phase.insert(phase.end(), wraps.begin(), wraps.end());
    if (!phase.empty()) phases.push_back(std::move(phase));
  };
  if (own_surface_suffices(request)) add({{Kind::decimate, 1, 0}}, {});
  const double finest = request.faces >= 4000 ? 100 : 50;
  // Alpha wraps with several times the target's faces; their number goes with the square of the parameter.
  const double fine_wrap = request.faces >= 1500 ? 100 : request.faces >= 400 ? 50 : 32;
  const double fallback = request.topology == Topology::keep ? 0 : fine_wrap;
  if (request.faces >= 1500) {
    add({{Kind::decimate, 2, fallback}}, decimates ? Phase{} : Phase{{Kind::wrap, finest}});
    add({}, {{Kind::wrap, 50}, {Kind::wrap, 20}});
  } else if (request.faces >= 300) {
    add({{Kind::decimate, 4, fallback}},
        decimates ? Phase{{Kind::wrap, 20}} : Phase{{Kind::wrap, 50}, {Kind::wrap, 20}});
    add({}, {{Kind::wrap, 10}, {Kind::wrap, 5}});
  } else {
    add({{Kind::decimate, 8, request.faces >= 150 ? fallback : 0}},
        {{Kind::wrap, 20}, {Kind::wrap, 10}, {Kind::wrap, 5}});
    add({}, {{Kind::wrap, 50}});
  }
  return phases;
}

/// Starts that always come through. No cage need enclose more than the tightest of them.
Phase convex_starts(const LevelRequest& request) {
  using Kind = Start::Kind;
  return request.faces < 12 ? Phase{{Kind::hull}, {Kind::tetrahedron}} : Phase{{Kind::hull}, {Kind::box}};
}

bool is_convex(const Start& start) { return start.kind != Start::Kind::decimate && start.kind != Start::Kind::wrap; }

std::string name(const Start& start) {
  switch (start.kind) {
    case Start::Kind::decimate: return "decimate";
    case Start::Kind::wrap: return "wrap/" + std::to_string(static_cast<int>(start.parameter));
    case Start::Kind::hull: return "hull";
    case Start::Kind::box: return "box";
    case Start::Kind::tetrahedron: return "tetrahedron";
  }
  return {};
}

double start_height(const LevelRequest& request) {
  return std::max(offset_height * request.diagonal, offset_clearances * request.clearance);
}

std::optional<TriangleMesh> make_decimation(double parameter, const Obstacle& obstacle, const LevelRequest& request) {
  const TriangleMesh& clean = *request.clean;
  const double height = start_height(request);
  const double available = static_cast<double>(clean.triangles.rows());
  // Coarse decimations fold or cut through more often: then a finer one.
  double faces = parameter * static_cast<double>(request.faces);
  for (int attempt = 0; attempt < 3 && faces < 0.8 * available; ++attempt) {
    auto cage =
        offset_start(obstacle, simplify(clean, static_cast<std::int64_t>(faces)), height, true, request.clearance);
    if (cage) return cage;
    faces *= 1.5;
  }
  if (available > 2 * faces) return std::nullopt;
  auto cage = offset_start(obstacle, clean, height / 2, false, request.clearance);
  return cage ? cage : offset_start(obstacle, clean, height, true, request.clearance);
}

/// Makes the start, or its fallback, which then replaces it. Convex starts need the frame.
std::optional<TriangleMesh> make_start(Start& start, const Obstacle& obstacle, const LevelRequest& request,
                                       const ConvexFrame* frame) {
  switch (start.kind) {
    case Start::Kind::hull: {
      TriangleMesh hull = hull_start(obstacle, *frame, request.clearance);
      const std::int64_t most = most_hull_faces * request.faces;
      if (hull.triangles.rows() <= most) return hull;
      return offset_start(obstacle, simplify(hull, most), start_height(request), true, request.clearance);
    }
    case Start::Kind::box: return box_start(obstacle, *frame, request.clearance);
    case Start::Kind::tetrahedron: return tetrahedron_start(obstacle, *frame, request.clearance);
    case Start::Kind::decimate: {
      auto cage = make_decimation(start.parameter, obstacle, request);
      if (cage || start.fallback == 0) return cage;
      start = {Start::Kind::wrap, start.fallback};
      break;
    }
    case Start::Kind::wrap: break;
  }
  return request.wraps->get(start.parameter);
}

EditorOptions editor_options(const LevelRequest& request) {
  EditorOptions options;
  options.clearance = request.clearance;
  options.self_clearance = request.self_clearance;
  options.quadric_weight = collapse_quadric_weight;
  return options;
}

std::optional<Candidate> run(Start start, const Obstacle& obstacle, const LevelRequest& request,
                             const ConvexFrame* frame, Control& control, const std::function<void(double)>& progress) {
  auto cage = make_start(start, obstacle, request, frame);
  if (!cage) return std::nullopt;
  *cage = outermost_components(*cage);
  const double volume = signed_volume(*cage);
  CageEditor editor(obstacle, *cage, editor_options(request));
  CollapseLimits limits;
  limits.faces = request.faces;
  limits.added_volume = explosion_factor * volume;
  limits.work = work_per_level;
  limits.progress = [&](double fraction) {
    control.throw_if_cancelled();
    progress(fraction);
  };
  limits.progress(0);
  if (editor.face_count() > request.faces) tighten(editor);
  bool reached = collapse_edges(editor, limits);
  if (!reached && !is_convex(start)) {
    // Flat sheets have vertices without a cone of outward directions; there the condition must go.
    EditorOptions options = editor.options();
    options.keep_cones = false;
    editor.set_options(options);
    reached = collapse_edges(editor, limits);
  }
  if (!reached) return std::nullopt;
  tighten(editor);
  Candidate candidate;
  candidate.cage = editor.extract();
  candidate.volume = signed_volume(candidate.cage);
  candidate.start = name(start);
  candidate.method = is_convex(start) ? Method::hull : Method::collapse;
  return candidate;
}

/// Runs the starts of a phase, as many at a time as there are threads.
std::vector<Candidate> compete(const Phase& phase, const Obstacle& obstacle, const LevelRequest& request,
                               Control& control, const ConvexFrame* frame = nullptr) {
  std::vector<std::optional<Candidate>> results(phase.size());
  std::vector<double> fractions(phase.size(), 0.0);
  std::mutex mutex;
  for_each_task(request.threads, phase.size(), [&](std::size_t i) {
    // Out of time: whoever comes later is left out, as long as somebody came before.
    if (i > 0 && control.expired()) return;
    results[i] = run(phase[i], obstacle, request, frame, control, [&](double fraction) {
      const std::lock_guard lock(mutex);
      fractions[i] = fraction;
      double sum = 0;
      for (const double f : fractions) sum += f;
      control.fraction = sum / static_cast<double>(fractions.size());
    });
  });
  std::vector<Candidate> candidates;
  for (std::optional<Candidate>& result : results) {
    if (result) candidates.push_back(std::move(*result));
  }
  return candidates;
}

/// Settles the candidates that may still become the tightest.
void settle_best(std::vector<Candidate>& candidates, const Obstacle& obstacle, const LevelRequest& request,
                 Control& control) {
  if (candidates.empty() || own_surface_suffices(request)) return;
  const auto tightest = std::min_element(candidates.begin(), candidates.end(),
                                         [](const auto& a, const auto& b) { return a.volume < b.volume; });
  const double inside = std::max(0.0, signed_volume(*request.inner));
  const double most = inside + rivals_excess * (tightest->volume - inside);
  for_each_task(request.threads, candidates.size(), [&](std::size_t i) {
    if (candidates[i].volume <= most) settle(obstacle, request, control, candidates[i]);
  });
}

class ConvexMaker : public CandidateMaker {
 public:
  ConvexMaker(const Obstacle& obstacle, const LevelRequest& request, Control& control)
      : obstacle_(obstacle), request_(request), control_(control) {}

  std::vector<Candidate> next() override {
    if (std::exchange(done_, true)) return {};
    return compete(convex_starts(request_), obstacle_, request_, control_, &frame());
  }
  double least_volume() override {
    const auto hull = convex_hull(frame().points);
    return hull ? signed_volume(*hull) : 0;
  }
  void finish(Candidate& candidate) override { finish_by_volume(obstacle_, request_, control_, candidate); }
  void redistribute(Candidate& candidate) override { redistribute_by_volume(obstacle_, request_, control_, candidate); }
  std::string failure() const override { return "the certificate refuses the convex cages"; }

 private:
  const ConvexFrame& frame() {
    if (!frame_) frame_.emplace(*request_.clean, request_.clearance);
    return *frame_;
  }

  const Obstacle& obstacle_;
  const LevelRequest& request_;
  Control& control_;
  std::optional<ConvexFrame> frame_;
  bool done_ = false;
};

class CollapseMaker : public CandidateMaker {
 public:
  CollapseMaker(const Obstacle& obstacle, const LevelRequest& request, Control& control)
      : obstacle_(obstacle), request_(request), control_(control), phases_(portfolio(request)) {}

  std::vector<Candidate> next() override {
    while (phase_ < phases_.size()) {
      auto candidates = compete(phases_[phase_++], obstacle_, request_, control_);
      settle_best(candidates, obstacle_, request_, control_);
      if (!candidates.empty()) return candidates;
    }
    return {};
  }
  void finish(Candidate& candidate) override { finish_by_volume(obstacle_, request_, control_, candidate); }
  void redistribute(Candidate& candidate) override { redistribute_by_volume(obstacle_, request_, control_, candidate); }
  std::string failure() const override {
    return "no cage of " + std::to_string(request_.faces) + " faces keeps the topology of the level before";
  }

 private:
  const Obstacle& obstacle_;
  const LevelRequest& request_;
  Control& control_;
  std::vector<Phase> phases_;
  std::size_t phase_ = 0;
};

}  // namespace

std::unique_ptr<CandidateMaker> collapse_maker(const Obstacle& obstacle, const LevelRequest& request,
                                               Control& control) {
  return std::make_unique<CollapseMaker>(obstacle, request, control);
}

std::unique_ptr<CandidateMaker> convex_maker(const Obstacle& obstacle, const LevelRequest& request, Control& control) {
  return std::make_unique<ConvexMaker>(obstacle, request, control);
}

}  // namespace encage::makers
