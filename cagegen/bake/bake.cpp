// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/chain.h"
#include "cagegen/bake/coarse_meshes.h"
#include "cagegen/bake/level_maker.h"
#include "cagegen/bake/options.h"
#include "cagegen/certify/cage_distance.h"
#include "cagegen/threads/parallel.h"
#include "src/mesh/rounding.h"

#include <encage/bake.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace encage {

namespace {

/// Everything but the levels.
CageHierarchy describe_source(const SourceMesh& source, bool keep_fine) {
  CageHierarchy result;
  result.origin = source.origin;
  result.solid = source.solid;
  result.source_hash = source.hash;
  result.source_volume = source.volume;
  result.diagonal = source.diagonal;
  result.cap_count = source.cap_count;
  TriangleMesh fine = source.obstacle;
  result.fine_error = round_vertices(fine);
  if (keep_fine) result.fine = std::move(fine);
  return result;
}

std::vector<LevelTarget> targets(const std::vector<std::int64_t>& faces, const std::vector<TriangleMesh>& coarse) {
  std::vector<LevelTarget> result;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    result.push_back({faces[i], coarse.empty() ? nullptr : &coarse[i], faces.size() - 1 - i});
  }
  return result;
}

std::string list(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (const std::int64_t number : numbers) text += (text.empty() ? "" : ", ") + std::to_string(number);
  return text;
}

/// Writes into `failure` and `missing` what was asked for and is not there.
void report_missing(const BakeOptions& options, const Chain& chain, BakeReport& report) {
  report.failure = chain.failure;
  for (const LevelTarget& target : chain.missing) report.missing.push_back(target.faces);
  if (!report.failure.empty()) return;
  if (!report.missing.empty()) {
    report.failure = "the time limit leaves out levels of " + list(report.missing) + " faces";
  } else if (const auto wanted = static_cast<std::size_t>(options.level_count.value_or(0));
             options.keep_partial && chain.levels.size() < wanted) {
    report.failure = "only " + std::to_string(chain.levels.size()) + " of " + std::to_string(wanted) +
                     " levels: each has fewer faces than the one before";
  }
}

}  // namespace

CageHierarchy bake(const SourceMesh& source, const BakeOptions& options, const BakeContext& context,
                   BakeReport* report) {
  const auto start = std::chrono::steady_clock::now();
  validate(options);
  const std::vector<TriangleMesh> coarse = local_coarse_meshes(options, source);
  const std::vector<std::int64_t> faces = level_faces(options, source, context.log);
  CageHierarchy result = describe_source(source, options.keep_fine);
  result.options = options_json(options, faces);

  LevelMaker maker(source, options, context);
  Chain chain = make_chain(maker, targets(faces, coarse));
  BakeReport measured;
  report_missing(options, chain, measured);
  if (!chain.failure.empty()) {
    if (report != nullptr) *report = measured;
    if (!options.keep_partial || chain.levels.empty()) throw Error(chain.failure);
  }
  if (!measured.failure.empty() && context.log) {
    context.log((chain.failure.empty() ? "" : "only the levels before are kept: ") + measured.failure);
  }
  for (const std::string& message : chain.skipped) {
    if (context.log) context.log(message);
  }
  const proof::DistanceSurface surface(source.obstacle);
  makers::for_each_task(maker.threads(), chain.levels.size(), [&](std::size_t i) {
    CageLevel& level = chain.levels[i].level;
    const DistanceBounds distances = proof::distance_bounds(surface, level.mesh);
    level.certificate.max_distance = distances.max_distance;
    level.certificate.mean_distance = distances.mean_distance;
  });
  for (MadeLevel& made : chain.levels) {
    result.levels.push_back(std::move(made.level));
    measured.levels.push_back(made.times);
  }
  result.truncated = maker.out_of_time();
  measured.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (report != nullptr) *report = std::move(measured);
  return result;
}

CageHierarchy bake(const TriangleMesh& input, const BakeOptions& options, const BakeContext& context,
                   BakeReport* report) {
  validate(options);
  return bake(sanitize(input), options, context, report);
}

}  // namespace encage
