// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/cage_distance.h"
#include "cagegen/certify/certify.h"
#include "cagegen/certify/nesting.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

namespace encage {
namespace {

/// Sums may be associated differently by another version of the library.
constexpr double sum_tolerance = 1e-9;

bool about_equal(double a, double b) { return std::abs(a - b) <= sum_tolerance * std::max(std::abs(a), std::abs(b)); }

std::string text(double x) {
  std::ostringstream out;
  out.precision(9);
  out << x;
  return out.str();
}

bool is_float32(const Vertices& vertices) {
  for (Eigen::Index i = 0; i < vertices.size(); ++i) {
    const double x = vertices.data()[i];
    // Through memory: g++ 12.2 has been seen to drop the conversion for some of several lanes.
    volatile const float rounded = static_cast<float>(x);
    if (static_cast<double>(rounded) != x) return false;
  }
  return true;
}

class Checker {
 public:
  Checker(const CageHierarchy& hierarchy, const SourceMesh* source) : hierarchy_(hierarchy), source_(source) {}

  CheckReport run() {
    if (source_) check_source();
    if (hierarchy_.levels.empty()) add("levels", CheckVerdict::refuted, "the hierarchy has no cage");
    for (std::size_t i = 0; i < hierarchy_.levels.size(); ++i) check_level(i);
    return std::move(report_);
  }

 private:
  void add(std::string subject, CheckVerdict verdict, std::string detail) {
    report_.checks.push_back({std::move(subject), verdict, std::move(detail)});
  }

  void add(std::string subject, bool holds, std::string detail) {
    add(std::move(subject), holds ? CheckVerdict::holds : CheckVerdict::refuted, std::move(detail));
  }

  // ---- The source ----

  void check_source() {
    const bool same = hierarchy_.source_hash == source_->hash;
    add("source hash", same,
        same ? to_string(source_->hash)
             : "the asset was made from " + to_string(hierarchy_.source_hash) + ", the source has " +
                   to_string(source_->hash));
    check_description();
    if (hierarchy_.fine.triangles.rows() > 0) check_fine();
  }

  void check_description() {
    std::string wrong;
    if (hierarchy_.origin != source_->origin) wrong += " origin";
    if (hierarchy_.solid != source_->solid) wrong += " solid";
    if (hierarchy_.cap_count != source_->cap_count) wrong += " cap_count";
    if (!about_equal(hierarchy_.source_volume, source_->volume)) wrong += " source_volume";
    if (!about_equal(hierarchy_.diagonal, source_->diagonal)) wrong += " diagonal";
    add("source description", wrong.empty(),
        wrong.empty() ? name(hierarchy_.solid) + (", volume " + text(hierarchy_.source_volume))
                      : "stored and source differ in:" + wrong);
  }

  /// The stored fine mesh must be the source, moved by no more than it says.
  void check_fine() {
    const TriangleMesh& fine = hierarchy_.fine;
    const TriangleMesh& obstacle = source_->obstacle;
    if (fine.triangles.rows() != obstacle.triangles.rows() || fine.triangles != obstacle.triangles ||
        fine.vertices.rows() != obstacle.vertices.rows()) {
      return add("fine mesh", CheckVerdict::refuted, "its triangles are not those of the source");
    }
    const double error = std::sqrt((fine.vertices - obstacle.vertices).rowwise().squaredNorm().maxCoeff());
    add("fine mesh", error <= hierarchy_.fine_error,
        "its vertices are within " + text(error) + " of the source, fine_error is " + text(hierarchy_.fine_error));
  }

  // ---- Levels ----

  void check_level(std::size_t i) {
    const TriangleMesh& cage = hierarchy_.levels[i].mesh;
    const std::string level = "level " + std::to_string(i + 1);
    if (!is_float32(cage.vertices)) add(level + " vertices", CheckVerdict::refuted, "not all are float32 values");
    if (i > 0) {
      // A cage is a solid, whatever the source was.
      return check_nesting(level, i, certify(hierarchy_.levels[i - 1].mesh, Solid::closed, cage),
                           "level " + std::to_string(i), 0);
    }
    if (source_) return check_nesting(level, i, certify(source_->obstacle, source_->solid, cage), "the source", 0);
    check_first_without_source(level);
  }

  void check_first_without_source(const std::string& level) {
    const CageLevel& first = hierarchy_.levels[0];
    if (hierarchy_.fine.triangles.rows() == 0) {
      return check_alone(level, "no fine mesh is stored: nesting is proven only with --source");
    }
    // A claim within the rounding of the fine mesh can neither be confirmed nor refuted by it.
    if (!(first.certificate.clearance > hierarchy_.fine_error)) {
      return check_alone(level, "the clearance " + text(first.certificate.clearance) + " is within the error " +
                                    text(hierarchy_.fine_error) +
                                    " of the stored fine mesh: nesting is proven only with --source");
    }
    check_nesting(level, 0, certify(hierarchy_.fine, hierarchy_.solid, first.mesh), "the stored fine mesh",
                  hierarchy_.fine_error);
  }

