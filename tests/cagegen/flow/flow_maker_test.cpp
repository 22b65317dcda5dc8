// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow_maker.h"

#include "cagegen/collapse/starts.h"
#include "cagegen/contact/minimize.h"
#include "cagegen/flow/coarse_sources.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace encage::makers {
namespace {

using shapes::joined;
using shapes::moved;
using shapes::Random;

/// A source as bake() hands it to the level, with the default energies.
struct Source {
  explicit Source(const TriangleMesh& input, std::int64_t faces) : mesh(sanitize(input)), obstacle(mesh.obstacle) {
    request.inner = &mesh.obstacle;
    request.clean = &mesh.clean;
    request.manifold = mesh.manifold;
    request.faces = faces;
    request.diagonal = mesh.diagonal;
    request.clearance = 1e-5 * mesh.diagonal;
    request.self_clearance = 6 * request.clearance;
    wraps.emplace(obstacle, mesh.clean, request.diagonal, request.clearance);
    request.wraps = &*wraps;
    choices.inflate = step_energy();
    choices.final = volume_energy();
    request.log = [this](std::string_view line) { log.emplace_back(line); };
  }
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  std::vector<Candidate> candidates() { return flow_maker(obstacle, request, choices, control)->next(); }

  /// The tightest candidate, finished.
  std::optional<Candidate> build() {
    const auto maker = flow_maker(obstacle, request, choices, control);
    std::vector<Candidate> found = maker->next();
    if (found.empty()) {
      failure = maker->failure();
      return std::nullopt;
    }
    const auto tighter = [](const Candidate& a, const Candidate& b) { return a.volume < b.volume; };
    Candidate best = std::move(*std::min_element(found.begin(), found.end(), tighter));
    maker->finish(best);
    return best;
  }

  SourceMesh mesh;
  Obstacle obstacle;
  std::optional<WrapStarts> wraps;
  LevelRequest request;
  FlowChoices choices;
  Control control;
  std::string failure;
  std::vector<std::string> log;
};

/// Everything that holds of any level.
Candidate expect_level(Source& source) {
  const auto result = source.build();
  if (!result) {
    ADD_FAILURE() << source.failure;
    return {};
  }
  const TriangleMesh& cage = result->cage;
  const CertifyResult proof = certify(source.mesh.obstacle, source.mesh.solid, cage);
  EXPECT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * source.request.clearance);
  EXPECT_TRUE(source.choices.coarse != nullptr || cage.triangles.rows() <= source.request.faces);
  EXPECT_EQ(cage.vertices, shapes::rounded(cage).vertices);
  EXPECT_EQ(result->volume, signed_volume(cage));
  EXPECT_EQ(result->method, Method::flow);
  EXPECT_GT(result->flow_seconds, 0);
  EXPECT_GT(result->reinflate_seconds, 0);
  return *result;
}

TEST(FlowMaker, SmallShapes) {
  const TriangleMesh sphere = shapes::sphere(4);
  const TriangleMesh torus = shapes::torus(1, 0.35, 40, 20);
  for (const auto& [input, faces, most] : {std::tuple{sphere, 500, 1.02}, {sphere, 60, 1.25}, {torus, 100, 1.5}}) {
    Source source(input, faces);
    const Candidate level = expect_level(source);
    EXPECT_LT(level.volume, most * source.mesh.volume) << faces << " from " << level.start;
    EXPECT_GT(level.volume, source.mesh.volume);
  }
}

TEST(FlowMaker, WhereTheFineMeshHasToMoveFarAWrapIsTriedToo) {
  Random random(5);
  TriangleMesh spiky = shapes::sphere(4);
  for (Eigen::Index v = 0; v < spiky.vertices.rows(); ++v) spiky.vertices.row(v) *= random(0.6, 1.4);
  Source source(spiky, 400);
  const Candidate level = expect_level(source);
  EXPECT_TRUE(level.start.starts_with("wrap")) << level.start;
  EXPECT_LT(level.volume, 1.3 * signed_volume(shapes::scaled(shapes::sphere(4), 1.4)));
}

TEST(FlowMaker, EveryEnergyAndBothPaths) {
  for (const EnergyPtr& inflate : {start_energy(), step_energy(), volume_energy()}) {
    for (const EnergyPtr& final : {start_energy(), step_energy(), volume_energy()}) {
      SCOPED_TRACE(inflate->name() + ", " + final->name());
      Source source(shapes::sphere(2), 60);
      source.choices.inflate = inflate;
      source.choices.final = final;
      source.choices.path = final->name() == "step" ? FlowPath::history : FlowPath::straight;
      expect_level(source);
    }
  }
}

TEST(FlowMaker, TheFinalEnergyIsMinimised) {
  const auto level = [](const EnergyPtr& final) {
    Source source(shapes::sphere(3), 100);
    source.choices.final = final;
    return expect_level(source);
  };
  const Candidate tight = level(volume_energy());
  const Candidate near = level(start_energy());
  EXPECT_LT(tight.volume, near.volume);
  const auto displacement = [](const Candidate& result) {
    const Vertices& cage = result.cage.vertices;
    return start_energy()->value({result.undeformed, result.undeformed, cage, cage});
  };
  EXPECT_LT(displacement(near), displacement(level(step_energy())));
}

TEST(FlowMaker, Parts) {
  Source source(joined(shapes::sphere(2), moved(shapes::sphere(2), {2.3, 0, 0})), 120);
  expect_level(source);
}

