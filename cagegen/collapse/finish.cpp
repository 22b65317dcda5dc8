// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/finish.h"

#include "cagegen/collapse/cage_editor.h"
#include "cagegen/collapse/collapse.h"
#include "cagegen/collapse/redistribute.h"
#include "cagegen/contact/minimize.h"

#include <algorithm>
#include <cstdint>

namespace encage::makers {

namespace {

constexpr int settling_steps = 20;
constexpr double enough_gain = 0.01;  // of the excess

/// Decided by experiment: what brings most for its time.
struct Effort {
  int rounds;
  int patience;
};

Effort effort_for(const LevelRequest& request) {
  if (own_surface_suffices(request)) return {0, 0};
  if (request.faces <= 150) return {4, 2};
  if (request.faces <= 1000) return {2, 1};
  return {0, 0};
}

ContactSolverOptions contact_options(const LevelRequest& request, Control& control) {
  ContactSolverOptions options;
  options.clearance = request.clearance;
  options.self_clearance = request.self_clearance;
  options.threads = request.threads;
  options.check = [&] { control.throw_if_cancelled(); };
  return options;
}

}  // namespace

void settle(const Obstacle& obstacle, const LevelRequest& request, Control& control, Candidate& candidate) {
  candidate.cage = shrink(obstacle, candidate.cage, contact_options(request, control), settling_steps);
  candidate.volume = signed_volume(candidate.cage);
}

void finish_by_volume(const Obstacle& obstacle, const LevelRequest& request, Control& control, Candidate& candidate) {
  EditorOptions editing;
  editing.clearance = request.clearance;
  editing.self_clearance = request.self_clearance;
  CageEditor editor(obstacle, candidate.cage, editing);
  tighten(editor);
  candidate.cage = shrink(obstacle, editor.extract(), contact_options(request, control));
  candidate.volume = signed_volume(candidate.cage);
}

void redistribute_by_volume(const Obstacle& obstacle, const LevelRequest& request, Control& control,
                            Candidate& candidate) {
  RedistributeRequest redistribution;
  redistribution.faces = request.faces;
  redistribution.work = 2'000'000'000;
  redistribution.editing.clearance = request.clearance;
  redistribution.editing.self_clearance = request.self_clearance;
  redistribution.contact = contact_options(request, control);
  const Effort effort = effort_for(request);
  if (effort.rounds == 0) return;
  redistribution.rounds = effort.rounds;
  redistribution.patience = effort.patience;
  const double inside = std::max(0.0, signed_volume(*request.inner));
  redistribution.enough = enough_gain * (candidate.volume - inside);
  candidate.cage = redistribute_faces(obstacle, candidate.cage, redistribution);
  candidate.cage = shrink(obstacle, candidate.cage, redistribution.contact);
  candidate.volume = signed_volume(candidate.cage);
}

}  // namespace encage::makers