  /// `error`: how far `finer` may be from what the certificate speaks of.
  void check_nesting(const std::string& level, std::size_t i, const CertifyResult& proven, const std::string& finer,
                     double error) {
    if (!proven.holds) return add(level + " nesting", CheckVerdict::refuted, proven.reason);
    const double clearance = proven.certificate.clearance;
    const std::string detail = std::to_string(hierarchy_.levels[i].mesh.triangles.rows()) + " triangles around " +
                               finer + ", clearance " + text(clearance);
    if (clearance > error) {
      add(level + " nesting", CheckVerdict::holds, detail);
    } else {
      add(level + " nesting", CheckVerdict::unproven, detail + " is within its error: proven only with --source");
    }
    check_certificate(level, i, proven.certificate, true, error);
  }

  void check_alone(const std::string& level, const std::string& why) {
    const CertifyResult proven = certify_alone(hierarchy_.levels[0].mesh);
    if (!proven.holds) return add(level + " nesting", CheckVerdict::refuted, proven.reason);
    add(level + " nesting", CheckVerdict::unproven, why);
    check_certificate(level, 0, proven.certificate, false, 0);
  }

  void check_certificate(const std::string& level, std::size_t i, const Certificate& proven, bool nested,
                         double error) {
    const Certificate& stored = hierarchy_.levels[i].certificate;
    std::string wrong;
    if (!(stored.clearance > 0)) wrong += " clearance";
    // The claim is a lower bound: wrong only if it is more than the distance can be.
    if (nested && stored.clearance > largest_distance(i, proven) + error) wrong += " clearance";
    if (nested && stored.no_new_handles != proven.no_new_handles) wrong += " no_new_handles";
    if (!about_equal(stored.volume, proven.volume)) wrong += " volume";
    if (!ratio_is_right(stored)) wrong += " volume_ratio";
    check_distances(i, wrong);
    if (stored.components != proven.components) wrong += " components";
    if (stored.cavities != proven.cavities) wrong += " cavities";
    if (stored.genus != proven.genus) wrong += " genus";
    add(level + " certificate", wrong.empty(),
        wrong.empty() ? "volume " + text(proven.volume) + ", components " + std::to_string(proven.components) +
                            ", cavities " + std::to_string(proven.cavities) + ", genus " + std::to_string(proven.genus)
                      : "stored and proven values differ in:" + wrong);
  }

  /// The claims are upper bounds: wrong if they are below what is proven.
  void check_distances(std::size_t i, std::string& wrong) {
    const Certificate& stored = hierarchy_.levels[i].certificate;
    if (!source_ || (!stored.max_distance && !stored.mean_distance)) return;
    if (!surface_) surface_.emplace(source_->obstacle);
    const DistanceBounds proven = proof::distance_bounds(*surface_, hierarchy_.levels[i].mesh);
    const auto below = [](const std::optional<double>& claim, double bound) {
      return claim && *claim < bound && !about_equal(*claim, bound);
    };
    if (below(stored.max_distance, proven.max_distance)) wrong += " max_distance";
    if (below(stored.mean_distance, proven.mean_distance)) wrong += " mean_distance";
  }

  /// What the distance of the surfaces can be at most, given a proven clearance.
  double largest_distance(std::size_t i, const Certificate& proven) const {
    const double extent = bounds(hierarchy_.levels[i].mesh).sizes().maxCoeff();
    return (proven.clearance + proof::clearance_rounding * extent) / (1 - proof::clearance_slack);
  }

  bool ratio_is_right(const Certificate& stored) const {
    if (hierarchy_.solid == Solid::surface_only || !(hierarchy_.source_volume > 0)) return !stored.volume_ratio;
    return stored.volume_ratio && about_equal(*stored.volume_ratio, stored.volume / hierarchy_.source_volume);
  }

  const CageHierarchy& hierarchy_;
  const SourceMesh* source_;
  std::optional<proof::DistanceSurface> surface_;  ///< of the source, once it is needed
  CheckReport report_;
};

}  // namespace

const char* name(CheckVerdict verdict) noexcept {
  switch (verdict) {
    case CheckVerdict::holds: return "holds";
    case CheckVerdict::refuted: return "refuted";
    case CheckVerdict::unproven: return "unproven";
  }
  return "";
}

bool CheckReport::holds() const {
  return std::all_of(checks.begin(), checks.end(),
                     [](const Check& check) { return check.verdict == CheckVerdict::holds; });
}

CheckReport check_asset(const CageHierarchy& hierarchy, const SourceMesh* source) {
  return Checker(hierarchy, source).run();
}

}  // namespace encage
