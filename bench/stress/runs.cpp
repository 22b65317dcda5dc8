// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/stress/runs.h"

#include "bench/common/report.h"

#include <encage/decimator.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace encage::stress {

namespace {

using bench::format;

/// `count` numbers of faces that shrink by one factor; all are even, as closed surfaces have them.
std::vector<std::int64_t> shrinking(std::int64_t first, std::int64_t last, int count) {
  std::vector<std::int64_t> faces;
  for (int i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / (count - 1) : 0;
    const double wanted =
        static_cast<double>(first) * std::pow(static_cast<double>(last) / static_cast<double>(first), share);
    std::int64_t even = 2 * std::llround(wanted / 2);
    if (!faces.empty()) even = std::min(even, faces.back() - 2);
    faces.push_back(even);
  }
  return faces;
}

Job layers(std::string name, std::string title, std::string model, std::vector<std::int64_t> faces) {
  Job job;
  job.name = std::move(name);
  job.title = std::move(title);
  job.model = std::move(model);
  job.options.faces = std::move(faces);
  return job;
}

double random_share(std::mt19937& random) { return 2 * (static_cast<double>(random() >> 1) * 0x1p-31) - 1; }

TriangleMesh soup(int count) {
  std::mt19937 random(7);
  const auto point = [&](double size) {
    const double x = random_share(random), y = random_share(random), z = random_share(random);
    return Eigen::Vector3d(size * x, size * y, size * z);
  };
  TriangleMesh mesh;
  mesh.vertices.resize(3 * count, 3);
  mesh.triangles.resize(count, 3);
  for (int t = 0; t < count; ++t) {
    const Eigen::Vector3d centre = point(1);
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.row(3 * t + k) = (centre + point(0.25)).transpose();
      mesh.triangles(t, k) = 3 * t + k;
    }
  }
  return mesh;
}

void append_sphere(TriangleMesh& mesh, const Eigen::Vector3d& centre) {
  constexpr int rings = 24, sectors = 48;
  const auto north = static_cast<std::int32_t>(mesh.vertices.rows());
  const std::int32_t south = north + 1 + (rings - 1) * sectors;
  const auto at = [&](int ring, int sector) { return north + 1 + (ring - 1) * sectors + sector % sectors; };
  mesh.vertices.conservativeResize(south + 1, 3);
  mesh.vertices.row(north) = (centre + Eigen::Vector3d::UnitZ()).transpose();
  mesh.vertices.row(south) = (centre - Eigen::Vector3d::UnitZ()).transpose();
  for (int r = 1; r < rings; ++r) {
    const double polar = std::numbers::pi * r / rings;
    for (int s = 0; s < sectors; ++s) {
      const double azimuth = 2 * std::numbers::pi * s / sectors;
      const Eigen::Vector3d out(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                std::cos(polar));
      mesh.vertices.row(at(r, s)) = (centre + out).transpose();
    }
  }
  Eigen::Index row = mesh.triangles.rows();
  mesh.triangles.conservativeResize(row + 2 * (rings - 1) * sectors, 3);
  for (int s = 0; s < sectors; ++s) {
    mesh.triangles.row(row++) << north, at(1, s), at(1, s + 1);
    mesh.triangles.row(row++) << at(rings - 1, s), south, at(rings - 1, s + 1);
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.triangles.row(row++) << at(r, s), at(r + 1, s), at(r + 1, s + 1);
      mesh.triangles.row(row++) << at(r, s), at(r + 1, s + 1), at(r, s + 1);
    }
  }
}

/// Two unit spheres.
TriangleMesh two_spheres(double gap) {
  TriangleMesh mesh;
  append_sphere(mesh, {0, 0, 0});
  append_sphere(mesh, {2 + gap, 0, 0});
  return mesh;
}

void add_layers(std::vector<Job>& jobs) {
  jobs.push_back(layers("layers25", "25 layers around fandisk", "fandisk", shrinking(2500, 100, 25)));
  jobs.back().beside_single = true;
  jobs.push_back(layers("layers50", "50 layers around armadillo", "armadillo", shrinking(12000, 100, 50)));
  jobs.back().beside_single = true;
  jobs.push_back(
      layers("eight", "Down to eight vertices around bunny00", "bunny00", {4000, 1000, 250, 100, 50, 24, 12}));
}

