// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/writer.h"
#include "src/files/atomic_file.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace encage {

namespace {

bool same_mesh(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices.rows() == b.vertices.rows() && a.triangles.rows() == b.triangles.rows() &&
         a.vertices == b.vertices && a.triangles == b.triangles;
}

bool same_cages(const CageHierarchy& a, const CageHierarchy& b) {
  return a.origin == b.origin &&
         std::equal(a.levels.begin(), a.levels.end(), b.levels.begin(), b.levels.end(),
                    [](const CageLevel& x, const CageLevel& y) { return same_mesh(x.mesh, y.mesh); });
}

}  // namespace

void write_certified_asset(const std::filesystem::path& file, const CageHierarchy& hierarchy) {
  write_atomically(file, encode_asset(hierarchy, file.string()), [&](const std::filesystem::path& written) {
    CageHierarchy read;
    try {
      read = read_asset(written, Verify::all);
    } catch (const Error& error) {
      throw Error(file.string() + ": what was written cannot be read back: " + error.what());
    }
    if (!same_cages(read, hierarchy)) {
      throw Error(file.string() +
                  ": what was written, read back, differs from the certified cages: the hierarchy is not "
                  "as bake() returned it (vertices exact in float32), or the medium is damaged");
    }
  });
}

}  // namespace encage
