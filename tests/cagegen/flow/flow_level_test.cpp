// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow_level.h"

#include "cagegen/contact/minimize.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <atomic>
#include <string>
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
    choices.inflate = step_energy();
    choices.final = volume_energy();
    request.log = [this](std::string_view line) { log.emplace_back(line); };
  }
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  std::optional<LevelResult> build() {
    return build([this](const Candidate& candidate) -> std::optional<Certificate> {
      const CertifyResult proof = certify(mesh.obstacle, mesh.solid, candidate.cage);
      return proof.holds ? std::optional(proof.certificate) : std::nullopt;
    });
  }
  std::optional<LevelResult> build(const Accept& accept) {
    try {
      return flow_level(obstacle, request, choices, control, accept);
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      failure = error.what();
      return std::nullopt;
    }
  }

  SourceMesh mesh;
  Obstacle obstacle;
  LevelRequest request;
  FlowChoices choices;
  Control control;
  std::string failure;
  std::vector<std::string> log;
};

/// Everything that holds of any level.
LevelResult expect_level(Source& source) {
  const auto result = source.build();
  if (!result) {
    ADD_FAILURE() << source.failure;
    return {};
  }
  const TriangleMesh& cage = result->candidate.cage;
  const CertifyResult proof = certify(source.mesh.obstacle, source.mesh.solid, cage);
  EXPECT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * source.request.clearance);
  EXPECT_TRUE(source.choices.coarse != nullptr || cage.triangles.rows() <= source.request.faces);
  EXPECT_EQ(cage.vertices, shapes::rounded(cage).vertices);
  EXPECT_EQ(result->candidate.volume, signed_volume(cage));
  EXPECT_EQ(result->certificate.volume, proof.certificate.volume);
  EXPECT_EQ(result->certificate.clearance, proof.certificate.clearance);
  EXPECT_EQ(result->undeformed.triangles, cage.triangles);
  EXPECT_EQ(result->undeformed.vertices.rows(), cage.vertices.rows());
  EXPECT_GT(result->flow_seconds, 0);
  EXPECT_GT(result->reinflate_seconds, 0);
  return *result;
}

TEST(FlowLevel, SmallShapes) {
  const TriangleMesh sphere = shapes::sphere(4);
  const TriangleMesh torus = shapes::torus(1, 0.35, 40, 20);
  for (const auto& [input, faces, most] : {std::tuple{sphere, 500, 1.02}, {sphere, 60, 1.25}, {torus, 100, 1.5}}) {
    Source source(input, faces);
    const LevelResult level = expect_level(source);
    EXPECT_LT(level.candidate.volume, most * source.mesh.volume) << faces << " from " << level.candidate.start;
    EXPECT_GT(level.candidate.volume, source.mesh.volume);
  }
}

TEST(FlowLevel, WhereTheFineMeshHasToMoveFarAWrapIsTriedToo) {
  Random random(5);
  TriangleMesh spiky = shapes::sphere(4);
  for (Eigen::Index v = 0; v < spiky.vertices.rows(); ++v) spiky.vertices.row(v) *= random(0.6, 1.4);
  Source source(spiky, 400);
  const LevelResult level = expect_level(source);
  EXPECT_TRUE(level.candidate.start.starts_with("wrap")) << level.candidate.start;
  EXPECT_LT(level.candidate.volume, 1.3 * signed_volume(shapes::scaled(shapes::sphere(4), 1.4)));
}

