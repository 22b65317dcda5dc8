// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/bake.h>
#include <encage/encage.h>

#include <cstdio>
#include <exception>

namespace {

// A box of n x n squares a side, in triangles.
encage::TriangleMesh box(int n) {
  encage::TriangleMesh mesh;
  mesh.vertices.resize(6 * (n + 1) * (n + 1), 3);
  mesh.triangles.resize(12 * n * n, 3);
  int vertex = 0;
  int triangle = 0;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const bool upper = side % 2 == 1;
    const int u = (axis + (upper ? 1 : 2)) % 3;
    const int v = (axis + (upper ? 2 : 1)) % 3;
    const int first = vertex;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j, ++vertex) {
        mesh.vertices(vertex, axis) = upper ? n : 0;
        mesh.vertices(vertex, u) = i;
        mesh.vertices(vertex, v) = j;
      }
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const int corner = first + i * (n + 1) + j;
        mesh.triangles.row(triangle++) << corner, corner + n + 1, corner + n + 2;
        mesh.triangles.row(triangle++) << corner, corner + n + 2, corner + 1;
      }
    }
  }
  return mesh;
}

bool run() {
  const encage::TriangleMesh mesh = box(4);
  const encage::CageHierarchy hierarchy =
      encage::bake(mesh, {.faces = {48}, .method = encage::BakeMethod::collapse, .threads = 1});
  const bool holds = encage::check_asset(hierarchy).holds();

  const encage::ShapePtr shape = encage::make_shape(hierarchy);
  encage::Motion away;
  away.start.translation().y() = away.end.translation().y() = 4.5;
  const bool apart = encage::separated(*shape, encage::Motion{}, *shape, away).separated;

  bool caught = false;
  try {
    encage::bake(encage::TriangleMesh{}, {});
  } catch (const encage::Error&) {
    caught = true;
  }
  std::printf("Encage: %zu cages, they hold %d, apart %d, error caught %d\n", hierarchy.levels.size(), holds, apart,
              caught);
  return hierarchy.levels.size() == 1 && holds && apart && caught;
}

}  // namespace

// The offline side, linked in whatever way: bakes a small box, proves its cage and asks the run time about it.
int main() {
  try {
    return run() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
