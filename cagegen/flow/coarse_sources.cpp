// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/coarse_sources.h"

#include "cagegen/collapse/starts.h"
#include "cagegen/decimate/decimate.h"
#include "src/mesh/rounding.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

constexpr std::int64_t dense_faces = 12;  // of the target's: what a decimation begins with
constexpr std::int64_t least_dense = 50'000;
constexpr std::int64_t most_wrapped = 10'000;  // triangles up to which wraps flow too where others compete
constexpr double part_gap = 10;                // clearances between parts of a coarse mesh
constexpr double least_part_gap = 3;           // of large clearances, which leave no room for as many
constexpr double wide_part_gap = 2e-3;         // diagonals; part_gap clearances are less, unless these are large

/// Parts inside others, and voids, are not worth a cage's triangles.
std::optional<TriangleMesh> usable(std::optional<TriangleMesh> mesh) {
  if (!mesh) return std::nullopt;
  *mesh = outermost_components(*mesh);
  if (mesh->triangles.rows() < 4) return std::nullopt;
  round_vertices(*mesh);
  return mesh;
}

/// A very dense mesh with `faces` triangles or some more, quickly, if that loses none of its components; else the mesh.
TriangleMesh thinned(const TriangleMesh& mesh, std::int64_t faces) {
  faces = std::max(faces, least_dense);
  if (mesh.triangles.rows() <= 2 * faces) return mesh;
  const TriangleMesh thin = simplify(mesh, faces);
  std::vector<std::int32_t> label;
  const auto components = static_cast<std::size_t>(triangle_components(mesh, label));
  std::vector<std::pair<std::int64_t, std::size_t>> size(static_cast<std::size_t>(triangle_components(thin, label)));
  if (size.size() < components) return mesh;
  // Where two strands came together, slivers were pinched off.
  for (std::size_t c = 0; c < size.size(); ++c) size[c].second = c;
  for (const std::int32_t c : label) --size[c].first;
  std::sort(size.begin(), size.end());
  std::vector<bool> kept(size.size(), false);
  for (std::size_t i = 0; i < components; ++i) kept[size[i].second] = true;
  return keep_components(thin, label, kept);
}

}  // namespace

std::vector<CoarseSource> coarse_sources(const LevelRequest& request, const FlowChoices& choices,
                                         const std::function<void()>& check) {
  std::vector<CoarseSource> sources;
  const double gap = std::min(part_gap * request.clearance,
                              std::max(least_part_gap * request.clearance, wide_part_gap * request.diagonal));
  if (choices.coarse != nullptr) {
    return {{"user", [&choices]() -> std::optional<TriangleMesh> {
               TriangleMesh mesh = *choices.coarse;
               round_vertices(mesh);
               return mesh;
             }}};
  }
  const auto wrap = [&request](double parameter) { return request.wraps->get(parameter); };
  if (choices.decimator) {
    sources.push_back({choices.decimator_name.empty() ? "decimator" : choices.decimator_name,
                       [=, &request, &choices]() -> std::optional<TriangleMesh> {
                         const TriangleMesh& undeformed =
                             choices.undeformed != nullptr ? *choices.undeformed : *request.clean;
                         if (request.manifold) {
                           return usable(choices.decimator(*request.clean, undeformed, request.faces));
                         }
                         const auto stand_in = wrap(100);
                         if (!stand_in) return std::nullopt;
                         return usable(choices.decimator(*stand_in, *stand_in, request.faces));
                       }});
    return sources;
  }
  if (request.manifold && request.topology != Topology::simplify) {
    // Each decimation needs it; the first one makes it.
    const auto fine = std::make_shared<std::optional<TriangleMesh>>();
    const auto dense = [=, &request]() -> const TriangleMesh& {
      if (!*fine) *fine = thinned(*request.clean, dense_faces * request.faces);
      return **fine;
    };
    for (const auto& [name, kind] : {std::pair{"regular", Decimation::regular}, {"adaptive", Decimation::adaptive}}) {
      sources.push_back({name, [=, &request] { return usable(decimate(dense(), request.faces, kind, gap, check)); }});
    }
  }
  if (request.topology == Topology::keep) return sources;
  if (choices.competes && request.faces > compete_faces && request.inner->triangles.rows() > most_wrapped)
    return sources;
  const double fine = request.faces >= 1500 ? 100 : request.faces >= 400 ? 50 : 20;
  for (const double parameter : {100.0, 50.0, 20.0, 10.0, 5.0}) {
    if (parameter > fine) continue;
    sources.push_back({"wrap/" + std::to_string(static_cast<int>(parameter)),
                       [=, &request]() -> std::optional<TriangleMesh> {
                         const auto surface = wrap(parameter);
                         if (!surface || surface->triangles.rows() <= request.faces) return usable(surface);
                         return usable(decimate(*surface, request.faces, Decimation::regular, gap, check));
                       },
                       static_cast<int>(sources.size()), parameter < 10});
  }
  return sources;
}

void drop_empty_parts(TriangleMesh& coarse, TriangleMesh& moved, const Obstacle& flowed) {
  std::vector<std::int32_t> label;
  const int components = triangle_components(moved, label);
  if (components == 1) return;
  std::vector<bool> kept(static_cast<std::size_t>(components), false);
  for (std::int32_t c = 0; c < components; ++c) {
    std::vector<bool> only(kept.size(), false);
    only[c] = true;
    const TriangleMesh part = keep_components(moved, label, only);
    std::vector<Point> points;
    flowed.representatives(bounds(part), points);
    kept[c] = signed_volume(part) <= 0 || std::any_of(points.begin(), points.end(), [&](const Point& x) {
                double angle = 0;
                for (std::int64_t t = 0; t < part.triangles.rows(); ++t) {
                  angle += solid_angle(x, {part.corner(t, 0), part.corner(t, 1), part.corner(t, 2)});
                }
                return angle > 6;  // 4 pi, or 0 outside
              });
  }
  coarse = keep_components(coarse, label, kept);
  moved = keep_components(moved, label, kept);
}

}  // namespace encage::makers
