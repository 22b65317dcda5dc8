// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/assets/base_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

namespace encage::assets {
namespace {

using Vector = Eigen::Vector3d;

struct Spike {
  Vector direction;
  double length;
  double sharpness;
};

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

std::vector<Spike> make_arms(std::mt19937& random) {
  std::vector<Spike> arms(6 + random() % 9);
  for (Spike& arm : arms) {
    do {
      for (int k = 0; k < 3; ++k) arm.direction[k] = uniform(random, -1, 1);
    } while (arm.direction.norm() > 1 || arm.direction.norm() < 0.1);
    arm.direction.normalize();
    arm.length = uniform(random, 0.3, 0.6);
    arm.sharpness = uniform(random, 10, 30);
  }
  return arms;
}

/// Rational, as libm's functions differ between machines.
double radius(const std::vector<Spike>& arms, const Vector& direction) {
  double sum = 0.3;
  for (const Spike& arm : arms) {
    const double near = 1 / (1 + arm.sharpness * (1 - arm.direction.dot(direction)) / 4);
    sum += arm.length * near * near * near * near;
  }
  return sum;
}

/// Faces of an octahedron in `frequency` squared triangles each.
class Sphere {
 public:
  explicit Sphere(int frequency) : frequency_(frequency) {
    for (int octant = 0; octant < 8; ++octant) add_face(octant);
  }
  std::vector<std::array<int, 3>> points;  // whose sizes add up to the frequency
  std::vector<std::array<std::int32_t, 3>> triangles;

 private:
  void add_face(int octant) {
    const auto point = [&](int i, int j) {
      std::array<int, 3> p{i, j, frequency_ - i - j};
      for (int k = 0; k < 3; ++k) {
        if ((octant >> k & 1) != 0) p[k] = -p[k];
      }
      const auto [at, added] = index_.try_emplace(p, static_cast<std::int32_t>(points.size()));
      if (added) points.push_back(p);
      return at->second;
    };
    const bool mirrored = ((octant ^ octant >> 1 ^ octant >> 2) & 1) != 0;
    const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
      triangles.push_back(mirrored ? std::array{a, c, b} : std::array{a, b, c});
    };
    for (int i = 0; i < frequency_; ++i) {
      for (int j = 0; i + j < frequency_; ++j) {
        add(point(i, j), point(i + 1, j), point(i, j + 1));
        if (i + j + 1 < frequency_) add(point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
      }
    }
  }

  int frequency_;
  std::map<std::array<int, 3>, std::int32_t> index_;
};

}  // namespace

TriangleMesh make_base_mesh(int number, int triangles) {
  std::mt19937 random(static_cast<std::uint32_t>(number) + 1);
  const auto middle = static_cast<unsigned>(std::sqrt(triangles / 8.0));
  const Sphere sphere(static_cast<int>(middle * 9 / 10 + random() % (middle / 5 + 1)));
  const std::vector<Spike> arms = make_arms(random);
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(sphere.points.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(sphere.triangles.size()), 3);
  for (std::size_t v = 0; v < sphere.points.size(); ++v) {
    const Vector direction = Eigen::Map<const Eigen::Vector3i>(sphere.points[v].data()).cast<double>().normalized();
    const Eigen::Vector3f place = (radius(arms, direction) * direction).cast<float>();
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = place.cast<double>().transpose();
  }
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(static_cast<Eigen::Index>(t), k) = sphere.triangles[t][k];
  }
  return mesh;
}

}  // namespace encage::assets