TEST(FlowLevel, EveryEnergyAndBothPaths) {
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

TEST(FlowLevel, TheFinalEnergyIsMinimised) {
  const auto level = [](const EnergyPtr& final) {
    Source source(shapes::sphere(3), 100);
    source.choices.final = final;
    return expect_level(source);
  };
  const LevelResult tight = level(volume_energy());
  const LevelResult near = level(start_energy());
  EXPECT_LT(tight.candidate.volume, near.candidate.volume);
  const auto displacement = [](const LevelResult& result) {
    const Vertices& cage = result.candidate.cage.vertices;
    return start_energy()->value({result.undeformed, result.undeformed, cage, cage});
  };
  EXPECT_LT(displacement(near), displacement(level(step_energy())));
}

TEST(FlowLevel, Parts) {
  Source source(joined(shapes::sphere(2), moved(shapes::sphere(2), {2.3, 0, 0})), 120);
  expect_level(source);
}

TEST(FlowLevel, TheUsersCoarseMesh) {
  const TriangleMesh coarse = shapes::scaled(shapes::sphere(1), 1.1);
  Source source(shapes::sphere(3), 0);
  source.choices.coarse = &coarse;
  const LevelResult level = expect_level(source);
  EXPECT_EQ(level.candidate.start, "user");
  EXPECT_EQ(level.candidate.cage.triangles, coarse.triangles);
  EXPECT_EQ(level.undeformed.vertices, shapes::rounded(coarse).vertices);

  // One that lies elsewhere.
  const TriangleMesh far = moved(coarse, {100, 0, 0});
  Source lost(shapes::sphere(1), 0);
  lost.choices.coarse = &far;
  EXPECT_FALSE(lost.build());
  EXPECT_EQ(lost.failure.rfind("user: the flow stalls", 0), 0u) << lost.failure;
  EXPECT_FALSE(lost.log.empty());
}

TEST(FlowLevel, AnEmptyPartOfTheUsersCoarseMesh) {
  const TriangleMesh coarse =
      joined(shapes::scaled(shapes::sphere(1), 1.1), moved(shapes::scaled(shapes::sphere(1), 0.05), {2, 0, 0}));
  Source source(shapes::sphere(3), 0);
  source.choices.coarse = &coarse;
  EXPECT_EQ(expect_level(source).candidate.cage.triangles.rows(), 32) << "the part is dropped";
}

TEST(FlowLevel, TheUsersDecimator) {
  int calls = 0;
  Source source(shapes::sphere(3), 40);
  source.choices.decimator = [&](const TriangleMesh& clean, const TriangleMesh& undeformed, std::int64_t faces) {
    ++calls;
    EXPECT_EQ(clean.triangles.rows(), 512);
    EXPECT_EQ(undeformed.triangles.rows(), 512);
    EXPECT_EQ(faces, 40);
    return shapes::sphere(1);
  };
  const LevelResult level = expect_level(source);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(level.candidate.start, "decimator");
  EXPECT_EQ(level.candidate.cage.triangles.rows(), 32);
}

TEST(FlowLevel, KeepsTheGenus) {
  Source source(shapes::torus(1, 0.35, 30, 15), 80);
  source.request.topology = Topology::keep;
  const LevelResult level = expect_level(source);
  EXPECT_EQ(certify(source.mesh.obstacle, Solid::closed, level.candidate.cage).certificate.genus, 1);
  EXPECT_TRUE(level.candidate.start == "regular" || level.candidate.start == "adaptive");
  source.request.topology = Topology::simplify;
  EXPECT_EQ(expect_level(source).candidate.start.rfind("wrap/", 0), 0u);
}

TEST(FlowLevel, Soups) {
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
  EXPECT_EQ(expect_level(source).candidate.start.rfind("wrap/", 0), 0u);
}

TEST(FlowLevel, DegenerateTriangles) {
  // Slits in the surface: triangles on the points of an edge, and a spike without area that stands out.
  TriangleMesh input = shapes::sphere(3);
  const Point a = input.corner(7, 0);
  const Point b = input.corner(7, 1);
  input = shapes::with_triangle(input, a, b, (a + b) / 2);
  input = shapes::with_triangle(input, a, 1.3 * a, 1.3 * a);
  Source source(input, 120);
  expect_level(source);
}

TEST(FlowLevel, TheSameForAnyNumberOfThreads) {
  const TriangleMesh input = shapes::torus(1, 0.3, 30, 16);
  Source one(input, 310);
  const LevelResult first = expect_level(one);
  for (const int threads : {2, 3}) {
    Source other(input, 310);
    other.request.threads = threads;
    const LevelResult level = expect_level(other);
    EXPECT_EQ(level.candidate.cage.vertices, first.candidate.cage.vertices);
    EXPECT_EQ(level.candidate.cage.triangles, first.candidate.cage.triangles);
    EXPECT_EQ(level.candidate.start, first.candidate.start);
  }
}

TEST(FlowLevel, TheCertificateHasTheLastWord) {
  Source source(shapes::sphere(3), 100);
  std::vector<std::string> offered;
  const auto refuse = [&](const Candidate& candidate) -> std::optional<Certificate> {
    offered.push_back(candidate.start);
    return std::nullopt;
  };
  EXPECT_FALSE(source.build(refuse));
  EXPECT_GE(offered.size(), 2u) << "all that could be nested";
  EXPECT_EQ(source.failure, offered.back() + ": the certificate refuses the cage");
}

TEST(FlowLevel, Cancel) {
  std::atomic<bool> cancel{true};
  Source source(shapes::sphere(3), 100);
  source.control.cancel = &cancel;
  EXPECT_THROW(source.build(), Cancelled);
}

}  // namespace
}  // namespace encage::makers
