// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/reinflate.h"

#include "cagegen/contact/minimize.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

constexpr double straight_step = 1.0 / 3;         // of the way
constexpr double fast_shortest_step = 1.0 / 32;   // the fast solver's shortest step, in first steps
constexpr double slow_shortest_step = 1.0 / 512;  // the slow one's
constexpr int most_reliefs = 8;
constexpr double tightest_self_clearances = 0.3;  // clearances that the cage keeps to itself where it would jam
constexpr int energy_steps = 3;                   // of descent after each step of F

class Reinflation {
 public:
  Reinflation(ContactSolver& solver, const ReinflateRequest& request, const Obstacle& home)
      : solver_(solver), request_(request), before_(home), after_(home) {
    first_step_ = request.path == FlowPath::history && request.flowed->history.steps() > 0
                      ? 1.0 / request.flowed->history.steps()
                      : straight_step;
  }

  ReinflateResult run() {
    before_.move(position(0));
    double way = 0;
    double step = first_step_;
    while (way < 1) {
      solver_.options().check();
      if (request_.progress) request_.progress(way);
      const double next = way + step > 1 - 1e-9 ? 1 : way + step;
      const bool slow = step < fast_shortest_step * first_step_;
      if (advance(next, slow)) {
        way = next;
        ++result_.steps;
        if (slow) ++result_.slow_steps;
        step = std::min(2 * step, first_step_);
        descend();
        continue;
      }
      ++result_.halvings;
      step /= 2;
      if (step >= fast_shortest_step * first_step_) continue;
      if (give_room()) continue;
      if (slow) step /= 2;
      if (step >= slow_shortest_step * first_step_) continue;
      if (result_.reliefs >= most_reliefs) {
        describe_failure(way);
        return result_;
      }
      relieve();
      step = fast_shortest_step * first_step_;
    }
    result_.reached = true;
    return result_;
  }

 private:
  /// F on its way: 0 flowed, 1 home.
  Vertices position(double way) const {
    const FlowResult& flowed = *request_.flowed;
    if (way >= 1) return request_.fine->vertices;
    if (request_.path == FlowPath::straight) {
      return (1 - way) * flowed.positions + way * request_.fine->vertices;
    }
    const double back = (1 - way) * flowed.history.steps();
    const int whole = static_cast<int>(back);
    const double part = back - whole;
    if (part == 0) return flowed.history.at(whole);
    return (1 - part) * flowed.history.at(whole) + part * flowed.history.at(whole + 1);
  }

  EnergyState state(const Vertices& cage) const { return {*request_.fine, *request_.rest, cage, cage}; }

  /// One step of F to `next`, with one of the energy's descent.
  bool advance(double next, bool slow) {
    after_.move(position(next));
    const Vertices cage = solver_.mesh().vertices;
    const Vertices direction = checked_descent(*request_.energy, state(cage));
    ContactSolver::Positions wanted = solver_.positions();
    if (const auto length = request_.energy->first_step()) {
      for (std::size_t v = 0; v < wanted.size(); ++v) {
        wanted[v] += *length * direction.row(static_cast<std::int64_t>(v)).transpose();
      }
    }
    const double reach = slow ? 40 * solver_.options().clearance : 0;
    auto followed = solver_.follow(before_, after_, wanted, reach);
    if (!followed || !encloses_all(*followed)) return false;
    solver_.commit(std::move(*followed));
    std::swap(before_, after_);
    return true;
  }

  /// One point of each component of F is inside. Where there are very many, the certificate decides in the end.
  bool encloses_all(const ContactSolver::Positions& positions) const {
    const auto& points = after_.representatives();
    if (points.size() * solver_.face_count() > 20'000'000) return true;
    return std::all_of(points.begin(), points.end(), [&](const Point& x) { return solver_.encloses(positions, x); });
  }

