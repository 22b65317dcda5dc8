// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/level_maker.h"

#include "cagegen/bake/coarse_meshes.h"
#include "cagegen/collapse/collapse_level.h"
#include "cagegen/flow/flow_level.h"
#include "cagegen/threads/run_reporting.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

namespace encage {

namespace {

using Clock = std::chrono::steady_clock;

/// When a time limit is over; never, if that lies beyond what the clock can count.
std::optional<Clock::time_point> deadline(const std::optional<double>& seconds) {
  constexpr double century = 3e9;  // seconds; the clock counts 292 years in nanoseconds
  if (!seconds || *seconds > century) return std::nullopt;
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
}

}  // namespace

LevelMaker::LevelMaker(const SourceMesh& source, const BakeOptions& options, const BakeContext& context)
    : source_(source), options_(options), context_(context) {
  threads_ = options.threads > 0 ? options.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  control_.cancel = context.cancel;
  control_.deadline = deadline(options.time_limit);
}

std::optional<MadeLevel> LevelMaker::make(const MadeLevel* finer, const LevelTarget& target,
                                          const LevelProgress& progress, std::string& failure) {
  const auto start = Clock::now();
  const std::string prefix = progress.chain.empty() ? "" : progress.chain + ": ";
  const std::string stage = prefix + std::to_string(target.faces) + " faces";
  const auto pass_on = [&] {
    journal_.pass_on([&](std::string_view message) {
      if (context_.trace) context_.trace(prefix + std::string(message));
    });
  };
  const bool may_give_up = progress.may_give_up && target.method == Method::flow;
  bool gave_up = false;
  control_.fraction = 0;
  MadeLevel made;
  failure.clear();
  try {
    run_reporting([&] { work(finer, target, made, failure); },
                  [&] {
                    pass_on();
                    // Work that starts anew, from another start or without a constraint, shows no step back.
                    shown_ = std::max(shown_, std::min(1.0, progress.done + progress.share * control_.fraction));
                    if (context_.progress) context_.progress(shown_, stage);
                    if (may_give_up && control_.expired()) control_.abandoned = gave_up = true;
                  },
                  [&] { control_.abandoned = true; });
  } catch (const Cancelled&) {
    pass_on();
    const bool asked = context_.cancel != nullptr && *context_.cancel;
    if (asked || !gave_up) throw;
    control_.abandoned = false;
    failure.clear();
    return std::nullopt;
  }
  pass_on();
  control_.abandoned = false;  // too late: the level was done before it noticed
  if (!failure.empty()) return std::nullopt;
  made.times.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return made;
}

void LevelMaker::work(const MadeLevel* finer, const LevelTarget& target, MadeLevel& made, std::string& failure) {
  makers::LevelRequest request;
  request.inner = finer != nullptr ? &finer->level.mesh : &source_.obstacle;
  request.clean = finer != nullptr ? &finer->level.mesh : &source_.clean;
  request.manifold = finer != nullptr || source_.manifold;
  request.origin = source_.origin;
  request.faces = target.faces;
  request.diagonal = source_.diagonal;
  request.clearance = options_.min_clearance * source_.diagonal;
  request.topology = options_.topology;
  request.threads = threads_;
  request.log = [&](std::string_view message) { journal_.add(std::string(message)); };
  const makers::Obstacle obstacle(*request.inner);
  try {
    makers::LevelResult result = make_by(target.method, obstacle, request, finer, target.coarse);
    made.level = {std::move(result.candidate.cage), std::move(result.certificate)};
    Certificate& certificate = made.level.certificate;
    // The collapse ends with the hull where nothing else holds.
    const bool hull = target.method == Method::collapse && result.candidate.start == "hull";
    certificate.method = hull ? Method::hull : target.method;
    certificate.start = std::move(result.candidate.start);
    if (source_.volume > 0) certificate.volume_ratio = certificate.volume / source_.volume;
    made.undeformed = std::move(result.undeformed);
    made.times.flow_seconds = result.flow_seconds;
    made.times.reinflate_seconds = result.reinflate_seconds;
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    failure = error.what();
  }
}

makers::LevelResult LevelMaker::make_by(Method method, const makers::Obstacle& obstacle,
                                        const makers::LevelRequest& request, const MadeLevel* finer,
                                        const TriangleMesh* coarse) {
  const Solid solid = finer != nullptr ? Solid::closed : source_.solid;
  const auto decide = [&](const makers::Candidate& candidate) { return accept(*request.inner, solid, candidate); };
  if (method == Method::hull) return makers::hull_level(obstacle, request, control_, decide);
  if (method == Method::collapse) return makers::collapse_level(obstacle, request, control_, decide);
  makers::FlowChoices choices;
  if (finer != nullptr && finer->undeformed.triangles.rows() > 0) choices.undeformed = &finer->undeformed;
  choices.coarse = coarse;
  choices.decimator = checked_decimator(options_.decimator, options_.decimator_name);
  choices.decimator_name = options_.decimator_name;
  choices.inflate = options_.energy_inflate ? options_.energy_inflate : step_energy();
  choices.final = options_.energy_final ? options_.energy_final : volume_energy();
  choices.path = options_.path;
  return makers::flow_level(obstacle, request, choices, control_, decide);
}

/// The one place where a candidate becomes a certified cage.
std::optional<Certificate> LevelMaker::accept(const TriangleMesh& inner, Solid solid,
                                              const makers::Candidate& candidate) {
  CertifyResult proof = certify(inner, solid, candidate.cage);
  if (!proof.holds) {
    journal_.add("candidate refused by the certificate: " + candidate.start + ": " + proof.reason);
    return std::nullopt;
  }
  if (options_.topology == Topology::keep && proof.certificate.no_new_handles == false) return std::nullopt;
  return std::move(proof.certificate);
}

}  // namespace encage
