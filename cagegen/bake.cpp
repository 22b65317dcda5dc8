// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/bake.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "cagegen/collapse/cage_editor.h"
#include "cagegen/collapse/level.h"
#include "cagegen/geometry/rounding.h"

namespace encage {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

void validate(const BakeOptions& options) {
  if (!options.faces.empty() && (options.ratio || options.level_count)) {
    throw Error("bake options: faces and ratio/levels exclude each other");
  }
  for (const std::int64_t faces : options.faces) {
    if (faces < 4)
      throw Error("bake options: a level of " + std::to_string(faces) + " faces; a closed surface needs 4");
  }
  if (options.ratio && !(*options.ratio > 0 && *options.ratio < 1)) {
    throw Error("bake options: ratio " + std::to_string(*options.ratio) + " is not between 0 and 1");
  }
  if (options.level_count && *options.level_count < 1) {
    throw Error("bake options: " + std::to_string(*options.level_count) + " levels; at least 1 is needed");
  }
  if (!(options.min_clearance > 0 && options.min_clearance < 0.1)) {
    throw Error("bake options: minimum clearance " + std::to_string(options.min_clearance) +
                " is not between 0 and 0.1 diagonals");
  }
  if (options.threads < 0) throw Error("bake options: " + std::to_string(options.threads) + " threads");
  if (options.time_limit && !(*options.time_limit > 0)) throw Error("bake options: the time limit must be positive");
}

/// Faces per level, fine to coarse, as asked for.
std::vector<std::int64_t> wanted_levels(const BakeOptions& options, std::int64_t source_faces) {
  if (!options.faces.empty()) return options.faces;
  std::vector<std::int64_t> levels;
  if (options.ratio || options.level_count) {
    // The paper's choice: seven levels, each 2^(-2/3) of the one before.
    const double ratio = options.ratio.value_or(0.62996052494743658);
    double faces = static_cast<double>(source_faces);
    for (int i = 0; i < options.level_count.value_or(7); ++i) {
      faces *= ratio;
      levels.push_back(std::max<std::int64_t>(4, static_cast<std::int64_t>(faces)));
    }
    return levels;
  }
  for (std::int64_t faces = std::clamp<std::int64_t>(source_faces / 10, 100, 8000); faces >= 100; faces /= 4) {
    levels.push_back(faces);
  }
  return levels;
}

/// Leaves out levels that are not coarser than the one before.
std::vector<std::int64_t> useful_levels(const std::vector<std::int64_t>& wanted, std::int64_t source_faces,
                                        const BakeContext& context) {
  std::vector<std::int64_t> levels;
  std::int64_t before = source_faces;
  for (const std::int64_t faces : wanted) {
    if (faces < before) {
      levels.push_back(faces);
      before = faces;
    } else if (context.log) {
      context.log("level of " + std::to_string(faces) + " faces skipped: the one before has " + std::to_string(before));
    }
  }
  return levels;
}

std::string options_json(const BakeOptions& options, const std::vector<std::int64_t>& levels) {
  static constexpr const char* topologies[] = {"any", "keep", "simplify"};
  nlohmann::json json;
  json["faces"] = levels;
  json["method"] = options.method == BakeMethod::automatic ? "auto" : "collapse";
  json["min_clearance"] = options.min_clearance;
  json["topology"] = topologies[static_cast<int>(options.topology)];
  return json.dump();
}

TriangleMesh round_to_float(const TriangleMesh& mesh, double& error) {
  TriangleMesh rounded = mesh;
  error = 0;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    const auto id = static_cast<std::int32_t>(v);
    rounded.vertices.row(v) = makers::round_to_float(mesh.vertex(id)).transpose();
    error = std::max(error, (rounded.vertex(id) - mesh.vertex(id)).norm());
  }
  error *= 1 + 1e-12;  // the norm itself is rounded
  return rounded;
}

/// Runs `work` on a thread of its own while this one reports progress. If `report` throws,
/// `abandon` asks the work to end.
void run_reporting(const std::function<void()>& work, const std::function<void()>& report,
                   const std::function<void()>& abandon) {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::exception_ptr error;
  std::thread worker([&] {
    try {
      work();
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    changed.notify_one();
  });
  try {
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, std::chrono::milliseconds(80), [&] { return done; })) {
      lock.unlock();
      report();
      lock.lock();
    }
  } catch (...) {
    abandon();
    worker.join();
    throw;
  }
  worker.join();
  if (error) std::rethrow_exception(error);
}

