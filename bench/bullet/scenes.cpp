// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scenes.h"

#include "bench/bullet/scene_meshes.h"
#include "bench/common/report.h"
#include "bench/octopus/octopus.h"
#include "src/mesh/portable_trig.h"

#include <encage/distance.h>
#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace encage::bullet_bench {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

/// Reproducible on every machine, unlike the standard library's distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double share() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  double within(double bound) { return bound * (2 * share() - 1); }
  /// Uniform over the rotations: Shoemake, "Uniform random rotations", Graphics Gems III.
  Eigen::Quaterniond rotation() {
    const double part = share(), low = std::sqrt(1 - part), high = std::sqrt(part);
    const SinCos first = sincos_turns(share()), second = sincos_turns(share());
    return {high * second.cos, low * first.sin, low * first.cos, high * second.sin};
  }

 private:
  std::mt19937_64 bits_;
};

Eigen::Matrix3d turned(double turns, int axis) {
  const SinCos turn = sincos_turns(turns);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  r(u, u) = r(v, v) = turn.cos;
  r(v, u) = turn.sin;
  r(u, v) = -turn.sin;
  return r;
}

Isometry3d pose(const Eigen::Matrix3d& rotation, const Vector3d& position) {
  Isometry3d p = Isometry3d::Identity();
  p.linear() = rotation;
  p.translation() = position;
  return p;
}

/// The chain's links lie in planes through z, alternately through x and y.
Isometry3d link_pose(int link, double height) {
  return pose(turned(link % 2 == 0 ? 0 : 0.25, 2) * turned(0.25, 0), {0, 0, height});
}

/// The first separation, from `apart` to `overlapping`, at which two bodies touch.
template <class Place>
double touching_at(const TriangleMesh& mesh, double apart, double overlapping, const Place& place) {
  const ShapePtr shape = make_shape(mesh);
  for (int k = 0; k < 40; ++k) {
    const double middle = (apart + overlapping) / 2;
    const auto [a, b] = place(middle);
    const bool free = distance(*shape, Motion::resting(a), *shape, Motion::resting(b)).lower > 0;
    (free ? apart : overlapping) = middle;
  }
  return apart;
}

double tilt_degrees(const Isometry3d& p) {
  return std::acos(std::clamp(p.linear()(2, 2), -1.0, 1.0)) * 180 / std::numbers::pi;
}

Scene chain() {
  constexpr int links = 10;
  constexpr double slack = 0.005;
  Scene scene;
  scene.name = "chain";
  scene.meshes = {make_torus()};
  scene.seeds = {1, 2, 3};
  const double pitch = taut_pitch(scene.meshes[0]);
  scene.place = [pitch](std::uint64_t seed) {
    Random random(seed);
    std::vector<SceneBody> bodies;
    for (int i = 0; i < links; ++i) {
      SceneBody& body = bodies.emplace_back(SceneBody{0, link_pose(i, -i * (pitch - slack)), i > 0});
      if (i > 0) body.pose.translation() += Vector3d(random.within(1e-4), random.within(1e-4), 0);
    }
    return bodies;
  };
  scene.judge = [pitch](const SceneHistory& history) {
    const std::size_t count = std::min<std::size_t>(steps_per_second, history.poses.size());
    double length = 0;
    for (std::size_t k = history.poses.size() - count; k < history.poses.size(); ++k) {
      const auto& now = history.poses[k];
      length += (now.back().translation() - now.front().translation()).norm() / static_cast<double>(count);
    }
    const double right = pitch * (links - 1);
    const double percent = 100 * (length / right - 1);
    return Verdict{std::abs(percent) <= 0.5,
                   bench::format("length in the last second %+.2f %% of %.3f m", percent, right), percent};
  };
  return scene;
}

