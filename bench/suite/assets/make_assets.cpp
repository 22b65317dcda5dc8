// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/assets/make_assets.h"

#include "bench/suite/assets/base_mesh.h"
#include "bench/suite/assets/variant.h"

#include <encage/asset.h>
#include <encage/error.h>

#include <cstdio>
#include <optional>
#include <string>

namespace encage::assets {
namespace {

/// Variant 0 is the base itself.
std::filesystem::path name(const std::filesystem::path& folder, const AssetOptions& options, int base, int variant) {
  char text[64];
  std::snprintf(text, sizeof text, "star%d_%03d_%03d.glb", options.triangles, base, variant);
  return folder / text;
}

CageHierarchy read_or_bake(const std::filesystem::path& file, const TriangleMesh& mesh, const BakeContext& context) {
  if (std::filesystem::exists(file)) return read_asset(file);
  BakeOptions options;
  options.faces = {500, 100};
  options.method = BakeMethod::collapse;
  const CageHierarchy hierarchy =
      bake(mesh, options, {.progress = {}, .log = {}, .trace = {}, .cancel = context.cancel});
  write_asset(file, hierarchy);
  return hierarchy;
}

}  // namespace

void make_assets(const std::filesystem::path& folder, const AssetOptions& options, const BakeContext& context) {
  std::filesystem::create_directories(folder);
  const auto [count, bases, triangles] = options;
  int done = 0;
  for (int base = 0; base < bases; ++base) {
    std::optional<TriangleMesh> mesh;
    std::optional<CageHierarchy> hierarchy;
    for (int variant = 0; base + variant * bases < count; ++variant, ++done) {
      if (context.progress) context.progress(static_cast<double>(done) / count, "making assets");
      if (context.cancel && *context.cancel) throw Cancelled();
      const std::filesystem::path file = name(folder, options, base, variant);
      if (std::filesystem::exists(file)) continue;
      if (!mesh) mesh = make_base_mesh(base, triangles);
      if (!hierarchy) hierarchy = read_or_bake(name(folder, options, base, 0), *mesh, context);
      if (variant == 0) continue;
      const Variant v = make_variant(variant);
      write_asset(file, transform(*hierarchy, v, sanitize(transform(*mesh, v)).hash));
    }
  }
}

AssetFiles find_assets(const std::filesystem::path& folder, const AssetOptions& options) {
  const auto [count, bases, triangles] = options;
  AssetFiles found;
  for (int i = 0; i < count; ++i) {
    found.files.push_back(name(folder, options, i % bases, i / bases));
    found.bytes += static_cast<std::int64_t>(std::filesystem::file_size(found.files.back()));
  }
  for (int base = 0; base < bases && base < count; ++base) {
    const int variants = (count - base - 1) / bases + 1;
    found.triangles += variants * make_base_mesh(base, triangles).triangles.rows();
  }
  return found;
}

}  // namespace encage::assets