  /// Energies that do not lead to where the cage is by themselves get a few steps with F at rest.
  void descend() {
    const Vertices cage = solver_.mesh().vertices;
    if (checked_descent(*request_.energy, state(cage)).cwiseAbs().maxCoeff() == 0) return;
    MinimizeRequest request;
    request.fine = request_.fine;
    request.rest = request_.rest;
    request.energy = request_.energy;
    request.iterations = energy_steps;
    minimize(solver_, before_, request);
  }

  /// Lets strands of the cage come closer to each other: room for coarser levels is lost there, which is better than no
  /// cage.
  bool give_room() {
    const double tightest = tightest_self_clearances * solver_.options().clearance;
    if (solver_.options().self_clearance <= tightest) return false;
    solver_.set_self_clearance(std::max(tightest, solver_.options().self_clearance / 4));
    ++result_.reliefs;
    return true;
  }

  /// Moves the jammed faces and what is around them outward, and evens them out, to make room.
  void relieve() {
    ++result_.reliefs;
    std::vector<bool> chosen(solver_.positions().size(), false);
    for (const std::int32_t f : solver_.jammed()) {
      for (const std::int32_t v : solver_.face(static_cast<std::size_t>(f))) chosen[v] = true;
    }
    const int rings = 1 + result_.reliefs / 3;
    for (int ring = 0; ring < rings; ++ring) {
      const std::vector<bool> inner = chosen;
      for (std::size_t f = 0; f < solver_.face_count(); ++f) {
        const auto& face = solver_.face(f);
        if (!inner[face[0]] && !inner[face[1]] && !inner[face[2]]) continue;
        for (const std::int32_t v : face) chosen[v] = true;
      }
    }
    const ContactSolver::Positions& positions = solver_.positions();
    std::vector<Point> normal(positions.size(), Point::Zero());
    std::vector<Point> middle(positions.size(), Point::Zero());
    std::vector<double> length(positions.size(), 0);
    std::vector<int> count(positions.size(), 0);
    for (std::size_t f = 0; f < solver_.face_count(); ++f) {
      const auto& face = solver_.face(f);
      const Point n = (positions[face[1]] - positions[face[0]]).cross(positions[face[2]] - positions[face[0]]);
      for (int k = 0; k < 3; ++k) {
        normal[face[k]] += n;
        middle[face[k]] += positions[face[(k + 1) % 3]];
        length[face[k]] += (positions[face[(k + 1) % 3]] - positions[face[k]]).norm();
        ++count[face[k]];
      }
    }
    ContactSolver::Positions wanted = positions;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      if (!chosen[v] || count[v] == 0 || !(normal[v].norm() > 0)) continue;
      wanted[v] += 0.3 * (middle[v] / count[v] - positions[v]) + 0.1 * length[v] / count[v] * normal[v].normalized();
    }
    ContactSolver::Positions relaxed = solver_.approach(before_, wanted);
    if (solver_.encloses_all(before_, relaxed)) solver_.commit(std::move(relaxed));
  }

  void describe_failure(double way) {
    char text[200];
    if (solver_.jammed().empty()) {
      std::snprintf(text, sizeof text, "the re-inflation stopped at %.0f %% of the way", 100 * way);
    } else {
      const auto& face = solver_.face(static_cast<std::size_t>(solver_.jammed().front()));
      const Point p = request_.origin + solver_.positions()[face[0]];
      std::snprintf(text, sizeof text,
                    "the re-inflation is pinched at %.0f %% of the way: %zu faces of the cage jam near (%g, %g, %g)",
                    100 * way, solver_.jammed().size(), p.x(), p.y(), p.z());
    }
    result_.failure = text;
  }

  ContactSolver& solver_;
  const ReinflateRequest& request_;
  Obstacle before_;
  Obstacle after_;
  double first_step_ = 1;
  ReinflateResult result_;
};

}  // namespace

ReinflateResult reinflate(ContactSolver& solver, const ReinflateRequest& request, const Obstacle& home) {
  return Reinflation(solver, request, home).run();
}

}  // namespace encage::makers
