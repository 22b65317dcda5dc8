// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/aligned_bytes.h"
#include "src/asset/view.h"
#include "tests/fuzz/fuzz.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

using namespace encage;

namespace {

void check(const MeshView& mesh) {
  for (const auto& vertex : mesh.vertices) {
    for (const float x : vertex) fuzz::require(std::isfinite(x), "a coordinate is not finite");
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      fuzz::require(corner < mesh.vertices.size(), "a vertex index is out of range");
    }
  }
}

/// What load_shape() and read_asset() do with a view.
void use(const AssetView& view) {
  for (std::size_t k = 0; k < view.level_count(); ++k) {
    check(view.cage(k));
    view.cage_arrays(k);
  }
  view.verify_fine();
  if (const auto fine = view.fine()) {
    check(*fine);
    view.fine_arrays();
  }
  if (!view.has_description()) return;
  const CageHierarchy hierarchy = copy_hierarchy(view);
  fuzz::require(hierarchy.levels.size() == view.level_count(), "another number of levels");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  begins_like_asset(bytes);
  const AlignedBytes aligned(bytes);
  const auto read = [&](Verify verify, AssetParts parts) {
    return fuzz::reads(fuzz::memory_for(size), [&] { use(AssetView(aligned.span(), "fuzz.glb", verify, parts)); });
  };
  const bool loaded = read(Verify::cages, AssetParts::arrays);  // by the index, if there is one, else by the JSON
  const bool verified = read(Verify::all, AssetParts::all);     // by the JSON, which the index has to agree with
  fuzz::require(loaded || !verified, "refused, but not if every byte is verified");
  return 0;
}
