// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/assets/measure.h"

#include "src/files/hash.h"

#include <encage/error.h>
#include <encage/world.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace encage::assets {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); }

/// Pages that no process has mapped leave the system's cache.
void forget(const std::vector<std::filesystem::path>& files) {
  for (const auto& file : files) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) continue;
    fdatasync(descriptor);
    posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
    close(descriptor);
  }
}

/// Of /proc/self/status, in bytes.
struct Memory {
  std::int64_t total = 0, anonymous = 0, file = 0;
};

Memory memory_now() {
  std::ifstream status("/proc/self/status");
  std::int64_t total = 0, anonymous = 0, file = 0;
  for (std::string line; std::getline(status, line);) {
    const auto read = [&](const char* key, std::int64_t& bytes) {
      if (line.starts_with(key)) bytes = 1024 * std::stoll(line.substr(line.find(':') + 1));
    };
    read("VmRSS:", total);
    read("RssAnon:", anonymous);
    read("RssFile:", file);
  }
  return {total, anonymous, file};
}

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
  Asker(const std::vector<ShapePtr>& shapes, const Scene& scene, double margin) : scene_(scene) {
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
  const Scene& scene_;
  World world_;
  CandidateOptions options_;
  std::vector<BodyId> bodies_;
  std::vector<std::pair<std::size_t, std::size_t>> met_;
  Hasher hasher_;
  std::int64_t count_ = 0;
};

}  // namespace

nlohmann::ordered_json measure(const Way& way, const std::vector<std::filesystem::path>& files,
                               const MeasureOptions& options) {
  constexpr int between_triangles = 50, between_samples = 10;  // steps
  if (options.cold) forget(files);
  Scene scene(options.scene);

  const auto start = Clock::now();
  std::optional<ShapeCache> cache;
  const std::vector<ShapePtr> shapes = load(way, files, cache);
  const double load_ms = milliseconds(Clock::now() - start);
  Asker asker(shapes, scene, options.margin);
  asker.ask();
  const double first_ms = milliseconds(Clock::now() - start);
  const Memory first = memory_now();

  std::vector<double> times;
  Memory most;
  std::int64_t near = 0;
  for (int step = 1; step < options.steps; ++step) {
    asker.hash_met();
    if (step % between_triangles == 0) asker.ask(true);
    scene.advance(asker.met());
    const auto before = Clock::now();
    const CandidateStatistics counts = asker.ask();
    times.push_back(milliseconds(Clock::now() - before));
    near += counts.overlapping - counts.separated[0];
    if (step % between_samples != 0 && step + 1 != options.steps) continue;
    const Memory now = memory_now();
    if (now.total > most.total) most = now;
  }
  asker.hash_met();
  double sum = 0;
  for (const double time : times) sum += time;
  std::sort(times.begin(), times.end());
  nlohmann::ordered_json json = {{"name", way.name},
                                 {"load_ms", load_ms},
                                 {"first_answer_ms", first_ms},
                                 {"step_ms", sum / static_cast<double>(times.size())},
                                 {"step_ms_median", times[times.size() / 2]},
                                 {"step_ms_worst", times.back()},
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
