// SPDX-License-Identifier: Apache-2.0
#include "src/asset/rules.h"

#include <encage/error.h>

#include <cmath>

namespace encage {
namespace {

void require(bool condition, const std::string& place, const char* reason) {
  if (!condition) throw Error(place + ": " + reason);
}

bool positive(double value) { return std::isfinite(value) && value > 0; }
bool not_negative(double value) { return std::isfinite(value) && value >= 0; }

void check_certificate(const Certificate& c, const std::string& place) {
  require(positive(c.clearance), place, "clearance is not finite and above 0");
  require(positive(c.volume), place, "volume is not finite and above 0");
  require(!c.volume_ratio || positive(*c.volume_ratio), place, "volume_ratio is not finite and above 0");
  require(!c.max_distance || positive(*c.max_distance), place, "max_distance is not finite and above 0");
  require(!c.mean_distance || positive(*c.mean_distance), place, "mean_distance is not finite and above 0");
  require(c.components >= 1, place, "components is below 1");
  require(c.cavities >= 0 && c.cavities < c.components, place, "cavities is not in [0, components)");
  require(c.genus >= 0, place, "genus is negative");
}

}  // namespace

std::string cage_name(std::size_t level) { return "cage " + std::to_string(level + 1); }

void check_description(const CageHierarchy& hierarchy, const std::string& file) {
  require(hierarchy.origin.allFinite(), file, "origin is not finite");
  require(not_negative(hierarchy.source_volume), file, "source_volume is not finite and 0 or more");
  require(positive(hierarchy.diagonal), file, "diagonal is not finite and above 0");
  require(not_negative(hierarchy.fine_error), file, "fine_error is not finite and 0 or more");
  require(hierarchy.cap_count >= 0, file, "cap_count is negative");
  require(!hierarchy.levels.empty(), file, "there is no cage");
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const Certificate& certificate = hierarchy.levels[i].certificate;
    check_certificate(certificate, file + ": " + cage_name(i));
    if (i == 0) continue;
    // Nested cages increase in volume; the slack is far above the rounding of the volumes.
    const double before = hierarchy.levels[i - 1].certificate.volume;
    require(certificate.volume >= before * (1 - 1e-9), file + ": " + cage_name(i),
            "its volume is smaller than that of the cage before: levels must go from fine to coarse");
  }
}

void check_caps(std::int64_t cap_count, std::int64_t fine_triangles, const std::string& file) {
  require(fine_triangles == 0 || cap_count <= fine_triangles, file, "cap_count exceeds the triangles of the source");
}

}  // namespace encage
