// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/level_maker.h"

#include "cagegen/bake/level_work.h"
#include "cagegen/certify/connectivity.h"
#include "cagegen/decimate/planar_faces.h"
#include "cagegen/sanitize/union_surface.h"
#include "cagegen/threads/run_reporting.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace encage {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double planar_tolerance = 1e-6;  // diagonals; a tenth of the usual clearance
constexpr double widest_room = 2e-3;       // diagonals between parts of a level, for the coarser levels
// Up to so many faces the starts, of so many times the faces, are better the fewer triangles planes have.
constexpr std::int64_t few_faces = 150, start_faces = 8;

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
  LevelJob job;
  makers::LevelRequest& request = job.request;
  request.inner = finer != nullptr ? &finer->level.mesh : &source_.obstacle;
  request.clean = finer != nullptr ? &finer->level.mesh : &source_.clean;
  request.manifold = finer != nullptr || source_.manifold;
  std::optional<TriangleMesh> united, merged;
  if (finer == nullptr && source_.solid == Solid::closed && target.coarse == nullptr) {
    // Surfaces that cages can be made of with less: parts that overlap, and planes of more triangles than they need.
    if ((united = io::union_surface(source_.clean, [&] { control_.throw_if_cancelled(); }))) {
      request.clean = &*united;
      request.manifold = true;
    }
    if (request.manifold && request.clean->triangles.rows() > target.faces) {
      const std::int64_t most = (target.faces <= few_faces ? start_faces : 1) * target.faces;
      merged = makers::merge_planar_faces(*request.clean, planar_tolerance * source_.diagonal, most);
      if (merged) request.clean = &*merged;
    }
  }
  request.origin = source_.origin;
  request.faces = target.faces;
  request.diagonal = source_.diagonal;
  request.clearance = options_.min_clearance * source_.diagonal;
  // Large clearances leave no room for as many more between parts of the mesh.
  request.self_clearance =
      std::min(makers::self_clearances_of_a_level * static_cast<double>(1 + target.coarser) * request.clearance,
               std::max(request.clearance, widest_room * source_.diagonal));
  request.topology = options_.topology;
  request.threads = threads_;
  request.log = [&](std::string_view message) { journal_.add(std::string(message)); };
  job.solid = finer != nullptr ? Solid::closed : source_.solid;
  job.coarse = target.coarse;
  if (finer != nullptr && finer->undeformed.triangles.rows() > 0) job.undeformed = &finer->undeformed;
  if (finer != nullptr) {
    job.genus = finer->level.certificate.genus;
  } else if (request.manifold && options_.topology != Topology::any) {
    job.genus = proof::connectivity(*request.clean).genus;
  }
  job.expendable = finer != nullptr;

  LevelWork work(job, options_, journal_, control_);
  const std::string stage = std::to_string(target.faces) + " faces";
  std::optional<LevelWork::Result> result;
  failure.clear();
  const auto run = [&] {
    try {
      result = work.run();
      failure = work.failure();
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      failure = error.what();
    }
  };
  const auto report = [&] {
    journal_.pass_on(context_.trace);
    // Work that starts anew, from another start or without a constraint, shows no step back.
    shown_ = std::max(shown_, std::min(1.0, progress.done + progress.share * work.fraction()));
    if (context_.progress) context_.progress(shown_, stage);
    if (control_.expired()) work.time_is_up();
  };
  run_reporting(run, report, [&] { control_.abandoned = true; });
  journal_.pass_on(context_.trace);
  if (!result) return std::nullopt;

  MadeLevel made;
  made.level = {std::move(result->candidate.cage), std::move(result->certificate)};
  Certificate& certificate = made.level.certificate;
  certificate.method = result->candidate.method;
  certificate.start = std::move(result->candidate.start);
  if (source_.volume > 0) certificate.volume_ratio = certificate.volume / source_.volume;
  made.undeformed = std::move(result->candidate.undeformed);
  made.times.flow_seconds = result->candidate.flow_seconds;
  made.times.reinflate_seconds = result->candidate.reinflate_seconds;
  made.times.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return made;
}

}  // namespace encage