/// The work of one bake, level by level.
class Baker {
 public:
  Baker(const SourceMesh& source, const BakeOptions& options, const BakeContext& context)
      : source_(source), options_(options), context_(context) {
    threads_ =
        options.threads > 0 ? options.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    control_.cancel = context.cancel;
    if (options.time_limit) {
      control_.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(*options.time_limit));
    }
  }

  CageHierarchy run(BakeReport* report) {
    const auto start = Clock::now();
    const std::int64_t source_faces = source_.clean.triangles.rows();
    std::vector<std::int64_t> levels = useful_levels(wanted_levels(options_, source_faces), source_faces, context_);
    CageHierarchy result;
    result.origin = source_.origin;
    result.solid = source_.solid;
    result.source_hash = source_.hash;
    result.source_volume = source_.volume;
    result.diagonal = source_.diagonal;
    result.options = options_json(options_, levels);
    result.cap_count = source_.cap_count;
    const TriangleMesh fine = round_to_float(source_.obstacle, result.fine_error);
    if (options_.keep_fine) result.fine = fine;
    const bool too_small = levels.empty();
    if (too_small) levels.push_back(std::max<std::int64_t>(4, source_faces));
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const auto level_start = Clock::now();
      if (i > 0 && control_.expired()) break;
      const TriangleMesh* finer = result.levels.empty() ? nullptr : &result.levels.back().mesh;
      stage_ = std::to_string(levels[i]) + " faces";
      done_ = static_cast<double>(i) / static_cast<double>(levels.size());
      share_ = 1.0 / static_cast<double>(levels.size());
      control_.fraction = 0;
      result.levels.push_back(make_level(finer, levels[i], too_small));
      // One level may come out with fewer faces than asked for, even fewer than the next.
      if (report != nullptr) report->levels.push_back({seconds_since(level_start)});
      while (i + 1 < levels.size() && levels[i + 1] >= result.levels.back().mesh.triangles.rows()) {
        if (context_.log)
          context_.log("level of " + std::to_string(levels[i + 1]) + " faces skipped: the one before is as coarse");
        ++i;
      }
    }
    result.truncated = control_.out_of_time;
    if (report != nullptr) report->seconds = seconds_since(start);
    return result;
  }

 private:
  CageLevel make_level(const TriangleMesh* finer, std::int64_t faces, bool hull) {
    const TriangleMesh& inner = finer != nullptr ? *finer : source_.obstacle;
    const Solid solid = finer != nullptr ? Solid::closed : source_.solid;
    makers::LevelRequest request;
    request.clean = finer != nullptr ? finer : &source_.clean;
    request.manifold = finer != nullptr || source_.manifold;
    request.faces = faces;
    request.diagonal = source_.diagonal;
    request.clearance = options_.min_clearance * source_.diagonal;
    request.topology = options_.topology;
    request.hull_only = hull;
    request.threads = threads_;
    CageLevel level;
    run_reporting(
        [&] {
          const makers::Obstacle obstacle(inner);
          const auto accept = [&](const makers::Candidate& candidate) {
            const CertifyResult proof = certify(inner, solid, candidate.cage);
            if (!proof.holds) {
              refusals_.push_back(candidate.start + ": " + proof.reason);
              return false;
            }
            if (options_.topology == Topology::keep && proof.certificate.no_new_handles == false) return false;
            level.certificate = proof.certificate;
            return true;
          };
          makers::Candidate best = makers::build_level(obstacle, request, control_, accept);
          level.mesh = std::move(best.cage);
          level.certificate.method = best.start == "hull" ? Method::hull : Method::collapse;
          level.certificate.start = best.start;
        },
        [&] {
          // Work that starts anew, from another start or without a constraint, shows no step back.
          shown_ = std::max(shown_, std::min(1.0, done_ + share_ * control_.fraction));
          if (context_.progress) context_.progress(shown_, stage_);
        },
        [&] { control_.abandoned = true; });
    for (const std::string& refusal : refusals_) {
      if (context_.log) context_.log("candidate refused by the certificate: " + refusal);
    }
    refusals_.clear();
    if (source_.volume > 0) level.certificate.volume_ratio = level.certificate.volume / source_.volume;
    return level;
  }

  const SourceMesh& source_;
  const BakeOptions& options_;
  const BakeContext& context_;
  makers::Control control_;
  int threads_ = 1;
  std::string stage_;
  double done_ = 0;
  double shown_ = 0;
  double share_ = 1;
  std::vector<std::string> refusals_;
};

}  // namespace

CageHierarchy bake(const SourceMesh& source, const BakeOptions& options, const BakeContext& context,
                   BakeReport* report) {
  validate(options);
  return Baker(source, options, context).run(report);
}

CageHierarchy bake(const TriangleMesh& input, const BakeOptions& options, const BakeContext& context,
                   BakeReport* report) {
  validate(options);
  return bake(sanitize(input), options, context, report);
}

}  // namespace encage
