// SPDX-License-Identifier: Apache-2.0
#include "src/mesh/mesh_view.h"

#include <encage/error.h>

#include <cmath>

namespace encage {

void check_mesh(const MeshView& mesh, const std::string& place) {
  if (mesh.triangles.empty()) throw Error(place + ": no triangles");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (const float x : mesh.vertices[v]) {
      if (!std::isfinite(x)) throw Error(place + ": vertex " + std::to_string(v) + ": not finite");
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v < mesh.vertices.size()) continue;
      throw Error(place + ": triangle " + std::to_string(t) + ": index " + std::to_string(v) +
                  " is out of range, there are " + std::to_string(mesh.vertices.size()) + " vertices");
    }
  }
}

}  // namespace encage
