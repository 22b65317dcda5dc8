// SPDX-License-Identifier: GPL-3.0-or-later
// The method flow and its competition with collapse.
#include "oracles/meshes.h"
#include "tests/cagegen/bake/certified.h"

#include <encage/bake.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace encage {
namespace {

using shapes::box;
using shapes::flipped;
using shapes::joined;
using shapes::moved;
using shapes::scaled;
using shapes::sphere;
using shapes::torus;
using test::expect_certified;
using test::with_faces;

BakeOptions flow_with_faces(std::vector<std::int64_t> faces, int threads = 2) {
  return with_faces(std::move(faces), threads, BakeMethod::flow);
}

BakeOptions with_coarse(std::vector<TriangleMesh> coarse) {
  BakeOptions options;
  options.coarse = std::move(coarse);
  return options;
}

std::string message(const TriangleMesh& mesh, const BakeOptions& options) {
  try {
    bake(mesh, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

double excess(const CageHierarchy& cages) {
  double sum = 0;
  for (const CageLevel& level : cages.levels) sum += level.certificate.volume_ratio.value() - 1;
  return sum;
}

/// Keeps what is logged.
struct Log {
  std::vector<std::string> messages;
  BakeContext context;

  Log() {
    context.log = context.trace = [this](std::string_view text) { messages.emplace_back(text); };
  }
  bool has(const std::string& part) const {
    return std::any_of(messages.begin(), messages.end(),
                       [&](const std::string& text) { return text.find(part) != std::string::npos; });
  }
};

/// A decimator that fails below so many faces.
Decimator failing_below(std::int64_t least) {
  return [least](const TriangleMesh& finer, const TriangleMesh& undeformed, std::int64_t faces) {
    if (faces < least) throw Error("no idea how");
    return regular_decimator()(finer, undeformed, faces);
  };
}

TEST(BakeFlow, MakesCertifiedLevels) {
  const SourceMesh source = sanitize(torus(1, 0.4, 24, 12));
  BakeReport report;
  const CageHierarchy cages = bake(source, flow_with_faces({160, 60}), {}, &report);
  ASSERT_EQ(cages.levels.size(), 2u);
  expect_certified(cages, source);
  for (const CageLevel& level : cages.levels) {
    EXPECT_EQ(level.certificate.method, Method::flow);
    EXPECT_NE(level.certificate.start, "");
  }
  ASSERT_EQ(report.levels.size(), 2u);
  for (const BakeReport::Level& level : report.levels) EXPECT_GT(level.reinflate_seconds, 0);
  EXPECT_EQ(report.failure, "");
}

TEST(BakeFlow, SameCagesForAnyNumberOfThreads) {
  const SourceMesh source = sanitize(torus(1, 0.4, 16, 8));
  for (const BakeMethod method : {BakeMethod::flow, BakeMethod::automatic}) {
    const CageHierarchy one = bake(source, with_faces({100, 40}, 1, method), {});
    const CageHierarchy two = bake(source, with_faces({100, 40}, 3, method), {});
    ASSERT_EQ(one.levels.size(), two.levels.size());
    for (std::size_t i = 0; i < one.levels.size(); ++i) {
      EXPECT_EQ(one.levels[i].mesh.vertices, two.levels[i].mesh.vertices);
      EXPECT_EQ(one.levels[i].mesh.triangles, two.levels[i].mesh.triangles);
      EXPECT_EQ(one.levels[i].certificate.start, two.levels[i].certificate.start);
    }
  }
}

/// The methods compete level by level, each around the tightest cage so far; a level may then come out looser than that
/// of a chain of its own, but not by much.
TEST(BakeFlow, AutomaticIsAboutAsTightAsTheBetterMethod) {
  for (const TriangleMesh& mesh :
       {sphere(2), torus(1, 0.4, 16, 8), joined(sphere(2), moved(scaled(sphere(1), 0.5), {3, 0, 0}))}) {
    const SourceMesh source = sanitize(mesh);
    const auto run = [&](BakeMethod method) { return bake(source, with_faces({60, 24}, 2, method), {}); };
    const CageHierarchy both = run(BakeMethod::automatic);
    expect_certified(both, source);
    EXPECT_LE(excess(both), 1.05 * excess(run(BakeMethod::collapse)));
    EXPECT_LE(excess(both), 1.05 * excess(run(BakeMethod::flow)));
  }
}

TEST(BakeFlow, AutomaticTakesOddInput) {
  shapes::Random random(7);
  TriangleMesh soup = shapes::mesh({}, {});
  for (int i = 0; i < 20; ++i) soup = shapes::with_triangle(soup, random.point(1), random.point(1), random.point(1));
  TriangleMesh open = sphere(2);
  open.triangles.conservativeResize(open.triangles.rows() - 20, 3);
  const TriangleMesh crossing = joined(torus(1, 0.3, 12, 6), moved(torus(1, 0.3, 12, 6), {0.5, 0.1, 0}));
  for (const TriangleMesh& mesh : {soup, open, crossing, scaled(sphere(2), 1e-20), scaled(sphere(2), 1e20)}) {
    const SourceMesh source = sanitize(mesh);
    expect_certified(bake(source, with_faces({16}, 2, BakeMethod::automatic), {}), source);
  }
}

TEST(BakeFlow, WhatFailsDropsOutOfAutomatic) {
  const SourceMesh source = sanitize(sphere(3));
  BakeOptions options = with_faces({100, 40}, 2, BakeMethod::automatic);
  options.decimator = failing_below(100);
  Log log;
  BakeReport report;
  const CageHierarchy cages = bake(source, options, log.context, &report);
  expect_certified(cages, source);
  ASSERT_EQ(cages.levels.size(), 2u);
  EXPECT_NE(cages.levels[1].certificate.method, Method::flow);
  EXPECT_EQ(report.failure, "");
  EXPECT_TRUE(log.has("level of 40 faces: no idea how"));
}

TEST(BakeFlow, AFailedLevelIsNamed) {
  BakeOptions options = flow_with_faces({100, 40});
  options.decimator = failing_below(100);
  EXPECT_EQ(message(sphere(3), options), "level 2 (40 faces): no idea how");
}

TEST(BakeFlow, KeepPartialReturnsTheLevelsBefore) {
  const SourceMesh source = sanitize(sphere(3));
  BakeOptions options = flow_with_faces({100, 40});
  options.keep_partial = true;
  options.decimator = failing_below(100);
  Log log;
  BakeReport report;
  const CageHierarchy cages = bake(source, options, log.context, &report);
  ASSERT_EQ(cages.levels.size(), 1u);
  EXPECT_EQ(report.levels.size(), 1u);
  expect_certified(cages, source);
  EXPECT_EQ(report.failure, "level 2 (40 faces): no idea how");
  EXPECT_TRUE(log.has(report.failure));
  // Without a level there is nothing to keep.
  options.decimator = failing_below(200);
  EXPECT_EQ(message(sphere(3), options), "level 1 (100 faces): no idea how");
}

TEST(BakeFlow, ADecimatorOfTheUsersSeesBothMeshes) {
  std::vector<std::int64_t> asked;
  BakeOptions options = flow_with_faces({128, 32});
  options.decimator_name = "octahedral";
  options.decimator = [&](const TriangleMesh& finer, const TriangleMesh& undeformed, std::int64_t faces) {
    asked.push_back(faces);
    EXPECT_EQ(finer.triangles.rows(), undeformed.triangles.rows());
    // The cage has moved since.
    EXPECT_EQ(finer.vertices != undeformed.vertices, asked.size() > 1);
    return sphere(faces >= 128 ? 2 : 1);
  };
  const SourceMesh source = sanitize(sphere(3));
  const CageHierarchy cages = bake(source, options, {});
  EXPECT_EQ(asked, (std::vector<std::int64_t>{128, 32}));
  expect_certified(cages, source);
  ASSERT_EQ(cages.levels.size(), 2u);
  EXPECT_EQ(cages.levels[0].mesh.triangles, sphere(2).triangles);
  EXPECT_EQ(cages.levels[1].mesh.triangles, sphere(1).triangles);
  EXPECT_EQ(nlohmann::json::parse(cages.options).at("decimator"), "octahedral");
}

TEST(BakeFlow, WhatADecimatorOfTheUsersMustNotMake) {
  const auto refused = [](const TriangleMesh& made) {
    BakeOptions options = flow_with_faces({100});
    options.decimator_name = "mine";
    options.decimator = [made](const TriangleMesh&, const TriangleMesh&, std::int64_t) { return made; };
    return message(sphere(3), options);
  };
  EXPECT_EQ(refused(sphere(2)), "level 1 (100 faces): the decimator 'mine': made 128 triangles of at most 100");
  TriangleMesh open = sphere(1);
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_NE(refused(open).find("the decimator 'mine': "), std::string::npos) << refused(open);
  TriangleMesh wild = sphere(1);
  wild.triangles(0, 0) = 1000;
  EXPECT_NE(refused(wild).find("the decimator 'mine': "), std::string::npos) << refused(wild);
  TriangleMesh nowhere = sphere(1);
  nowhere.vertices(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refused(nowhere).find("the decimator 'mine': "), std::string::npos) << refused(nowhere);
  const TriangleMesh crossing = joined(sphere(1), moved(sphere(1), {0.5, 0, 0}));
  EXPECT_NE(refused(crossing).find("the decimator 'mine': "), std::string::npos) << refused(crossing);
  EXPECT_NE(refused(TriangleMesh()).find("level 1 (100 faces): "), std::string::npos);
}

/// A descent that is not one.
struct BrokenEnergy : CageEnergy {
  Vertices wrong;
  std::string name() const override { return "broken"; }
  double value(const EnergyState&) const override { return 0; }
  Vertices gradient(const EnergyState&) const override { return wrong; }
  Vertices descent(const EnergyState&) const override { return wrong; }
};

TEST(BakeFlow, EnergiesThatGiveNoDescentAreNamed) {
  const auto energy = std::make_shared<BrokenEnergy>();
  BakeOptions options = flow_with_faces({100});
  options.energy_inflate = energy;
  energy->wrong = Vertices::Zero(3, 3);
  EXPECT_NE(message(sphere(3), options).find("level 1 (100 faces): energy 'broken': a descent of 3 rows for "),
            std::string::npos);
  options.energy_inflate = nullptr;
  struct NotFinite : BrokenEnergy {
    Vertices descent(const EnergyState& state) const override {
      return Vertices::Constant(state.cage.rows(), 3, std::numeric_limits<double>::infinity());
    }
  };
  options.energy_final = std::make_shared<NotFinite>();
  EXPECT_EQ(message(sphere(3), options), "level 1 (100 faces): energy 'broken': the descent is not finite");
}

TEST(BakeFlow, CoarseMeshesOfTheUsers) {
  const Eigen::Vector3d place(1e4, -2e4, 5);
  const SourceMesh source = sanitize(moved(sphere(3), place));
  ASSERT_NE(source.origin, Eigen::Vector3d::Zero().eval());
  for (const BakeMethod method : {BakeMethod::automatic, BakeMethod::flow}) {
    BakeOptions options = with_coarse({moved(sphere(2), place), moved(sphere(1), place)});
    options.method = method;
    const CageHierarchy cages = bake(source, options, {});
    expect_certified(cages, source);
    ASSERT_EQ(cages.levels.size(), 2u);
    EXPECT_EQ(cages.levels[0].mesh.triangles, sphere(2).triangles);
    EXPECT_EQ(cages.levels[1].mesh.triangles, sphere(1).triangles);
    EXPECT_EQ(cages.levels[1].certificate.method, Method::flow);
    const nlohmann::json json = nlohmann::json::parse(cages.options);
    EXPECT_EQ(json.at("coarse_meshes"), 2);
    EXPECT_EQ(json.at("faces"), (std::vector<int>{128, 32}));
  }
}

TEST(BakeFlow, ACoarseMeshMayHaveMoreFaces) {
  const SourceMesh source = sanitize(sphere(1));
  Log log;
  const CageHierarchy cages = bake(source, with_coarse({sphere(2)}), log.context);
  expect_certified(cages, source);
  EXPECT_EQ(cages.levels.at(0).mesh.triangles.rows(), 128);
  EXPECT_TRUE(log.has("coarse mesh of 128 faces: the level before has no more, 32"));
}

TEST(BakeFlow, RefusesBadCoarseMeshes) {
  const TriangleMesh good = scaled(sphere(2), 1.2);
  const auto refusal = [&](const TriangleMesh& bad) {
    BakeOptions options = with_coarse({good, bad});
    options.coarse_names = {"good.off", "bad.off"};
    const std::string text = message(sphere(3), options);
    EXPECT_TRUE(text.starts_with("level 2: the coarse mesh 'bad.off': ")) << text;
    return text;
  };
  TriangleMesh open = good;
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_NE(refusal(open).find("has no other triangle"), std::string::npos);
  EXPECT_NE(refusal(flipped(good)).find("turned inward"), std::string::npos);
  const TriangleMesh crossing = joined(box({-2, -2, -2}, {2, 2, 2}), box({-1.5, -1.4, -1.3}, {2.5, 2.6, 2.7}));
  EXPECT_NE(refusal(crossing).find(" intersect"), std::string::npos);
  TriangleMesh range = good;
  range.triangles(5, 1) = 1000;
  EXPECT_NE(refusal(range).find("triangle 5 refers to vertex 1000"), std::string::npos);
  TriangleMesh flat = good;
  flat.vertices.col(2).setZero();
  refusal(flat);
  TriangleMesh nan = good;
  nan.vertices(3, 0) = std::nan("");
  EXPECT_NE(refusal(nan).find("vertex 3 is not finite"), std::string::npos);
  EXPECT_NE(refusal(TriangleMesh{}).find("has no triangles"), std::string::npos);
  // Without a name.
  EXPECT_TRUE(message(sphere(3), with_coarse({open})).starts_with("level 1: the coarse mesh: edge "));
}

/// Volume, and a dislike of what is below z = -1.
class Floor : public CageEnergy {
 public:
  std::string name() const override { return "floor"; }
  double value(const EnergyState& state) const override {
    ++calls;
    return volume_->value(state) + energy_weight * (state.cage.col(2).array() + 1).min(0).square().sum();
  }
  Vertices gradient(const EnergyState& state) const override {
    Vertices g = volume_->gradient(state);
    g.col(2).array() += 2 * energy_weight * (state.cage.col(2).array() + 1).min(0);
    return g;
  }

  mutable std::atomic<int> calls = 0;

 private:
  static constexpr double energy_weight = 30;
  EnergyPtr volume_ = volume_energy();
};

TEST(BakeFlow, AnEnergyOfTheUsers) {
  const SourceMesh source = sanitize(sphere(3));
  const auto energy = std::make_shared<Floor>();
  BakeOptions options = flow_with_faces({60});
  const double before = bake(source, options, {}).levels.at(0).mesh.vertices.col(2).minCoeff();
  options.energy_final = energy;
  const CageHierarchy cages = bake(source, options, {});
  expect_certified(cages, source);
  EXPECT_GT(energy->calls, 0);
  EXPECT_GT(cages.levels[0].mesh.vertices.col(2).minCoeff(), before);
  EXPECT_EQ(nlohmann::json::parse(cages.options).at("energy_final"), "floor");
  EXPECT_EQ(nlohmann::json::parse(cages.options).at("energy_inflate"), "step");
  options.energy_inflate = energy;
  expect_certified(bake(source, options, {}), source);
}

class Throwing : public Floor {
 public:
  Vertices gradient(const EnergyState&) const override { throw std::runtime_error("enough"); }
};

TEST(BakeFlow, ExceptionsOfTheUsersFunctionsPassThrough) {
  BakeOptions options = flow_with_faces({60});
  options.energy_final = std::make_shared<Throwing>();
  EXPECT_THROW(bake(sphere(3), options), std::runtime_error);
  options = with_faces({60}, 2, BakeMethod::automatic);
  options.decimator = [](const TriangleMesh&, const TriangleMesh&, std::int64_t) -> TriangleMesh {
    throw std::runtime_error("enough");
  };
  EXPECT_THROW(bake(sphere(3), options), std::runtime_error);
}

/// Sets a flag in the middle of the work.
class Cancelling : public Floor {
 public:
  explicit Cancelling(std::atomic<bool>& flag) : flag_(flag) {}
  Vertices gradient(const EnergyState& state) const override {
    flag_ = true;
    return Floor::gradient(state);
  }

 private:
  std::atomic<bool>& flag_;
};

TEST(BakeFlow, Cancel) {
  for (const BakeMethod method : {BakeMethod::automatic, BakeMethod::flow}) {
    std::atomic<bool> cancel = false;
    BakeContext context;
    context.cancel = &cancel;
    BakeOptions options = with_faces({100, 40}, 2, method);
    options.energy_inflate = options.energy_final = std::make_shared<Cancelling>(cancel);
    options.keep_partial = true;
    EXPECT_THROW(bake(sphere(3), options, context), Cancelled);
    EXPECT_TRUE(cancel);
    // Before the flow of the second level.
    cancel = false;
    options = with_faces({100, 40}, 2, method);
    options.decimator = [&](const TriangleMesh& finer, const TriangleMesh& undeformed, std::int64_t faces) {
      cancel = faces == 40;
      return regular_decimator()(finer, undeformed, faces);
    };
    EXPECT_THROW(bake(sphere(3), options, context), Cancelled);
  }
}

TEST(BakeFlow, WithoutTimeNoSecondMethodIsTried) {
  bool called = false;
  BakeOptions options = with_faces({100, 40}, 2, BakeMethod::automatic);
  options.time_limit = 1e-9;
  options.decimator = [&](const TriangleMesh&, const TriangleMesh&, std::int64_t) -> TriangleMesh {
    called = true;
    throw Error("out of time");
  };
  const SourceMesh source = sanitize(sphere(3));
  const CageHierarchy cages = bake(source, options, {});
  EXPECT_FALSE(called);
  EXPECT_TRUE(cages.truncated);
  expect_certified(cages, source);
}

TEST(BakeFlow, TheSecondMethodIsGivenUpWhenTimeIsUp) {
  BakeOptions options = with_faces({40}, 2, BakeMethod::automatic);
  options.time_limit = 0.3;
  options.decimator = [](const TriangleMesh& finer, const TriangleMesh& undeformed, std::int64_t faces) {
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    return regular_decimator()(finer, undeformed, faces);
  };
  const SourceMesh source = sanitize(sphere(2));
  const CageHierarchy cages = bake(source, options, {});
  EXPECT_TRUE(cages.truncated);
  expect_certified(cages, source);
  EXPECT_NE(cages.levels[0].certificate.method, Method::flow);
}

TEST(BakeFlow, OptionsAreRecordedWhereTheyMatter) {
  const auto keys = [](BakeMethod method) {
    std::vector<std::string> found;
    const nlohmann::json json = nlohmann::json::parse(bake(sphere(2), with_faces({16}, 2, method)).options);
    for (const auto& [key, value] : json.items()) found.push_back(key);
    return found;
  };
  EXPECT_EQ(keys(BakeMethod::collapse), (std::vector<std::string>{"faces", "method", "min_clearance", "topology"}));
  const std::vector<std::string> all = {"energy_final",  "energy_inflate", "faces",   "method",
                                        "min_clearance", "path",           "topology"};
  EXPECT_EQ(keys(BakeMethod::flow), all);
  EXPECT_EQ(keys(BakeMethod::automatic), all);
}

TEST(BakeFlow, RefusesContradictions) {
  const auto with = [&](auto change) {
    BakeOptions options;
    change(options);
    return message(sphere(2), options);
  };
  const std::vector<TriangleMesh> coarse = {scaled(sphere(1), 1.5)};
  const auto refuses = [](const std::string& text, const std::string& one, const std::string& other) {
    EXPECT_TRUE(text.find(one) != std::string::npos && text.find(other) != std::string::npos) << text;
  };
  refuses(with([&](BakeOptions& o) { o.coarse = coarse, o.method = BakeMethod::collapse; }), "collapse", "coarse");
  refuses(with([&](BakeOptions& o) { o.coarse = coarse, o.faces = {8}; }), "coarse", "faces");
  refuses(with([&](BakeOptions& o) { o.coarse = coarse, o.ratio = 0.5; }), "coarse", "ratio");
  refuses(with([&](BakeOptions& o) { o.coarse = coarse, o.level_count = 2; }), "coarse", "levels");
  refuses(with([&](BakeOptions& o) { o.coarse = coarse, o.decimator = regular_decimator(); }), "coarse", "decimator");
  refuses(with([&](BakeOptions& o) { o.coarse = coarse, o.coarse_names = {"a", "b"}; }), "1 coarse", "2 names");
  refuses(with([&](BakeOptions& o) { o.coarse_names = {"a"}; }), "coarse", "names");
  refuses(with([](BakeOptions& o) { o.decimator_name = "mine"; }), "'mine'", "without a decimator");
  refuses(with([](BakeOptions& o) { o.method = BakeMethod::collapse, o.decimator = adaptive_decimator(); }), "collapse",
          "decimator");
  refuses(with([](BakeOptions& o) { o.method = BakeMethod::collapse, o.energy_final = step_energy(); }), "collapse",
          "energy");
}

}  // namespace
}  // namespace encage
