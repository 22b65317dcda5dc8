// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"
#include "oracles/meshes.h"

#include <encage/height_field.h>
#include <encage/queries.h>
#include <encage/shape_mesh.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace encage::micro {
namespace {

/// Hills of several sizes over samples that are 1 apart.
std::vector<float> hills(std::int32_t side) {
  std::vector<float> heights;
  heights.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (std::int32_t j = 0; j < side; ++j) {
    for (std::int32_t i = 0; i < side; ++i) {
      const double x = i, y = j;
      heights.push_back(static_cast<float>(9 * std::sin(0.021 * x) * std::cos(0.017 * y) +
                                           2 * std::sin(0.13 * x + 0.1 * y) + 0.3 * std::sin(1.1 * x) * std::sin(y)));
    }
  }
  return heights;
}

ShapePtr field_of(const std::vector<float>& heights, std::int32_t side, std::int64_t budget) {
  return make_height_field({.heights = heights, .columns = side, .rows = side}, {.budget_bytes = budget});
}

constexpr std::int32_t side = 512;

/// A field, the same triangles as a mesh, and rays that come from above in all directions. Made when it is needed.
struct Terrain {
  ShapePtr tiles, mesh;
  std::vector<Ray> rays;

  Terrain() {
    const std::vector<float> heights = hills(side);
    tiles = field_of(heights, side, std::int64_t{64} << 20);
    TriangleMesh triangles;
    triangles.vertices.resize(side * side, 3);
    for (std::int32_t v = 0; v < side * side; ++v) {
      triangles.vertices.row(v) << v % side, v / side, static_cast<double>(heights[static_cast<std::size_t>(v)]);
    }
    triangles.triangles.resize(2 * (side - 1) * (side - 1), 3);
    std::int32_t t = 0;
    for (std::int32_t j = 0; j + 1 < side; ++j) {
      for (std::int32_t i = 0; i + 1 < side; ++i) {
        const std::int32_t a = j * side + i, b = a + 1, c = b + side, d = a + side;
        triangles.triangles.row(t++) << a, b, c;
        triangles.triangles.row(t++) << a, c, d;
      }
    }
    mesh = make_shape(triangles, {.hollow = true});
    shapes::Random random(7);
    for (int i = 0; i < 4096; ++i) {
      rays.push_back({.origin = {random(0, side), random(0, side), random(12, 40)},
                      .direction = {random(-1, 1), random(-1, 1), random(-1, -0.05)}});
    }
  }
};

const Terrain& terrain() {
  static const Terrain made;
  return made;
}

void cast_all(benchmark::State& state, ShapePtr Terrain::*shape) {
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  for (const Ray& ray : terrain().rays) cast_ray(*(terrain().*shape), rest, ray);  // makes the tiles
  ask_in_turn(state, terrain().rays, [&](const Ray& ray) { return cast_ray(*(terrain().*shape), rest, ray).hit.t; });
}

}  // namespace

void add_fields() {
  benchmark::RegisterBenchmark("field/make", [](benchmark::State& state) {
    constexpr std::int32_t large = 2048;
    const std::vector<float> heights = hills(large);
    ShapePtr shape;
    for (auto _ : state) shape = field_of(heights, large, std::int64_t{64} << 20);
    state.SetItemsProcessed(state.iterations());
    state.counters["bytes_a_sample"] = static_cast<double>(memory_use(*shape).owned) / (double{large} * large);
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("field/tile", [](benchmark::State& state) {
    // Room for two tiles, each asked in turn.
    const ShapePtr shape = field_of(hills(side), side, 400'000);
    std::int64_t part = 0;
    for (auto _ : state) {
      benchmark::DoNotOptimize(fine_mesh(*shape_part(*shape, part).shape).vertices.data());
      part = (part + 1) % part_count(*shape);
    }
    state.SetItemsProcessed(state.iterations());
  })->Unit(benchmark::kMicrosecond);
  benchmark::RegisterBenchmark("field/ray/tiles", [](benchmark::State& state) { cast_all(state, &Terrain::tiles); });
  benchmark::RegisterBenchmark("field/ray/mesh", [](benchmark::State& state) { cast_all(state, &Terrain::mesh); });
}

}  // namespace encage::micro
