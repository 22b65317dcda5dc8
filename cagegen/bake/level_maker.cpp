// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/level_maker.h"

#include "cagegen/bake/coarse_meshes.h"
#include "cagegen/bake/run_reporting.h"
#include "cagegen/collapse/level.h"
#include "cagegen/nested/nested_level.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

namespace encage {

namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

/// Decides about the candidates of one level by the certificate, and keeps it for the one that is returned.
class LevelMaker::Proof {
 public:
  Proof(const TriangleMesh& inner, Solid solid, const BakeOptions& options, Journal& journal)
      : inner_(inner), solid_(solid), options_(options), journal_(journal) {}

  bool accept(const makers::Candidate& candidate) {
    CertifyResult proof = certify(inner_, solid_, candidate.cage);
    if (!proof.holds) {
      journal_.add("candidate refused by the certificate: " + candidate.start + ": " + proof.reason);
      return false;
    }
    if (options_.topology == Topology::keep && proof.certificate.no_new_handles == false) return false;
    accepted_.emplace_back(candidate.cage.vertices, std::move(proof.certificate));
    return true;
  }

  CageLevel level(makers::Candidate candidate, Method method, double source_volume) const {
    const auto found = std::find_if(accepted_.begin(), accepted_.end(), [&](const auto& entry) {
      return entry.first.rows() == candidate.cage.vertices.rows() && entry.first == candidate.cage.vertices;
    });
    assert(found != accepted_.end());
    CageLevel level{std::move(candidate.cage), found->second};
    level.certificate.method = method;
    level.certificate.start = std::move(candidate.start);
    if (source_volume > 0) level.certificate.volume_ratio = level.certificate.volume / source_volume;
    return level;
  }

 private:
  const TriangleMesh& inner_;
  Solid solid_;
  const BakeOptions& options_;
  Journal& journal_;
  std::vector<std::pair<Vertices, Certificate>> accepted_;
};

LevelMaker::LevelMaker(const SourceMesh& source, const BakeOptions& options, const BakeContext& context)
    : source_(source), options_(options), context_(context) {
  threads_ = options.threads > 0 ? options.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  control_.cancel = context.cancel;
  if (options.time_limit) {
    control_.deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*options.time_limit));
  }
}

std::optional<MadeLevel> LevelMaker::make(const MadeLevel* finer, const LevelTarget& target,
                                          const LevelProgress& progress, std::string& failure) {
  const auto start = Clock::now();
  const std::string prefix = progress.chain.empty() ? "" : progress.chain + ": ";
  const std::string stage = prefix + std::to_string(target.faces) + " faces";
  const auto pass_on = [&] {
    journal_.pass_on([&](std::string_view message) {
      if (context_.log) context_.log(prefix + std::string(message));
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
  const TriangleMesh& inner = finer != nullptr ? finer->level.mesh : source_.obstacle;
  const makers::Obstacle obstacle(inner);
  Proof proof(inner, finer != nullptr ? Solid::closed : source_.solid, options_, journal_);
  try {
    if (target.method == Method::flow) {
      make_by_flow(obstacle, finer, target, proof, made, failure);
    } else {
      make_by_collapse(obstacle, finer, target, proof, made);
    }
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    failure = error.what();
  }
}

void LevelMaker::make_by_collapse(const makers::Obstacle& obstacle, const MadeLevel* finer, const LevelTarget& target,
                                  Proof& proof, MadeLevel& made) {
  makers::LevelRequest request;
  request.clean = finer != nullptr ? &finer->level.mesh : &source_.clean;
  request.manifold = finer != nullptr || source_.manifold;
  request.faces = target.faces;
  request.diagonal = source_.diagonal;
  request.clearance = options_.min_clearance * source_.diagonal;
  request.topology = options_.topology;
  request.hull_only = target.method == Method::hull;
  request.threads = threads_;
  makers::Candidate best = makers::build_level(
      obstacle, request, control_, [&](const makers::Candidate& candidate) { return proof.accept(candidate); });
  const Method method = best.start == "hull" ? Method::hull : Method::collapse;
  made.level = proof.level(std::move(best), method, source_.volume);
}

void LevelMaker::make_by_flow(const makers::Obstacle& obstacle, const MadeLevel* finer, const LevelTarget& target,
                              Proof& proof, MadeLevel& made, std::string& failure) {
  makers::NestedRequest request;
  request.inner = finer != nullptr ? &finer->level.mesh : &source_.obstacle;
  request.clean = finer != nullptr ? &finer->level.mesh : &source_.clean;
  request.manifold = finer != nullptr || source_.manifold;
  if (finer != nullptr && finer->undeformed.triangles.rows() > 0) request.undeformed = &finer->undeformed;
  request.coarse = target.coarse;
  request.decimator = checked_decimator(options_.decimator, options_.decimator_name);
  request.decimator_name = options_.decimator_name;
  request.origin = source_.origin;
  request.faces = target.faces;
  request.diagonal = source_.diagonal;
  request.clearance = options_.min_clearance * source_.diagonal;
  request.topology = options_.topology;
  request.inflate = options_.energy_inflate ? options_.energy_inflate : step_energy();
  request.final = options_.energy_final ? options_.energy_final : volume_energy();
  request.path = options_.path;
  request.threads = threads_;
  request.log = [&](std::string_view message) { journal_.add(std::string(message)); };
  auto result = makers::build_nested_level(
      obstacle, request, control_, [&](const makers::Candidate& candidate) { return proof.accept(candidate); },
      failure);
  if (!result) {
    if (failure.empty()) failure = "no coarse mesh could be nested";
    return;
  }
  failure.clear();
  made.level = proof.level(std::move(result->candidate), Method::flow, source_.volume);
  made.undeformed = std::move(result->undeformed);
  made.times.flow_seconds = result->flow_seconds;
  made.times.reinflate_seconds = result->reinflate_seconds;
}

}  // namespace encage
