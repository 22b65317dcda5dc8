// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/view.h"
#include "src/asset/writer.h"
#include "src/files/atomic_file.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <algorithm>
#include <filesystem>
#include <functional>
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
  const std::string bytes = encode_asset(hierarchy, file.string());
  const auto compare = [&](const std::function<CageHierarchy()>& read) {
    CageHierarchy written;
    try {
      written = read();
    } catch (const Error& error) {
      throw Error(file.string() + ": what was written cannot be read back: " + error.what());
    }
    if (!same_cages(written, hierarchy)) {
      throw Error(file.string() +
                  ": what was written, read back, differs from the certified cages: the hierarchy is not "
                  "as bake() returned it (vertices exact in float32), or the medium is damaged");
    }
  };
  // What goes into a pipe or a device cannot be read back from there.
  if (is_written_through(file)) compare([&] { return decode_asset(bytes, file.string(), Verify::all); });
  write_atomically(file, bytes, [&](const std::filesystem::path& temporary) {
    compare([&] { return read_asset(temporary, Verify::all); });
  });
}

}  // namespace encage