Scene bowls(const std::string& name, double thickness) {
  constexpr int count = 6;
  constexpr double gap = 0.02;
  Scene scene;
  scene.name = name;
  scene.meshes = {make_bowl({.thickness = thickness})};
  scene.planes = {{Vector3d::UnitZ(), 0}};
  scene.seeds = {1, 2, 3};
  const double pitch = nested_pitch(scene.meshes[0]);
  scene.place = [pitch](std::uint64_t seed) {
    Random random(seed);
    std::vector<SceneBody> bodies;
    for (int i = 0; i < count; ++i) {
      const double yaw = random.share(), x = random.within(0.004), y = random.within(0.004);
      bodies.push_back({0, pose(turned(yaw, 2), {x, y, gap / 2 + i * (pitch + gap)})});
    }
    return bodies;
  };
  scene.judge = [pitch](const SceneHistory& history) {
    const auto& end = history.poses.back();
    double aside = 0, off = 0, tilt = 0;
    for (std::size_t i = 0; i < end.size(); ++i) {
      tilt = std::max(tilt, tilt_degrees(end[i]));
      if (i == 0) continue;
      const Vector3d step = end[i].translation() - end[i - 1].translation();
      aside = std::max(aside, step.head<2>().norm());
      off = std::max(off, std::abs(step.z() - pitch));
    }
    const bool holds = aside < 0.05 && off < pitch / 2 && tilt < 5;
    return Verdict{holds,
                   bench::format("from the one below: height %.1f mm off, %.1f mm aside; tilt %.2f degrees", 1e3 * off,
                                 1e3 * aside, tilt),
                   1e3 * off};
  };
  return scene;
}

Scene heap(std::int64_t triangles) {
  static constexpr int side = 3, layers = 2;
  static constexpr double spacing = 2.1, floor_half_width = 1, lowest = 2.8, overlap = 0.01;
  Scene scene;
  scene.name = "heap";
  scene.meshes = {octopus::make_octopus(triangles)};
  scene.planes = {{Vector3d::UnitZ(), 0}};
  for (int axis = 0; axis < 2; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      // Slopes of 45 degrees gather the bodies in a pit: on an even floor most would lie beside each other.
      const Vector3d normal = (Vector3d::UnitZ() + sign * Vector3d::Unit(axis)) / std::numbers::sqrt2;
      scene.planes.push_back({normal, -floor_half_width / std::numbers::sqrt2});
    }
  }
  scene.seeds = {5, 7, 11};
  scene.place = [](std::uint64_t seed) {
    Random random(seed);
    std::vector<SceneBody> bodies;
    for (int i = 0; i < side * side * layers; ++i) {
      Vector3d at(i % side - 1, i / side % side - 1, i / side / side);
      at = spacing * at + Vector3d(0, 0, lowest);
      for (int k = 0; k < 3; ++k) at[k] += random.within(0.04);
      bodies.push_back({0, pose(random.rotation().normalized().toRotationMatrix(), at)});
    }
    return bodies;
  };
  scene.judge = [](const SceneHistory& history) {
    const double depth = history.end_penetration;
    return Verdict{depth <= overlap, bench::format("deepest overlap at the end %.1f mm", 1e3 * depth), 1e3 * depth};
  };
  return scene;
}

/// Angle about z from one pose to another, the short way.
double yaw_between(const Isometry3d& from, const Isometry3d& to) {
  const Eigen::Matrix3d r = to.linear() * from.linear().transpose();
  return std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1));
}

