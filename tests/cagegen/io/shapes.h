// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/meshes.h"

#include <encage/mesh.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

// Meshes and files that the tests of this folder make.

namespace encage::test {

inline TriangleMesh mesh_of(const std::vector<Eigen::Vector3d>& vertices,
                            const std::vector<Eigen::Vector3i>& triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(v) = vertices[v].transpose();
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(t) = triangles[t].transpose();
  return mesh;
}

/// A closed, outward box; corner number x + 2 y + 4 z.
inline TriangleMesh box(const Eigen::Vector3d& low = Eigen::Vector3d::Zero(),
                        const Eigen::Vector3d& high = Eigen::Vector3d::Ones()) {
  return shapes::box(low, high);
}

/// n x n squares over [0,1]^2 at the given height, two triangles each, facing +z.
inline TriangleMesh sheet(int n, const std::function<double(double, double)>& height) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      vertices.emplace_back(x, y, height(x, y));
      const int a = j * (n + 1) + i;
      if (i == n || j == n) continue;
      triangles.emplace_back(a, a + 1, a + n + 2);
      triangles.emplace_back(a, a + n + 2, a + n + 1);
    }
  }
  return mesh_of(vertices, triangles);
}

inline TriangleMesh inside_out(TriangleMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

/// Side by side; no vertex is shared.
inline TriangleMesh joined(std::initializer_list<TriangleMesh> meshes) {
  TriangleMesh all;
  for (const TriangleMesh& mesh : meshes) {
    const Eigen::Index v = all.vertices.rows(), t = all.triangles.rows();
    all.vertices.conservativeResize(v + mesh.vertices.rows(), 3);
    all.vertices.bottomRows(mesh.vertices.rows()) = mesh.vertices;
    all.triangles.conservativeResize(t + mesh.triangles.rows(), 3);
    all.triangles.bottomRows(mesh.triangles.rows()) = mesh.triangles.array() + static_cast<int>(v);
  }
  return all;
}

inline TriangleMesh with_triangles(TriangleMesh mesh, std::initializer_list<Eigen::Vector3i> triangles) {
  const Eigen::Index t = mesh.triangles.rows();
  mesh.triangles.conservativeResize(t + static_cast<Eigen::Index>(triangles.size()), 3);
  Eigen::Index row = t;
  for (const Eigen::Vector3i& triangle : triangles) mesh.triangles.row(row++) = triangle.transpose();
  return mesh;
}

inline TriangleMesh with_vertex(TriangleMesh mesh, const Eigen::Vector3d& vertex) {
  mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
  mesh.vertices.bottomRows(1) = vertex.transpose();
  return mesh;
}

inline TriangleMesh without_triangles(TriangleMesh mesh, Eigen::Index from, Eigen::Index count) {
  const Triangles all = mesh.triangles;
  mesh.triangles.resize(all.rows() - count, 3);
  mesh.triangles << all.topRows(from), all.bottomRows(all.rows() - from - count);
  return mesh;
}

/// Where the environment says so, fuzzing begins with the files that tests read (scripts/fuzz).
inline void keep_as_seed(const std::string& name, std::string_view bytes) {
  static const char* const seeds = std::getenv("ENCAGE_SEEDS");
  constexpr std::size_t large = 1 << 14;
  const std::string extension = std::filesystem::path(name).extension().string();
  if (seeds == nullptr || bytes.size() > large || extension.empty()) return;
  const std::filesystem::path folder = std::filesystem::path(seeds) / extension.substr(1);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / std::to_string(std::hash<std::string_view>()(bytes)), std::ios::binary) << bytes;
}

/// A folder that goes with the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "encage_io_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ / name, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    keep_as_seed(name, bytes);
    return path_ / name;
  }
  std::size_t file_count() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
  }

 private:
  std::filesystem::path path_;
};

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace encage::test
