// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/level_work.h"

#include "cagegen/bake/coarse_meshes.h"
#include "cagegen/collapse/collapse_maker.h"
#include "cagegen/collapse/starts.h"
#include "cagegen/flow/flow_maker.h"
#include "cagegen/threads/parallel.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <utility>

namespace encage {

namespace {

using makers::Candidate;

void start(makers::Control& control, const makers::Control& whole) {
  control.whole = &whole;
  control.deadline = whole.deadline;
}

/// Which candidates are finished before one is chosen, whose faces move then. With few faces it is hard to tell which
/// will be the tightest, and finishing is quick.
struct Finalists {
  std::size_t most;
  double excess;  ///< at most, in those of the tightest
};

constexpr double close_race = 1.05;  // excess up to which moving faces may make another finished candidate the tightest

Finalists finalists(std::int64_t faces) {
  if (faces <= 150) return {3, 1.25};
  if (faces <= 1000) return {2, 1.1};
  return {1, 1};
}

void sort_by_volume(auto first, auto last) {
  std::stable_sort(first, last, [](const auto& a, const auto& b) { return a.candidate.volume < b.candidate.volume; });
}

}  // namespace

LevelWork::LevelWork(const LevelJob& job, const BakeOptions& options, Journal& journal, const makers::Control& whole)
    : job_(job), options_(options), journal_(journal), collapse_request_(job.request), flow_request_(job.request) {
  // Only the flow can do with the user's meshes.
  flows_ = options.method != BakeMethod::collapse;
  collapses_ = options.method != BakeMethod::flow && job.coarse == nullptr;
  start(collapse_, whole);
  start(flow_, whole);
  const std::string prefix = flows_ && collapses_ ? "flow: " : "";
  flow_request_.log = [this, prefix](std::string_view message) { journal_.add(prefix + std::string(message)); };
}

std::vector<LevelWork::Maker> LevelWork::makers(const makers::Obstacle& obstacle) {
  const EnergyPtr inflate = options_.energy_inflate ? options_.energy_inflate : step_energy();
  const EnergyPtr final = options_.energy_final ? options_.energy_final : volume_energy();
  std::vector<Maker> makers;
  // Who brings meshes, or an energy other than the volume, wants just what comes of them.
  const bool for_volume = job_.coarse == nullptr && final == volume_energy();
  if (options_.topology != Topology::keep && (collapses_ || for_volume)) {
    makers.push_back({makers::convex_maker(obstacle, collapse_request_, collapse_), &collapse_, true});
  }
  if (collapses_) makers.push_back({makers::collapse_maker(obstacle, collapse_request_, collapse_), &collapse_});
  if (flows_ && !(collapses_ && makers::own_surface_suffices(job_.request))) {
    makers::FlowChoices choices;
    choices.undeformed = job_.undeformed;
    choices.coarse = job_.coarse;
    choices.decimator = checked_decimator(options_.decimator, options_.decimator_name);
    choices.decimator_name = options_.decimator_name;
    choices.inflate = inflate;
    choices.final = final;
    choices.path = options_.path;
    choices.competes = collapses_;
    makers.push_back({makers::flow_maker(obstacle, flow_request_, choices, flow_), &flow_});
  }
  return makers;
}

std::optional<LevelWork::Result> LevelWork::run() {
  const makers::Obstacle obstacle(*job_.request.inner);
  makers::WrapStarts wraps(obstacle, *job_.request.clean, job_.request.diagonal, job_.request.clearance);
  collapse_request_.wraps = flow_request_.wraps = &wraps;
  const std::vector<Maker> all = makers(obstacle);
  for (;;) {
    std::vector<Contender> contenders = next_batch(all);
    if (contenders.empty()) break;
    begin_finishing();
    if (auto result = tightest(std::move(contenders))) return result;
    finishing_ = false;
  }
  // The flow was stopped, and there need not be a level.
  if (gave_up_ || flow_.abandoned) return std::nullopt;
  failure_ = !failed_.empty()    ? failed_
             : !handles_.empty() ? handles_
             : refused_.empty()  ? all.back().maker->failure()
                                 : refused_ + ": the certificate refuses the cage";
  return std::nullopt;
}

std::vector<LevelWork::Contender> LevelWork::next_batch(const std::vector<Maker>& makers) {
  std::vector<std::vector<Candidate>> batches(makers.size());
  makers::for_each_task(job_.request.threads, makers.size(), [&](std::size_t m) {
    if (!makers[m].bounds_others) batches[m] = next_of(makers[m]);
  });
  // Convex cages only bound what the flow makes: they are no answer to who asked for the flow.
  if (!collapses_ && batches.back().empty()) return {};
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<Candidate>& batch : batches) {
    for (const Candidate& candidate : batch) least = std::min(least, candidate.volume);
  }
  for (std::size_t m = 0; m < makers.size(); ++m) {
    if (makers[m].bounds_others && makers[m].maker->least_volume() < least) batches[m] = next_of(makers[m]);
  }
  std::vector<Contender> contenders;
  for (std::size_t m = 0; m < makers.size(); ++m) {
    for (Candidate& candidate : batches[m]) contenders.push_back({std::move(candidate), makers[m].maker.get()});
  }
  return contenders;
}