Scene nut(const std::string& name, double friction) {
  const Thread thread;
  static constexpr int bolt_turns = 10, start_turns = 7;
  static constexpr std::size_t settled = steps_per_second / 2;
  Scene scene;
  scene.name = name;
  scene.friction = friction;
  scene.seconds = 5;
  scene.meshes = {make_bolt(thread, bolt_turns, 44, 24), make_nut(thread, 5, 60, 52, 0.5)};
  scene.seeds = {1, 2, 3};
  scene.place = [thread](std::uint64_t seed) {
    // On the thread from the start, at any angle.
    const double turns = Random(seed).share();
    const double height = thread.pitch * (start_turns + turns);
    return std::vector<SceneBody>{{0, Isometry3d::Identity(), false}, {1, pose(turned(turns, 2), {0, 0, height})}};
  };
  scene.judge = [thread, friction](const SceneHistory& history) {
    const auto& poses = history.poses;
    // The nut first falls by the thread's play.
    const std::size_t from = std::min(settled, poses.size() - 1);
    double angle = 0;
    for (std::size_t i = from; i + 1 < poses.size(); ++i) angle += yaw_between(poses[i][1], poses[i + 1][1]);
    const double sunk = poses[from][1].translation().z() - poses.back()[1].translation().z();
    const double threads = -angle / (2 * std::numbers::pi) * thread.pitch;
    if (friction > 0) {
      return Verdict{std::abs(sunk) < 0.01 * thread.pitch, bench::format("sank %.2f mm", 1e3 * sunk), 1e3 * sunk};
    }
    const double percent = threads > 0 ? 100 * (sunk / threads - 1) : 0;
    return Verdict{threads > thread.pitch && std::abs(percent) <= 0.5,
                   bench::format("sank %.4f m, its thread says %.4f", sunk, threads), percent};
  };
  return scene;
}

Scene crates() {
  constexpr int stacks = 3, high = 4;
  constexpr double gap = 0.06;
  const Crate crate;
  Scene scene;
  scene.name = "crates";
  scene.meshes = {make_crate(crate)};
  scene.planes = {{Vector3d::UnitZ(), 0}};
  scene.seeds = {1, 2, 3};
  scene.place = [crate](std::uint64_t seed) {
    Random random(seed);
    std::vector<SceneBody> bodies;
    for (int i = 0; i < stacks * high; ++i) {
      const int level = i % high;
      const Vector3d at((i / high) * (crate.length + 0.05) + random.within(0.002), random.within(0.002),
                        gap / 2 + level * (crate.pitch() + gap));
      bodies.push_back({0, pose(turned(random.within(0.0003), 2), at)});
    }
    return bodies;
  };
  scene.judge = [crate](const SceneHistory& history) {
    const auto& end = history.poses.back();
    double aside = 0, off = 0, tilt = 0;
    for (std::size_t i = 0; i < end.size(); ++i) {
      tilt = std::max(tilt, tilt_degrees(end[i]));
      if (i % high == 0) continue;
      const Vector3d step = end[i].translation() - end[i - 1].translation();
      aside = std::max(aside, step.head<2>().norm());
      off = std::max(off, std::abs(step.z() - crate.pitch()));
    }
    const bool holds = aside < 2 * crate.clearance && off < crate.foot / 2 && tilt < 2;
    return Verdict{holds,
                   bench::format("from the one below: height %.1f mm off, %.1f mm aside; tilt %.2f degrees", 1e3 * off,
                                 1e3 * aside, tilt),
                   1e3 * off};
  };
  return scene;
}

}  // namespace

double taut_pitch(const TriangleMesh& link) {
  const double size = bounds(link).sizes().maxCoeff();
  return touching_at(link, size / 2, size,
                     [](double pitch) { return std::pair(link_pose(0, 0), link_pose(1, -pitch)); });
}

double nested_pitch(const TriangleMesh& bowl) {
  return touching_at(bowl, 2 * bounds(bowl).sizes().z(), 0, [](double pitch) {
    return std::pair(Isometry3d::Identity(), pose(Eigen::Matrix3d::Identity(), {0, 0, pitch}));
  });
}

std::vector<std::string> scene_names() {
  return {"chain", "bowls", "thin_bowls", "heap", "nut", "nut_friction", "crates"};
}

Scene make_contact_scene(const std::string& name, std::int64_t octopus_triangles) {
  if (name == "chain") return chain();
  if (name == "bowls") return bowls(name, 0.06);
  if (name == "thin_bowls") return bowls(name, 0.02);
  if (name == "heap") return heap(octopus_triangles);
  if (name == "nut") return nut(name, 0);
  if (name == "nut_friction") return nut(name, 0.5);
  if (name == "crates") return crates();
  std::string names;
  for (const std::string& known : scene_names()) names += (names.empty() ? "" : ", ") + known;
  throw Error("scene '" + name + "': there are " + names);
}

}  // namespace encage::bullet_bench
