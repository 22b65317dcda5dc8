// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "broadphase/shape/shape.h"
#include "oracles/sample_shapes.h"
#include "oracles/sampled.h"
#include "src/asset/view.h"
#include "tests/src/asset/forge.h"

#include <encage/asset.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace encage::test {

/// A folder for this test alone, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() { std::filesystem::create_directory(file_.path()); }
  ~TemporaryFolder() { std::filesystem::remove_all(file_.path()); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return file_.path(); }

 private:
  TemporaryFile file_;
};

/// The sample shapes that have both cages and a fine mesh, stored as assets.
struct StoredSamples {
  StoredSamples() {
    for (const Sample& sample : sample_shapes(1e-3)) {
      CageHierarchy h = sample.hierarchy;
      if (h.levels.empty() || h.fine.triangles.rows() == 0) continue;
      h.source_volume = h.solid == Solid::surface_only ? 0 : 1;
      double least = 1e-3;
      for (CageLevel& level : h.levels) {
        Certificate& c = level.certificate;
        c.clearance = 1e-3;
        c.components = 1;
        c.volume = least = std::max(least, signed_volume(level.mesh));
        if (h.source_volume > 0) c.volume_ratio = c.volume;
        c.start = "by hand";
      }
      files.push_back(folder.path() / (sample.name + ".glb"));
      write_asset(files.back(), h);
      sizes_.push_back(AssetView(files.back(), Verify::cages).fine_bytes());
    }
    std::sort(sizes_.begin(), sizes_.end());
  }

  /// The least budget that suffices for all of them.
  std::int64_t room_for_a_pair() const { return sizes_.back() + sizes_[sizes_.size() - 2]; }

  TemporaryFolder folder;
  std::vector<std::filesystem::path> files;

 private:
  std::vector<std::int64_t> sizes_;
};

}  // namespace encage::test
