// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/coarse_meshes.h"

#include "cagegen/certify/certify.h"
#include "src/mesh/rounding.h"

#include <string>
#include <utility>

namespace encage {

namespace {

/// The certificate speaks of "cage triangle 3"; here it is no cage yet.
std::string without_cage(std::string reason) {
  const std::string word = "cage ";
  for (std::size_t i = 0; (i = reason.find(word, i)) != std::string::npos;) reason.erase(i, word.size());
  return reason;
}

}  // namespace

std::vector<TriangleMesh> local_coarse_meshes(const BakeOptions& options, const SourceMesh& source) {
  std::vector<TriangleMesh> local;
  for (std::size_t i = 0; i < options.coarse.size(); ++i) {
    TriangleMesh mesh = options.coarse[i];
    mesh.vertices.rowwise() -= source.origin.transpose();
    round_vertices(mesh);
    local.push_back(std::move(mesh));
    const CertifyResult proof = certify_alone(local.back());
    if (proof.holds) continue;
    const std::string name = options.coarse_names.empty() ? "" : " '" + options.coarse_names[i] + "'";
    throw Error("level " + std::to_string(i + 1) + ": the coarse mesh" + name + ": " + without_cage(proof.reason));
  }
  return local;
}

Decimator checked_decimator(const Decimator& decimator, const std::string& name) {
  if (!decimator) return {};
  return [=](const TriangleMesh& finer, const TriangleMesh& undeformed, std::int64_t faces) {
    TriangleMesh mesh = decimator(finer, undeformed, faces);
    const std::string what = "the decimator" + (name.empty() ? "" : " '" + name + "'") + ": ";
    if (mesh.triangles.rows() > faces) {
      throw Error(what + "made " + std::to_string(mesh.triangles.rows()) + " triangles of at most " +
                  std::to_string(faces));
    }
    round_vertices(mesh);
    const CertifyResult proof = certify_alone(mesh);
    if (!proof.holds) throw Error(what + without_cage(proof.reason));
    return mesh;
  };
}

}  // namespace encage
