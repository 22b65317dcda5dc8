// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/compare.h"

#include <algorithm>
#include <array>
#include <cstdio>
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

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// Milliseconds of the contestants in one run; counts go to `c`.
std::array<double, kinds.size()> run(const TriangleMesh& mesh, const ShapePtr& shape, Comparison& c) {
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

bool Comparison::same() const {
  return std::all_of(contestants.begin(), contestants.end(),
                     [](const Contestant& c) { return c.different_contacts == 0 && c.different_transforms == 0; });
}

Comparison compare(const TriangleMesh& mesh, const ShapePtr& shape, const Scene& scene, int steps, int runs) {
  Comparison c;
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
    c.contestants[i].ms_per_step = median(times[i]);
    c.contestants[i].ratio = median(c.contestants[i].ratios);
  }
  return c;
}

void print(std::ostream& out, const Comparison& c) {
  std::array<char, 320> line;
  const double steps = c.steps;
  std::snprintf(
      line.data(), line.size(),
      "%d bodies, cube %g wide, gravity %g: %d steps of %g s, %d runs. A step: %.1f pairs of meshes whose boxes "
      "overlap, %.2f touch; %.1f of mesh and plane, %.2f touch.\n\n",
      c.scene.bodies, c.scene.width, c.scene.gravity, c.steps, c.scene.dt, c.runs,
      static_cast<double>(c.mesh_pairs) / steps, static_cast<double>(c.touching_meshes) / steps,
      static_cast<double>(c.plane_pairs) / steps, static_cast<double>(c.touching_planes) / steps);
  out << line.data()
      << "| collision detection     | ms/step | times faster | asked/step | rejected | other contacts | other poses |\n"
         "|---|--:|--:|--:|--:|--:|--:|\n";
  for (const Contestant& x : c.contestants) {
    const double asked = static_cast<double>(x.asked);
    std::snprintf(line.data(), line.size(), "| %-23s | %7.3f | %12.2f | %10.1f | %6.2f %% | %14lld | %11lld |\n",
                  x.name.c_str(), x.ms_per_step, x.ratio, asked / steps,
                  asked > 0 ? 100 * static_cast<double>(x.rejected) / asked : 0,
                  static_cast<long long>(x.different_contacts), static_cast<long long>(x.different_transforms));
    out << line.data();
  }
}

nlohmann::ordered_json to_json(const Comparison& c) {
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
  for (const Contestant& x : c.contestants) {
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