void add_noise(std::vector<Job>& jobs) {
  for (const double share : {0.001, 0.003, 0.01}) {
    Job job = layers("noise", format("Seven layers around hand, noise of %g diagonals along the normals", share),
                     "hand", shrinking(6000, 100, 7));
    job.make = [share](const TriangleMesh& mesh) { return with_noise(mesh, share * bounds(mesh).diagonal().norm()); };
    jobs.push_back(std::move(job));
  }
}

void add_topology(std::vector<Job>& jobs) {
  const std::array<std::pair<Topology, const char*>, 3> topologies = {
      {{Topology::any, "any"}, {Topology::keep, "keep"}, {Topology::simplify, "simplify"}}};
  for (const auto& [topology, text] : topologies) {
    Job job = layers("genus", format("anchor_dense, --topology %s", text), "anchor_dense", {1000, 300, 100});
    job.options.topology = topology;
    jobs.push_back(std::move(job));
  }
}

void add_energies(std::vector<Job>& jobs) {
  for (const char* energy : {"volume", "start", "sarap", "volume+0.01*sarap"}) {
    Job job =
        layers("energies", format("anchor_dense by flow, --energy-final %s", energy), "anchor_dense", {1000, 300});
    job.options.method = BakeMethod::flow;
    job.options.energy_final = find_energy(energy);
    jobs.push_back(std::move(job));
  }
}

void add_decimators(std::vector<Job>& jobs) {
  for (const char* decimator : {"regular", "adaptive"}) {
    Job job = layers("decimators", format("bunny00 by flow, --decimator %s", decimator), "bunny00", {4000, 1000, 250});
    job.options.method = BakeMethod::flow;
    job.options.decimator = std::string(decimator) == "regular" ? regular_decimator() : adaptive_decimator();
    job.options.decimator_name = decimator;
    jobs.push_back(std::move(job));
  }
}

void add_soup(std::vector<Job>& jobs) {
  Job job = layers("soup", "A soup of 400 triangles that cross each other", "", {600, 200, 60});
  job.make = [](const TriangleMesh&) { return soup(400); };
  jobs.push_back(std::move(job));
}

/// Cages of the two spheres need about 0.1 of the gap for their clearance, which is 0.01 diagonals.
void add_pinches(std::vector<Job>& jobs) {
  for (const double gap : {0.3, 0.1, 0.05}) {
    Job job = layers("pinch", format("Two spheres, %g radii apart, by flow at a clearance of 0.01 diagonals", gap), "",
                     {400});
    job.make = [gap](const TriangleMesh&) { return two_spheres(gap); };
    job.options.method = BakeMethod::flow;
    job.options.topology = Topology::keep;
    job.options.min_clearance = 0.01;
    jobs.push_back(std::move(job));
  }
}

}  // namespace

TriangleMesh with_noise(const TriangleMesh& mesh, double amplitude) {
  Vertices normal = Vertices::Zero(mesh.vertices.rows(), 3);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d area = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    for (int k = 0; k < 3; ++k) normal.row(mesh.triangles(t, k)) += area.transpose();
  }
  TriangleMesh result = mesh;
  std::mt19937 random(1);
  for (std::int64_t v = 0; v < normal.rows(); ++v) {
    const double length = normal.row(v).norm(), share = random_share(random);
    if (length > 0) result.vertices.row(v) += amplitude * share / length * normal.row(v);
  }
  return result;
}

std::vector<Job> all_jobs() {
  std::vector<Job> jobs;
  add_layers(jobs);
  add_noise(jobs);
  add_topology(jobs);
  add_soup(jobs);
  add_energies(jobs);
  add_decimators(jobs);
  add_pinches(jobs);
  return jobs;
}

std::vector<std::string> job_names() {
  std::vector<std::string> names;
  for (const Job& job : all_jobs()) {
    if (names.empty() || names.back() != job.name) names.push_back(job.name);
  }
  return names;
}

}  // namespace encage::stress
