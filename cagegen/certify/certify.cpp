// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/certify.h"

#include "cagegen/certify/exact.h"
#include "cagegen/certify/nesting.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace encage {
namespace {

using namespace proof;
using Refusal = std::optional<std::string>;

/// Far beyond float32; products of four coordinates stay in the range of double.
constexpr double largest_coordinate = 1e75;
/// Half-edges are numbered in 32 bits.
constexpr std::int64_t most_triangles = 500'000'000;

std::string numbered(const char* what, std::int64_t index) { return std::string(what) + ' ' + std::to_string(index); }

Refusal refuse_malformed(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.rows() == 0) return name + " has no triangles";
  if (mesh.triangles.rows() > most_triangles) return name + " has more than 500 million triangles";
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = mesh.triangles(t, k);
      if (v < 0 || v >= mesh.vertices.rows()) {
        return name + numbered(" triangle", t) + " refers to vertex " + std::to_string(v) + ", which does not exist";
      }
      // Written so that NaN fails too.
      if (!(mesh.vertices.row(v).cwiseAbs().maxCoeff() <= largest_coordinate) || !mesh.vertices.row(v).allFinite()) {
        return name + numbered(" vertex", v) + " is not finite or beyond 1e75";
      }
    }
  }
  return std::nullopt;
}

Refusal refuse_degenerate(const TriangleMesh& cage) {
  for (std::int32_t t = 0; t < cage.triangles.rows(); ++t) {
    if (degenerate(corners(cage, t))) return numbered("cage triangle", t) + " is degenerate";
  }
  return std::nullopt;
}

/// An embedded closed surface bounds a solid if outward components lie outside the others' solid and inward ones
/// (cavities) inside of it. Counts the latter.
Refusal refuse_orientation(const Surface& cage, int& cavities) {
  const std::vector<std::int32_t> first = first_triangles(cage);
  std::vector<std::vector<std::int32_t>> members(first.size());
  for (std::int32_t t = 0; t < cage.mesh.triangles.rows(); ++t) members[cage.connectivity.component[t]].push_back(t);
  for (int i = 0; i < cage.connectivity.component_count; ++i) {
    const bool outward = volume_sign(cage.mesh, members[i]) > 0;
    const int around = winding_number(cage, cage.mesh.corner(first[i], 0), i);
    if (!outward) ++cavities;
    if (around == (outward ? 0 : 1)) continue;
    return "the component of " + numbered("cage triangle", first[i]) +
           (outward ? " lies inside another component" : " is turned inward but is no cavity of another");
  }
  return std::nullopt;
}

Refusal refuse_contact(const Contact& found) {
  if (found.clearance > 0) return std::nullopt;
  return numbered("cage triangle", found.outer) + (found.touch ? " touches " : " is closer than double can say to ") +
         numbered("inner triangle", found.inner);
}

Refusal refuse_outside(const Surface& inner, const Surface& cage) {
  for (const std::int32_t t : first_triangles(inner)) {
    if (winding_number(cage, inner.mesh.corner(t, 0)) == 1) continue;
    return "the component of " + numbered("inner triangle", t) + " lies outside the cage";
  }
  return std::nullopt;
}

/// A cage component inside the inner solid would be a cavity that cuts a piece out of it.
Refusal refuse_cut(const Surface& inner, const Surface& cage) {
  for (const std::int32_t t : first_triangles(cage)) {
    if (winding_number(inner, cage.mesh.corner(t, 0)) == 0) continue;
    return "the component of " + numbered("cage triangle", t) + " lies inside the inner solid";
  }
  return std::nullopt;
}

/// Everything about the cage alone.
Refusal prove_cage(const Surface& cage, Certificate& certificate) {
  if (!cage.connectivity.defect.empty()) return "cage " + cage.connectivity.defect;
  if (Refusal refusal = refuse_degenerate(cage.mesh)) return refusal;
  if (const auto pair = self_intersection(cage)) {
    return numbered("cage triangles", pair->first) + numbered(" and", pair->second) + " intersect";
  }
  if (Refusal refusal = refuse_orientation(cage, certificate.cavities)) return refusal;
  certificate.volume = signed_volume(cage.mesh);
  certificate.components = cage.connectivity.component_count;
  certificate.genus = cage.connectivity.genus;
  return std::nullopt;
}

/// Everything about the cage and the surface inside of it; the cage itself is proven.
Refusal prove_nesting(const Surface& inner, Solid inner_solid, const Surface& cage, Certificate& certificate) {
  const bool solid = inner_solid != Solid::surface_only;
  if (solid && !inner.connectivity.closed) {
    return "inner mesh is said to be " + std::string(name(inner_solid)) + " but is open at " +
           inner.connectivity.open_edge;
  }
  const Contact nearest = contact(inner, cage);
  if (Refusal refusal = refuse_contact(nearest)) return refusal;
  if (Refusal refusal = refuse_outside(inner, cage)) return refusal;
  if (solid) {
    if (Refusal refusal = refuse_cut(inner, cage)) return refusal;
  }
  certificate.clearance = nearest.clearance;
  if (inner.connectivity.defect.empty()) {
    certificate.no_new_handles = cage.connectivity.genus <= inner.connectivity.genus;
  }
  return std::nullopt;
}

CertifyResult result(Refusal refusal, Certificate&& certificate) {
  if (refusal) return {false, std::move(*refusal), {}};
  return {true, {}, std::move(certificate)};
}

}  // namespace

CertifyResult certify_alone(const TriangleMesh& cage) {
  if (Refusal refusal = refuse_malformed(cage, "cage")) return result(refusal, {});
  Certificate certificate;
  return result(prove_cage(Surface(cage), certificate), std::move(certificate));
}

CertifyResult certify(const TriangleMesh& inner, Solid inner_solid, const TriangleMesh& cage) {
  if (Refusal refusal = refuse_malformed(cage, "cage")) return result(refusal, {});
  if (Refusal refusal = refuse_malformed(inner, "inner mesh")) return result(refusal, {});
  Certificate certificate;
  const Surface outer(cage);
  Refusal refusal = prove_cage(outer, certificate);
  if (!refusal) refusal = prove_nesting(Surface(inner), inner_solid, outer, certificate);
  return result(std::move(refusal), std::move(certificate));
}

}  // namespace encage
