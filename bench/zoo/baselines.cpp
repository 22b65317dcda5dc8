// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/baselines.h"

#include "bench/common/clock.h"
#include "bench/zoo/intersections.h"
#include "bench/zoo/plain_methods.h"
#include "cagegen/collapse/starts.h"
#include "src/mesh/rounding.h"

#include <encage/decimator.h>
#include <encage/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace encage::zoo {

namespace {

CertifyResult proof_of(const SourceMesh& source, const TriangleMesh& cage) {
  return certify(source.obstacle, source.solid, cage);
}

/// Runs `make`, which returns no mesh or throws if it fails, and judges what it made.
BaselineResult judged(const char* name, const SourceMesh& source, const std::function<TriangleMesh()>& make) {
  BaselineResult result;
  result.name = name;
  const double start = bench::thread_cpu_seconds();
  TriangleMesh cage;
  try {
    cage = make();
    result.cpu_seconds = bench::thread_cpu_seconds() - start;
    round_vertices(cage);  // as an asset stores it
  } catch (const std::exception& error) {
    result.cpu_seconds = bench::thread_cpu_seconds() - start;
    result.error = error.what();
    return result;
  }
  result.faces = cage.triangles.rows();
  result.hits = touching_triangles(cage, source.obstacle);
  result.self_hits = self_intersecting_triangles(cage);
  if (source.volume > 0) result.volume_ratio = signed_volume(cage) / source.volume;
  const CertifyResult proof = proof_of(source, cage);
  result.certified = proof.holds;
  result.error = proof.reason;
  return result;
}

}  // namespace

BaselineResult single_alpha_wrap(const SourceMesh& source, std::int64_t faces) {
  return judged("alpha wrap", source, [&] {
    TriangleMesh best;
    // From coarse to fine, as fine wraps are slow.
    double coarse = source.diagonal;
    double fine = coarse;
    const auto small = [&](double alpha) {
      TriangleMesh wrap = makers::alpha_wrap(source.clean, alpha, alpha / 12);
      const bool fits = wrap.triangles.rows() > 0 && wrap.triangles.rows() <= faces;
      if (fits) best = std::move(wrap);
      return fits;
    };
    while (fine > source.diagonal / 500 && small(fine)) {
      coarse = fine;
      fine /= 2;
    }
    for (int i = 0; i < 5 && fine < coarse; ++i) {
      const double middle = std::sqrt(fine * coarse);
      (small(middle) ? coarse : fine) = middle;
    }
    if (best.triangles.rows() == 0) throw Error("no alpha gives " + std::to_string(faces) + " faces");
    return best;
  });
}

BaselineResult progressive_hull(const SourceMesh& source, std::int64_t faces) {
  return judged("progressive hull", source, [&] {
    if (!source.manifold) throw Error("the source is not a closed manifold");
    TriangleMesh hull = collapse_outward(source.clean, faces, 1e-6 * source.diagonal);
    if (hull.triangles.rows() > faces) {
      throw Error("no edge of " + std::to_string(hull.triangles.rows()) + " faces can be collapsed any more");
    }
    return hull;
  });
}

BaselineResult offset_contour(const SourceMesh& source, std::int64_t faces) {
  return judged("offset contour", source, [&] {
    // Contours of some ten times the triangles wanted.
    const int cells = std::clamp(static_cast<int>(2 * std::sqrt(static_cast<double>(faces))), 64, 96);
    const double longest = source.diagonal / 8;
    const bool closed = source.manifold && source.solid != Solid::surface_only;
    const DistanceGrid grid(closed ? source.clean : source.obstacle, closed, cells, longest);
    const Decimator decimator = regular_decimator();
    TriangleMesh best;
    // Whether one holds is partly chance, so that no bisection finds the smallest. Unsigned distances bend within a
    // cell of the surface: no contour nearer than that.
    constexpr double step = 1.26;
    for (double distance = closed ? source.diagonal / 512 : grid.cell(); distance <= longest; distance *= step) {
      const TriangleMesh contour = grid.contour(distance);
      try {
        best = decimator(contour, contour, faces);
      } catch (const Error&) {
        continue;  // another contour may have fewer handles
      }
      if (proof_of(source, best).holds) break;
    }
    if (best.triangles.rows() == 0) throw Error("no contour could be decimated to " + std::to_string(faces) + " faces");
    return best;
  });
}

std::span<const PlainMethod> baselines() {
  static constexpr std::array<PlainMethod, 3> all = {
      {{"alpha wrap", single_alpha_wrap}, {"progressive hull", progressive_hull}, {"offset contour", offset_contour}}};
  return all;
}

std::vector<BaselineResult> run_baselines(const SourceMesh& source, std::int64_t faces) {
  std::vector<BaselineResult> results;
  for (const PlainMethod& baseline : baselines()) results.push_back(baseline.run(source, faces));
  return results;
}

}  // namespace encage::zoo
