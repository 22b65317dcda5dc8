// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/stress/run.h"

#include "cagegen/cli/usage.h"
#include "cagegen/render/levels.h"
#include "cagegen/render/render.h"

#include <encage/error.h>

#include <algorithm>
#include <span>

namespace encage::stress {

namespace {

double excess(double volume, double before) { return before > 0 ? volume / before - 1 : 0; }

/// Returns the excess of one cage with that many faces around a mesh; no value if none can be made.
std::optional<double> single_excess(const TriangleMesh& inner, std::int64_t faces, const Job& job, int threads) {
  BakeOptions options = job.options;
  options.faces = {faces};
  options.threads = threads;
  options.keep_fine = false;
  try {
    const CageHierarchy single = bake(inner, options);
    return *single.levels.front().certificate.volume_ratio - 1;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void draw(const std::filesystem::path& file, const SourceMesh& source, const CageHierarchy& cages) {
  std::vector<TriangleMesh> levels = {source.obstacle};
  for (const CageLevel& level : cages.levels) levels.push_back(level.mesh);
  const Eigen::AlignedBox3d box = bounds(levels.back());
  Eigen::Index axis = 0;
  box.sizes().minCoeff(&axis);
  render::Options options;
  options.width = 900;
  options.height = 640;
  options.cut = {static_cast<render::Axis>(axis), box.center()[axis]};
  std::vector<render::Item> items;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    items.push_back(
        {.mesh = &levels[i], .color = render::level_color(static_cast<int>(i)), .style = render::Style::section});
  }
  render::write_png(file, render::render(items, options));
}

}  // namespace

Outcome run(const Job& job, const std::filesystem::path& meshes, int threads, const std::filesystem::path& picture) {
  TriangleMesh mesh;
  if (!job.model.empty()) mesh = read_mesh(meshes / (job.model + ".off"));
  if (job.make) mesh = job.make(mesh);
  const SourceMesh source = sanitize(mesh);
  BakeOptions options = job.options;
  options.threads = threads;
  options.keep_partial = true;

  Outcome outcome;
  outcome.input_faces = mesh.triangles.rows();
  BakeReport report;
  CageHierarchy cages;
  const double start = tool::process_usage().cpu_seconds;
  try {
    cages = bake(source, options, {}, &report);
    outcome.failure = report.failure;
  } catch (const Error& error) {
    outcome.failure = error.what();
  }
  outcome.cpu_seconds = tool::process_usage().cpu_seconds - start;

  double before = source.volume;
  const TriangleMesh* inner = &source.clean;
  for (std::size_t i = 0; i < cages.levels.size(); ++i) {
    const CageLevel& level = cages.levels[i];
    const Certificate& proven = level.certificate;
    Layer layer;
    layer.faces = level.mesh.triangles.rows();
    layer.method = std::string(name(proven.method)) + " from " + proven.start;
    layer.volume_ratio = proven.volume_ratio;
    layer.excess = excess(proven.volume, before);
    if (job.beside_single) layer.single_excess = single_excess(*inner, layer.faces, job, threads);
    layer.clearance = proven.clearance / cages.diagonal;
    layer.genus = proven.genus;
    layer.seconds = report.levels[i].seconds;
    layer.quality = quality(level.mesh);
    outcome.layers.push_back(layer);
    before = proven.volume;
    inner = &level.mesh;
  }
  if (!picture.empty() && !cages.levels.empty()) draw(picture, source, cages);
  return outcome;
}

}  // namespace encage::stress
