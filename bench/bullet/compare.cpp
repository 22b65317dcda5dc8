// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/compare.h"

#include "bench/common/report.h"
#include "bench/common/statistics.h"

#include <algorithm>
#include <array>
#include <memory>
#include <ostream>

namespace encage::bullet_bench {
namespace {

struct Kind {
  const char* name;
  Guard guard;
  BulletContacts contacts;
};

constexpr std::array<Kind, 4> kinds = {{{"Bullet", Guard::none, BulletContacts::all},
                                        {"adapter", Guard::adapter, BulletContacts::all},
                                        {"adapter, within margins", Guard::adapter, BulletContacts::within_margins},
                                        {"perfect", Guard::oracle, BulletContacts::all}}};

/// Milliseconds of the contestants in one run; counts go to `c`.
std::array<double, kinds.size()> run(const TriangleMesh& mesh, const ShapePtr& shape, BulletComparison& c) {
  std::vector<std::unique_ptr<OctopusWorld>> worlds;
  for (const Kind& kind : kinds) {
    worlds.push_back(std::make_unique<OctopusWorld>(mesh, shape, c.scene, kind.guard, kind.contacts));
  }
  std::array<double, kinds.size()> milliseconds{};
  for (int step = 0; step < c.steps; ++step) {
    milliseconds[0] += worlds[0]->step();
    const std::vector<ContactPoint> contacts = worlds[0]->contacts();
    const std::vector<float> transforms = worlds[0]->transforms();
    const std::set<TouchingPair> touching = worlds[0]->pairs_in_touch();
    for (const TouchingPair& pair : touching) {
      (pair.second < c.scene.bodies ? c.touching_meshes : c.touching_planes) += 1;
    }
    const auto [meshes, planes] = worlds[0]->pairs();
    c.mesh_pairs += meshes;
    c.plane_pairs += planes;
    for (std::size_t i = 1; i < kinds.size(); ++i) {
      milliseconds[i] += worlds[i]->step(touching);
      c.contestants[i].different_contacts += worlds[i]->contacts() != contacts;
      c.contestants[i].different_transforms += worlds[i]->transforms() != transforms;
    }
  }
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    c.contestants[i].asked = worlds[i]->statistics().asked;
    c.contestants[i].rejected = worlds[i]->statistics().rejected;
  }
  return milliseconds;
}

}  // namespace

bool BulletComparison::same() const {
  return std::all_of(contestants.begin(), contestants.end(),
                     [](const WorldResult& c) { return c.different_contacts == 0 && c.different_transforms == 0; });
}

BulletComparison compare(const TriangleMesh& mesh, const ShapePtr& shape, const BulletScene& scene, int steps,
                         int runs) {
  BulletComparison c;
  c.scene = scene;
  c.steps = steps;
  c.runs = runs;
  for (const Kind& kind : kinds) c.contestants.emplace_back().name = kind.name;
  std::array<std::vector<double>, kinds.size()> times;
  for (int r = 0; r < runs; ++r) {
    c.mesh_pairs = c.plane_pairs = c.touching_meshes = c.touching_planes = 0;
    const std::array<double, kinds.size()> milliseconds = run(mesh, shape, c);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      times[i].push_back(milliseconds[i] / steps);
      c.contestants[i].ratios.push_back(milliseconds[0] / milliseconds[i]);
    }
  }
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    c.contestants[i].ms_per_step = bench::median(times[i]);
    c.contestants[i].ratio = bench::median(c.contestants[i].ratios);
  }
  return c;
}

void print(std::ostream& out, const BulletComparison& c) {
  const double steps = c.steps;
  out << bench::format(
      "%d bodies, cube %g wide, gravity %g: %d steps of %g s, %d runs. A step: %.1f pairs of meshes whose boxes "
      "overlap, %.2f touch; %.1f of mesh and plane, %.2f touch.\n\n",
      c.scene.bodies, c.scene.width, c.scene.gravity, c.steps, c.scene.dt, c.runs,
      static_cast<double>(c.mesh_pairs) / steps, static_cast<double>(c.touching_meshes) / steps,
      static_cast<double>(c.plane_pairs) / steps, static_cast<double>(c.touching_planes) / steps);
  bench::MarkdownTable table(
      out,
      {"collision detection", "ms/step", "times faster", "asked/step", "rejected", "other contacts", "other poses"}, 23,
      12);
  for (const WorldResult& x : c.contestants) {
    const double asked = static_cast<double>(x.asked);
    table.row({x.name, bench::format("%.3f", x.ms_per_step), bench::format("%.2f", x.ratio),
               bench::format("%.1f", asked / steps),
               bench::format("%.2f %%", 100 * bench::ratio(static_cast<double>(x.rejected), asked)),
               std::to_string(x.different_contacts), std::to_string(x.different_transforms)});
  }
}

nlohmann::ordered_json to_json(const BulletComparison& c) {
  nlohmann::ordered_json json = {{"bodies", c.scene.bodies},
                                 {"width", c.scene.width},
                                 {"gravity", c.scene.gravity},
                                 {"margin", c.scene.margin},
                                 {"dt", c.scene.dt},
                                 {"steps", c.steps},
                                 {"runs", c.runs},
                                 {"mesh_pairs", c.mesh_pairs},
                                 {"touching_meshes", c.touching_meshes},
                                 {"plane_pairs", c.plane_pairs},
                                 {"touching_planes", c.touching_planes},
                                 {"same", c.same()},
                                 {"worlds", nlohmann::ordered_json::array()}};
  for (const WorldResult& x : c.contestants) {
    json["worlds"].push_back({{"name", x.name},
                              {"ms_per_step", x.ms_per_step},
                              {"ratio", x.ratio},
                              {"ratios", x.ratios},
                              {"asked", x.asked},
                              {"rejected", x.rejected},
                              {"different_contacts", x.different_contacts},
                              {"different_transforms", x.different_transforms}});
  }
  return json;
}

}  // namespace encage::bullet_bench
