// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/assets/measure.h"

#include "bench/common/clock.h"
#include "bench/common/statistics.h"
#include "src/files/hash.h"

#include <encage/error.h>
#include <encage/world.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace encage::assets {
namespace {

std::vector<ShapePtr> load(const Way& way, const std::vector<std::filesystem::path>& files,
                           std::optional<ShapeCache>& cache) {
  if (way.budget > 0) cache.emplace(ShapeCacheOptions{way.budget, way.mode});
  std::vector<ShapePtr> shapes;
  shapes.reserve(files.size());
  for (const auto& file : files) shapes.push_back(cache ? cache->load(file) : load_shape(file, {}, way.mode));
  return shapes;
}

/// Asks what meets in a step, and keeps a hash of all that is found.
class Asker {
 public:
  Asker(const std::vector<ShapePtr>& shapes, const DriftScene& scene, double margin) : scene_(scene) {
    options_.pair.margin = margin;
    for (const Motion& motion : scene.motions()) {
      bodies_.push_back(world_.add_body(world_.add_shape(shapes[bodies_.size()]), motion.start));
    }
  }

  CandidateStatistics ask(bool triangles = false) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) world_.set_motion(bodies_[i], scene_.motions()[i]);
    options_.triangles = triangles;
    met_.clear();
    return world_.find_candidates(options_, [&](const CandidatePair& pair) {
      met_.emplace_back(static_cast<std::size_t>(pair.a), static_cast<std::size_t>(pair.b));
      if (triangles) hasher_.add(std::as_bytes(pair.triangles));
    });
  }

  std::span<const std::pair<std::size_t, std::size_t>> met() const { return met_; }
  /// Outside of what is timed.
  void hash_met() {
    hasher_.add(std::as_bytes(std::span(met_)));
    count_ += std::ssize(met_);
  }
  Hash hash() const { return hasher_.digest(); }
  std::int64_t count() const { return count_; }

 private:
  const DriftScene& scene_;
  World world_;
  CandidateOptions options_;
  std::vector<BodyId> bodies_;
  std::vector<std::pair<std::size_t, std::size_t>> met_;
  Hasher hasher_;
  std::int64_t count_ = 0;
};

}  // namespace

nlohmann::ordered_json run_way(const Way& way, const std::vector<std::filesystem::path>& files,
                               const AssetRunOptions& options) {
  constexpr int between_triangles = 50, between_samples = 10;  // steps
  if (options.cold) bench::drop_from_cache(files);
  DriftScene scene(options.scene);

  const bench::Stopwatch watch;
  std::optional<ShapeCache> cache;
  const std::vector<ShapePtr> shapes = load(way, files, cache);
  const double load_ms = watch.milliseconds();
  Asker asker(shapes, scene, options.margin);
  asker.ask();
  const double first_ms = watch.milliseconds();
  const bench::ResidentMemory first = bench::resident_memory();

  std::vector<double> times;
  bench::ResidentMemory most;
  std::int64_t near = 0;
  for (int step = 1; step < options.steps; ++step) {
    asker.hash_met();
    if (step % between_triangles == 0) asker.ask(true);
    scene.advance(asker.met());
    const bench::Stopwatch asking;
    const CandidateStatistics counts = asker.ask();
    times.push_back(asking.milliseconds());
    near += counts.overlapping - counts.separated[0];
    if (step % between_samples != 0 && step + 1 != options.steps) continue;
    const bench::ResidentMemory now = bench::resident_memory();
    if (now.total > most.total) most = now;
  }
  asker.hash_met();
  double sum = 0;
  for (const double time : times) sum += time;
  nlohmann::ordered_json json = {{"name", way.name},
                                 {"load_ms", load_ms},
                                 {"first_answer_ms", first_ms},
                                 {"step_ms", sum / static_cast<double>(times.size())},
                                 {"step_ms_median", bench::median(times)},
                                 {"step_ms_worst", *std::max_element(times.begin(), times.end())},
                                 {"first_resident_bytes", first.total},
                                 {"resident_bytes", most.total},
                                 {"anonymous_bytes", most.anonymous},
                                 {"file_bytes", most.file},
                                 {"near_pairs_per_step", static_cast<double>(near) / static_cast<double>(times.size())},
                                 {"candidates_per_step", static_cast<double>(asker.count()) / options.steps},
                                 {"answers", to_string(asker.hash())}};
  if (cache) {
    const ShapeCacheStatistics s = cache->statistics();
    json.update({{"budget_bytes", way.budget},
                 {"fine_resident_bytes", s.resident_bytes},
                 {"fine_peak_bytes", s.peak_bytes},
                 {"faults", s.faults},
                 {"evictions", s.evictions}});
  }
  return json;
}

}  // namespace encage::assets