/// The maker's next candidates; none if it is out of time or fails.
std::vector<Candidate> LevelWork::next_of(const Maker& maker) {
  if (maker.control == &flow_ && flow_.expired()) time_is_up();
  if (maker.control->abandoned) return {};
  try {
    return maker.maker->next();
  } catch (const Cancelled&) {
    if (!maker.control->abandoned || maker.control->whole->cancelled()) throw;
  } catch (const Error& error) {
    // A decimator or an energy of the user's threw it. Other makers may still make the level.
    const std::lock_guard lock(failed_mutex_);
    failed_ = error.what();
    if (flows_ && collapses_) journal_.add("level of " + std::to_string(job_.request.faces) + " faces: " + failed_);
  }
  return {};
}

std::optional<LevelWork::Result> LevelWork::tightest(std::vector<Contender> contenders) {
  sort_by_volume(contenders.begin(), contenders.end());
  finish_best(contenders);
  for (Contender& contender : contenders) {
    const Candidate unfinished = contender.candidate;
    if (!contender.finished) contender.maker->finish(contender.candidate);
    if (auto certificate = accept(contender.candidate)) return Result{std::move(contender.candidate), *certificate};
    if (contender.finished) continue;
    if (auto certificate = accept(unfinished)) return Result{unfinished, *certificate};
  }
  return std::nullopt;
}

void LevelWork::finish_best(std::vector<Contender>& contenders) {
  const double inside = std::max(0.0, signed_volume(*job_.request.inner));
  const auto [most, excess] = finalists(job_.request.faces);
  const double volume = inside + excess * (contenders.front().candidate.volume - inside);
  std::size_t count = 1;
  while (count < std::min(contenders.size(), most) && contenders[count].candidate.volume <= volume) ++count;
  makers::for_each_task(job_.request.threads, count, [&](std::size_t i) {
    contenders[i].maker->finish(contenders[i].candidate);
    contenders[i].finished = true;
  });
  const auto last = contenders.begin() + static_cast<std::ptrdiff_t>(count);
  sort_by_volume(contenders.begin(), last);
  const double close = inside + close_race * (contenders.front().candidate.volume - inside);
  const bool photo_finish = count > 1 && contenders[1].candidate.volume <= close;
  makers::for_each_task(job_.request.threads, photo_finish ? 2 : 1,
                        [&](std::size_t i) { contenders[i].maker->redistribute(contenders[i].candidate); });
  sort_by_volume(contenders.begin(), last);
}

/// The one place where a candidate becomes a certified cage.
std::optional<Certificate> LevelWork::accept(const Candidate& candidate) {
  CertifyResult proof = certify(*job_.request.inner, job_.solid, candidate.cage);
  if (!proof.holds) {
    refused_ = candidate.start;
    journal_.add("candidate refused by the certificate: " + candidate.start + ": " + proof.reason);
    return std::nullopt;
  }
  if (!topology_suits(proof.certificate, candidate)) return std::nullopt;
  return std::move(proof.certificate);
}

bool LevelWork::topology_suits(const Certificate& certificate, const Candidate& candidate) {
  if (options_.topology == Topology::any) return true;
  const bool keeps = options_.topology == Topology::keep;
  const bool suits = certificate.no_new_handles != false && !(keeps && job_.genus && certificate.genus != *job_.genus);
  if (!suits) {
    handles_ = "no cage of " + std::to_string(job_.request.faces) + " faces has " + (keeps ? "" : "at most ") +
               "genus " + std::to_string(job_.genus.value_or(0)) + ", that of the level before: the cage from " +
               candidate.start + " has genus " + std::to_string(certificate.genus);
    journal_.add("candidate refused: " + handles_);
  }
  return suits;
}

/// Candidates of a flow that was told to stop, but was done before it noticed, are finished as all others.
void LevelWork::begin_finishing() {
  const std::lock_guard lock(stage_mutex_);
  finishing_ = true;
  gave_up_ = gave_up_ || flow_.abandoned;
  flow_.abandoned = false;
}

void LevelWork::time_is_up() {
  const std::lock_guard lock(stage_mutex_);
  if (flows_ && !finishing_ && (job_.expendable || collapses_)) flow_.abandoned = true;
}

double LevelWork::fraction() const {
  constexpr double before_finish = 0.8;
  if (finishing_) return before_finish;
  const double sum = (collapses_ ? collapse_.fraction.load() : 0.0) + (flows_ ? flow_.fraction.load() : 0.0);
  return before_finish * sum / (static_cast<double>(collapses_) + static_cast<double>(flows_));
}

}  // namespace encage
