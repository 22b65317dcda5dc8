// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace encage {
namespace {

using shapes::cube;
using shapes::scaled;

/// A source and cages around it, certificates by certify(): what a bake would store.
struct Asset {
  SourceMesh source;
  CageHierarchy hierarchy;

  Asset() {
    source.obstacle = scaled(shapes::torus(2, 0.3, 30, 9), 1 / 3.0);
    source.clean = source.obstacle;
    source.volume = signed_volume(source.obstacle);
    source.diagonal = bounds(source.obstacle).diagonal().norm();
    source.hash = {1, 2};
    hierarchy.origin = source.origin;
    hierarchy.solid = source.solid;
    hierarchy.source_hash = source.hash;
    hierarchy.source_volume = source.volume;
    hierarchy.diagonal = source.diagonal;
    hierarchy.fine = source.obstacle;
    hierarchy.fine.vertices = source.obstacle.vertices.cast<float>().cast<double>();
    hierarchy.fine_error = 1e-7;
    const TriangleMesh* inner = &source.obstacle;
    for (const double radius : {0.5, 0.75, 1.0}) {
      TriangleMesh cage = scaled(shapes::torus(2, radius, 24, 8), 1 / 3.0);
      cage.vertices = cage.vertices.cast<float>().cast<double>();
      const CertifyResult proven = certify(*inner, Solid::closed, cage);
      EXPECT_TRUE(proven.holds) << proven.reason;
      hierarchy.levels.push_back({cage, proven.certificate});
      hierarchy.levels.back().certificate.volume_ratio = proven.certificate.volume / source.volume;
      inner = &source.obstacle;
    }
    for (std::size_t i = 1; i < hierarchy.levels.size(); ++i) {
      CageLevel& level = hierarchy.levels[i];
      const auto ratio = level.certificate.volume_ratio;
      level.certificate = certify(hierarchy.levels[i - 1].mesh, Solid::closed, level.mesh).certificate;
      level.certificate.volume_ratio = ratio;
    }
  }
};

CheckReport::Check find(const CheckReport& report, const std::string& subject) {
  const auto it = std::find_if(report.checks.begin(), report.checks.end(),
                               [&](const CheckReport::Check& c) { return c.subject == subject; });
  if (it == report.checks.end()) {
    ADD_FAILURE() << "no check of " << subject;
    return {};
  }
  return *it;
}

/// The only check that does not hold.
void expect_only(const CheckReport& report, const std::string& subject, CheckVerdict verdict,
                 const std::string& detail) {
  EXPECT_FALSE(report.holds());
  for (const CheckReport::Check& c : report.checks) {
    if (c.subject == subject) continue;
    EXPECT_EQ(c.verdict, CheckVerdict::holds) << c.subject << ": " << c.detail;
  }
  const CheckReport::Check c = find(report, subject);
  EXPECT_EQ(c.verdict, verdict);
  EXPECT_NE(c.detail.find(detail), std::string::npos) << c.detail;
}

TEST(CheckAsset, HoldsWithAndWithoutSource) {
  const Asset asset;
  for (const SourceMesh* source : {static_cast<const SourceMesh*>(nullptr), &asset.source}) {
    const CheckReport report = check_asset(asset.hierarchy, source);
    for (const CheckReport::Check& c : report.checks)
      EXPECT_EQ(c.verdict, CheckVerdict::holds) << c.subject << c.detail;
    EXPECT_TRUE(report.holds());
    EXPECT_EQ(report.checks.size(), source ? 9U : 6U);
  }
}

TEST(CheckAsset, DistancesAreProvenWithTheSource) {
  Asset asset;
  for (CageLevel& level : asset.hierarchy.levels) {
    const DistanceBounds bounds = distance_bounds(asset.source.obstacle, level.mesh);
    level.certificate.max_distance = bounds.max_distance;
    level.certificate.mean_distance = bounds.mean_distance;
  }
  EXPECT_TRUE(check_asset(asset.hierarchy, &asset.source).holds());
  for (const auto distance : {&Certificate::max_distance, &Certificate::mean_distance}) {
    Asset other = asset;
    *(other.hierarchy.levels[1].certificate.*distance) *= 1.5;  // an upper bound still
    EXPECT_TRUE(check_asset(other.hierarchy, &other.source).holds());
    *(other.hierarchy.levels[1].certificate.*distance) *= 0.66;
    expect_only(check_asset(other.hierarchy, &other.source), "level 2 certificate", CheckVerdict::refuted,
                distance == &Certificate::max_distance ? " max_distance" : " mean_distance");
    EXPECT_TRUE(check_asset(other.hierarchy).holds()) << "they are distances to the source";
    (other.hierarchy.levels[1].certificate.*distance).reset();
    EXPECT_TRUE(check_asset(other.hierarchy, &other.source).holds());
  }
}

TEST(CheckAsset, LevelsAreProvenAroundOneAnother) {
  Asset asset;
  std::swap(asset.hierarchy.levels[1], asset.hierarchy.levels[2]);
  const CheckReport report = check_asset(asset.hierarchy);
  EXPECT_EQ(find(report, "level 3 nesting").verdict, CheckVerdict::refuted);
  EXPECT_EQ(find(report, "level 3 nesting").detail, "the component of inner triangle 0 lies outside the cage");
}

TEST(CheckAsset, LevelOneIsProvenAroundTheSource) {
  Asset asset;
  asset.source.obstacle.vertices.row(7) *= 2;
  const CheckReport report = check_asset(asset.hierarchy, &asset.source);
  EXPECT_EQ(find(report, "level 1 nesting").verdict, CheckVerdict::refuted);
  EXPECT_NE(find(report, "level 1 nesting").detail.find("touches inner triangle"), std::string::npos);
  EXPECT_EQ(find(report, "fine mesh").verdict, CheckVerdict::refuted);
}

TEST(CheckAsset, LevelOneIsProvenAroundTheFineMesh) {
  Asset asset;
  asset.hierarchy.fine.vertices.row(7) *= 2;
  expect_only(check_asset(asset.hierarchy), "level 1 nesting", CheckVerdict::refuted, "touches inner triangle");
}

TEST(CheckAsset, WithoutTheFineMeshLevelOneNeedsTheSource) {
  Asset asset;
  asset.hierarchy.fine = {};
  expect_only(check_asset(asset.hierarchy), "level 1 nesting", CheckVerdict::unproven, "only with --source");
  EXPECT_TRUE(check_asset(asset.hierarchy, &asset.source).holds());
  // What can be proven of the cage alone still is.
  asset.hierarchy.levels[0].mesh.triangles.col(0).swap(asset.hierarchy.levels[0].mesh.triangles.col(1));
  EXPECT_EQ(find(check_asset(asset.hierarchy), "level 1 nesting").verdict, CheckVerdict::refuted);
}

TEST(CheckAsset, AClearanceWithinTheErrorOfTheFineMeshProvesNothing) {
  Asset asset;
  const double clearance = asset.hierarchy.levels[0].certificate.clearance;
  asset.hierarchy.fine_error = 1.001 * clearance;
  expect_only(check_asset(asset.hierarchy), "level 1 nesting", CheckVerdict::unproven, "only with --source");
  EXPECT_TRUE(check_asset(asset.hierarchy, &asset.source).holds());
  // The claim is larger than the error, the distance to the fine mesh is not.
  asset.hierarchy.levels[0].certificate.clearance = 1.002 * clearance;
  expect_only(check_asset(asset.hierarchy), "level 1 nesting", CheckVerdict::unproven, "only with --source");
}

TEST(CheckAsset, EveryStoredFigureIsCompared) {
  const Asset sound;
  const auto refuted = [&](const std::string& field, auto&& change) {
    Asset asset = sound;
    change(asset.hierarchy.levels[1].certificate);
    expect_only(check_asset(asset.hierarchy), "level 2 certificate", CheckVerdict::refuted, " " + field);
  };
  refuted("clearance", [](Certificate& c) { c.clearance *= 1.0001; });
  refuted("clearance", [](Certificate& c) { c.clearance = 0; });
  refuted("clearance", [](Certificate& c) { c.clearance = std::nan(""); });
  refuted("volume", [](Certificate& c) { c.volume *= 1.0001; });
  refuted("volume_ratio", [](Certificate& c) { *c.volume_ratio *= 1.0001; });
  refuted("volume_ratio", [](Certificate& c) { c.volume_ratio.reset(); });
  refuted("components", [](Certificate& c) { ++c.components; });
  refuted("cavities", [](Certificate& c) { ++c.cavities; });
  refuted("genus", [](Certificate& c) { ++c.genus; });
  refuted("no_new_handles", [](Certificate& c) { c.no_new_handles.reset(); });
  Asset modest = sound;
  modest.hierarchy.levels[1].certificate.clearance *= 0.5;
  EXPECT_TRUE(check_asset(modest.hierarchy).holds()) << "a smaller lower bound is one too";
}

TEST(CheckAsset, TheSourceMustBeTheOneThatWasBaked) {
  const Asset sound;
  const auto refuted = [&](const std::string& subject, const std::string& detail, auto&& change) {
    Asset asset = sound;
    change(asset.source);
    expect_only(check_asset(asset.hierarchy, &asset.source), subject, CheckVerdict::refuted, detail);
  };
  refuted("source hash", "was made from", [](SourceMesh& s) { s.hash.low ^= 1; });
  refuted("source description", "origin", [](SourceMesh& s) { s.origin[1] = 1; });
  refuted("source description", "cap_count", [](SourceMesh& s) { s.cap_count = 3; });
  refuted("source description", "solid", [](SourceMesh& s) { s.solid = Solid::capped; });
  refuted("source description", "source_volume", [](SourceMesh& s) { s.volume *= 1.001; });
  refuted("source description", "diagonal", [](SourceMesh& s) { s.diagonal *= 1.001; });
  refuted("fine mesh", "triangles are not those", [](SourceMesh& s) {
    std::rotate(s.obstacle.triangles.data(), s.obstacle.triangles.data() + 1, s.obstacle.triangles.data() + 3);
  });
}

TEST(CheckAsset, CoordinatesMustBeFloat32) {
  Asset asset;
  asset.hierarchy.levels[2].mesh.vertices(0, 0) += 1e-12;
  expect_only(check_asset(asset.hierarchy), "level 3 vertices", CheckVerdict::refuted, "float32");
}

TEST(CheckAsset, NoLevels) {
  Asset asset;
  asset.hierarchy.levels.clear();
  expect_only(check_asset(asset.hierarchy), "levels", CheckVerdict::refuted, "no cage");
}

TEST(CheckAsset, SurfaceOnlyHasNoRatio) {
  Asset asset;
  asset.hierarchy.solid = Solid::surface_only;
  asset.hierarchy.source_volume = 0;
  for (CageLevel& level : asset.hierarchy.levels) level.certificate.volume_ratio.reset();
  EXPECT_TRUE(check_asset(asset.hierarchy).holds());
  EXPECT_STREQ(name(CheckVerdict::unproven), "unproven");
}

}  // namespace
}  // namespace encage
