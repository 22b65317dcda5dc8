// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"

#include <encage/asset.h>
#include <encage/distance.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

namespace encage::micro {
namespace {

/// The fine mesh in the body frame, in waves as long as its diagonal and 5 % of that high.
TriangleMesh bent(const CageHierarchy& hierarchy) {
  TriangleMesh mesh = hierarchy.fine;
  const double size = hierarchy.diagonal;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Eigen::Vector3d p = mesh.vertices.row(v).transpose();
    const Eigen::Vector3d turns = 2 * std::numbers::pi / size * p;
    const Eigen::Vector3d wave(std::sin(turns.y()), std::sin(turns.z()), std::sin(turns.x()));
    mesh.vertices.row(v) = (p + 0.05 * size * wave + hierarchy.origin).transpose();
  }
  return mesh;
}

}  // namespace

void add_refits(const Workload& w) {
  const CageHierarchy hierarchy = read_asset(w.asset);
  if (hierarchy.fine.triangles.rows() == 0) return;
  const auto mesh = std::make_shared<const TriangleMesh>(bent(hierarchy));
  const ShapePtr straight = load_shape(w.asset), anew = make_shape(*mesh),
                 refitted = refit_shape(*straight, mesh->vertices);
  const auto count = mesh->triangles.rows();
  benchmark::RegisterBenchmark("refit/make_shape", [mesh, count](benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(make_shape(*mesh));
    state.SetItemsProcessed(state.iterations() * count);
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("refit/refit_shape", [mesh, straight, count](benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(refit_shape(*straight, mesh->vertices));
    state.SetItemsProcessed(state.iterations() * count);
  })->Unit(benchmark::kMillisecond);
  // Cages and all, and the fine mesh alone, as refit_shape() takes it.
  for (const auto& [name, shape] : {std::pair{"with_cages", straight}, std::pair{"fine_mesh", refitted}}) {
    benchmark::RegisterBenchmark((std::string("refit/scale_shape/") + name).c_str(), [shape = shape,
                                                                                      count](benchmark::State& state) {
      for (auto _ : state) benchmark::DoNotOptimize(scale_shape(*shape, {1.5, -1, 0.7}));
      state.SetItemsProcessed(state.iterations() * count);
    })->Unit(benchmark::kMillisecond);
  }
  for (const auto& [name, shape] : {std::pair{"anew", anew}, std::pair{"refitted", refitted}}) {
    const std::string of = name;
    add("refit/separated/" + of, w.cases, [shape = shape](const Case& c) {
      return separated(*shape, c.a, *shape, c.b, {.cages = CageUse::never}).separated;
    });
    add("refit/distance/" + of, w.cases,
        [shape = shape](const Case& c) { return encage::distance(*shape, c.a, *shape, c.b).upper; });
    add("refit/candidates/" + of, w.cases, [shape = shape](const Case& c) {
      int found = 0;
      for_each_triangle_pair(*shape, c.a, *shape, c.b, 0, [&](TrianglePair) {
        ++found;
        return true;
      });
      return found;
    });
  }
}

}  // namespace encage::micro