TEST(FlowMaker, TheUsersCoarseMesh) {
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(1), 1.1);
  Source source(shapes::sphere(3), 0);
  source.choices.coarse = &coarse;
  const Candidate level = expect_level(source);
  EXPECT_EQ(level.start, "user");
  EXPECT_EQ(level.cage.triangles, coarse.triangles);
  EXPECT_EQ(level.undeformed.vertices, shapes::rounded(coarse).vertices);

  // One that lies elsewhere.
  const TriangleMesh far = moved(coarse, {100, 0, 0});
  Source lost(shapes::sphere(1), 0);
  lost.choices.coarse = &far;
  EXPECT_FALSE(lost.build());
  EXPECT_EQ(lost.failure.rfind("user: the flow stalls", 0), 0u) << lost.failure;
  EXPECT_FALSE(lost.log.empty());
}

TEST(FlowMaker, AnEmptyPartOfTheUsersCoarseMesh) {
  const TriangleMesh coarse =
      joined(shapes::scaled(shapes::sphere(1), 1.1), moved(shapes::scaled(shapes::sphere(1), 0.05), {2, 0, 0}));
  Source source(shapes::sphere(3), 0);
  source.choices.coarse = &coarse;
  EXPECT_EQ(expect_level(source).cage.triangles.rows(), 32) << "the part is dropped";
}

TEST(FlowMaker, TheUsersDecimator) {
  int calls = 0;
  Source source(shapes::sphere(3), 40);
  source.choices.decimator = [&](const TriangleMesh& clean, const TriangleMesh& undeformed, std::int64_t faces) {
    ++calls;
    EXPECT_EQ(clean.triangles.rows(), 512);
    EXPECT_EQ(undeformed.triangles.rows(), 512);
    EXPECT_EQ(faces, 40);
    return shapes::sphere(1);
  };
  const Candidate level = expect_level(source);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(level.start, "decimator");
  EXPECT_EQ(level.cage.triangles.rows(), 32);
}

TEST(FlowMaker, KeepsTheGenus) {
  Source source(shapes::torus(1, 0.35, 30, 15), 80);
  source.request.topology = Topology::keep;
  const Candidate level = expect_level(source);
  EXPECT_EQ(certify(source.mesh.obstacle, Solid::closed, level.cage).certificate.genus, 1);
  EXPECT_TRUE(level.start == "regular" || level.start == "adaptive");
  source.request.topology = Topology::simplify;
  EXPECT_EQ(expect_level(source).start.rfind("wrap/", 0), 0u);
}

TEST(FlowMaker, Soups) {
  // Spheres through each other, an open one, and loose triangles of all kinds.
  Random random(3);
  TriangleMesh soup = joined(shapes::sphere(2), moved(shapes::sphere(2), {1, 0.3, 0}));
  TriangleMesh open = moved(shapes::sphere(2), {-1, 0, 0});
  open.triangles.conservativeResize(100, 3);
  soup = joined(soup, open);
  for (int i = 0; i < 30; ++i) {
    const Corners t = shapes::awkward_triangle(random, 0.4);
    soup = shapes::with_triangle(soup, t[0], t[1], t[2]);
  }
  Source source(soup, 200);
  ASSERT_FALSE(source.mesh.manifold);
  EXPECT_EQ(expect_level(source).start.rfind("wrap/", 0), 0u);
}

TEST(FlowMaker, DegenerateTriangles) {
  // Slits in the surface: triangles on the points of an edge, and a spike without area that stands out.
  TriangleMesh input = shapes::sphere(3);
  const Point a = input.corner(7, 0);
  const Point b = input.corner(7, 1);
  input = shapes::with_triangle(input, a, b, (a + b) / 2);
  input = shapes::with_triangle(input, a, 1.3 * a, 1.3 * a);
  Source source(input, 120);
  expect_level(source);
}

TEST(FlowMaker, TheSameForAnyNumberOfThreads) {
  const TriangleMesh input = shapes::torus(1, 0.3, 30, 16);
  Source one(input, 310);
  const Candidate first = expect_level(one);
  for (const int threads : {2, 3}) {
    Source other(input, 310);
    other.request.threads = threads;
    const Candidate level = expect_level(other);
    EXPECT_EQ(level.cage.vertices, first.cage.vertices);
    EXPECT_EQ(level.cage.triangles, first.cage.triangles);
    EXPECT_EQ(level.start, first.start);
  }
}

TEST(FlowMaker, SmallCagesComeOfAllCoarseMeshes) {
  Source source(shapes::sphere(3), 100);
  EXPECT_GE(source.candidates().size(), 2u);
}

TEST(FlowMaker, WhereOthersCompeteWrapsOfLargeMeshesAreLeftToThem) {
  Source source(shapes::torus(1, 0.3, 120, 60), 400);
  const auto wraps = [&] {
    const auto sources = coarse_sources(source.request, source.choices, [] {});
    return std::count_if(sources.begin(), sources.end(), [](const auto& s) { return s.name.starts_with("wrap/"); });
  };
  EXPECT_GT(wraps(), 0);
  source.choices.competes = true;
  EXPECT_EQ(wraps(), 0);
  source.request.faces = 100;
  EXPECT_GT(wraps(), 0) << "small cages are soon made";
}

TEST(FlowMaker, Cancel) {
  std::atomic<bool> cancel{true};
  Source source(shapes::sphere(3), 100);
  source.control.cancel = &cancel;
  EXPECT_THROW(source.build(), Cancelled);
}

}  // namespace
}  // namespace encage::makers
