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
constexpr double enough_gain = 0.005;  // of the excess

/// Decided by experiment: what brings most for its time.
struct Effort {
  int passes;  ///< steps get shorter as they jam: starting over with long ones frees coarse cages again
  int rounds;  ///< of redistribution
};

Effort effort_for(std::int64_t faces) {
  if (faces <= 150) return {1, 4};
  if (faces <= 1000) return {1, 2};
  return {1, 0};
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
  RedistributeRequest redistribution;
  redistribution.faces = request.faces;
  redistribution.work = 2'000'000'000;
  redistribution.editing.clearance = request.clearance;
  redistribution.editing.self_clearance = request.self_clearance;
  redistribution.contact = contact_options(request, control);
  CageEditor editor(obstacle, candidate.cage, redistribution.editing);
  tighten(editor);
  candidate.cage = editor.extract();
  const Effort effort = effort_for(request.faces);
  for (int pass = 0; pass < effort.passes; ++pass) {
    candidate.cage = shrink(obstacle, candidate.cage, redistribution.contact);
  }
  if (effort.rounds > 0) {
    redistribution.rounds = effort.rounds;
    const double inside = std::max(0.0, signed_volume(*request.inner));
    redistribution.enough = enough_gain * (signed_volume(candidate.cage) - inside);
    candidate.cage = redistribute_faces(obstacle, candidate.cage, redistribution);
    candidate.cage = shrink(obstacle, candidate.cage, redistribution.contact);
  }
  candidate.volume = signed_volume(candidate.cage);
}

}  // namespace encage::makers
