// SPDX-License-Identifier: GPL-3.0-or-later
// Convex decomposition by HACD, as it comes with Bullet's extras, and how far its surface is from the mesh's.

#include "bench/bullet/contact_method.h"
#include "bench/common/report.h"
#include "cagegen/flow/signed_distance.h"

#include <encage/decimator.h>
#include <encage/error.h>

#include <HACD/hacdHACD.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace encage::bullet_bench {
namespace {

// HACD scales meshes to a diagonal of about 1,000, in which concavity counts. It takes quadratic time and more, so that
// users decimate before. Of a ring of 2,000 triangles, these settings gave the hulls nearest to it: without the extra
// points that measure concavity, hulls bridge the hole, and a larger weight of compacity leaves hulls of uneven size.
constexpr std::int64_t most_triangles = 2000;
constexpr std::size_t least_clusters = 32, most_vertices = 64;
constexpr double concavity = 20, compacity_weight = 0.001, volume_weight = 0, scale = 1000;
constexpr double margin = 1e-3;

struct Hull {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3i> triangles;

  /// From the planes of the faces: exact inside, where it is negative, and no more than the distance outside.
  double separation(const Eigen::Vector3d& p) const {
    double largest = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3i& t : triangles) {
      const Eigen::Vector3d normal = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
      const double length = normal.norm();
      if (length > 0) largest = std::max(largest, normal.dot(p - points[t[0]]) / length);
    }
    return largest;
  }
};

/// Counter-clockwise seen from outside, whatever HACD's order.
void orient(Hull& hull) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : hull.points) middle += p / static_cast<double>(hull.points.size());
  for (Eigen::Vector3i& t : hull.triangles) {
    const Eigen::Vector3d& a = hull.points[t[0]];
    if ((hull.points[t[1]] - a).cross(hull.points[t[2]] - a).dot(middle - a) > 0) std::swap(t[1], t[2]);
  }
}

std::vector<Hull> decompose(const TriangleMesh& mesh) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  std::vector<HACD::Vec3<long>> triangles;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
    points.emplace_back(mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2));
  }
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    triangles.emplace_back(mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetScaleFactor(scale);
  hacd.SetCompacityWeight(compacity_weight);
  hacd.SetVolumeWeight(volume_weight);
  hacd.SetNClusters(least_clusters);
  hacd.SetNVerticesPerCH(most_vertices);
  hacd.SetConcavity(concavity);
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(true);
  if (!hacd.Compute()) throw Error("convex decomposition: HACD failed");
  std::vector<Hull> hulls;
  for (std::size_t c = 0; c < hacd.GetNClusters(); ++c) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(c));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(c));
    if (corners.size() < 4 || faces.size() < 4) continue;
    hacd.GetCH(c, corners.data(), faces.data());
    Hull& hull = hulls.emplace_back();
    for (const auto& p : corners) hull.points.emplace_back(p.X(), p.Y(), p.Z());
    for (const auto& t : faces) hull.triangles.emplace_back(t.X(), t.Y(), t.Z());
    orient(hull);
  }
  return hulls;
}

/// Statistics of a set of lengths.
struct Spread {
  explicit Spread(std::vector<double> lengths) {
    if (lengths.empty()) return;
    std::sort(lengths.begin(), lengths.end());
    for (const double length : lengths) mean += length / static_cast<double>(lengths.size());
    percentile_95 = lengths[lengths.size() * 95 / 100];
    most = lengths.back();
  }
  double mean = 0, percentile_95 = 0, most = 0;
};

/// How far the surface of the hulls' union is outside the mesh, where it is, over samples of even density.
Spread surface_outside(const std::vector<Hull>& hulls, const TriangleMesh& mesh) {
  const makers::SignedDistance distance(mesh);
  const double diagonal = bounds(mesh).diagonal().norm(), spacing = diagonal / 150;
  std::vector<double> lengths;
  const auto sample = [&](const Eigen::Vector3d& p) {
    const bool buried = std::any_of(hulls.begin(), hulls.end(),
                                    [&](const Hull& hull) { return hull.separation(p) < -1e-6 * diagonal; });
    const double length = buried ? -1 : distance.nearest(p).distance;
    if (length >= 0) lengths.push_back(length);
  };
  for (const Hull& hull : hulls) {
    for (const Eigen::Vector3i& t : hull.triangles) {
      const Eigen::Vector3d &a = hull.points[t[0]], &b = hull.points[t[1]], &c = hull.points[t[2]];
      // Middles of the cells of a grid over the parallelogram, those in the triangle.
      const double side = (b - a).norm(), height = (b - a).cross(c - a).norm() / std::max(side, 1e-12);
      const int rows = 1 + static_cast<int>(side / spacing), columns = 1 + static_cast<int>(height / spacing);
      for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
          const double u = (i + 0.5) / rows, v = (j + 0.5) / columns;
          if (u + v <= 1) sample(a + u * (b - a) + v * (c - a));
        }
      }
    }
  }
  return Spread(lengths);
}

/// How far vertices of the mesh stick out of all hulls, 0 where they do not.
Spread surface_uncovered(const std::vector<Hull>& hulls, const TriangleMesh& mesh) {
  std::vector<double> lengths;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
    double length = std::numeric_limits<double>::infinity();
    for (const Hull& hull : hulls) length = std::min(length, hull.separation(mesh.vertex(v)));
    lengths.push_back(std::max(length, 0.0));
  }
  return Spread(lengths);
}

class HullShape : public MethodShape {
 public:
  explicit HullShape(const SceneBodyModel& body) {
    const TriangleMesh& mesh = body.mesh;
    const bool coarse = mesh.triangles.rows() > most_triangles;
    const TriangleMesh input = coarse ? adaptive_decimator()(mesh, mesh, most_triangles) : mesh;
    const std::vector<Hull> hulls = decompose(input);
    for (const Hull& hull : hulls) {
      auto& shape = hulls_.emplace_back(std::make_unique<btConvexHullShape>());
      for (const Eigen::Vector3d& p : hull.points) {
        shape->addPoint({static_cast<btScalar>(p.x()), static_cast<btScalar>(p.y()), static_cast<btScalar>(p.z())},
                        false);
      }
      shape->setMargin(static_cast<btScalar>(margin));
      shape->recalcLocalAabb();
      compound_.addChildShape(btTransform::getIdentity(), shape.get());
    }
    const auto percent = [&](const Spread& spread) -> nlohmann::ordered_json {
      const double factor = 100 / body.radius;
      return {{"mean", factor * spread.mean}, {"p95", factor * spread.percentile_95}, {"max", factor * spread.most}};
    };
    details_ = {{"triangles", input.triangles.rows()},
                {"hulls", hulls.size()},
                {"outside_percent", percent(surface_outside(hulls, mesh))},
                {"uncovered_percent", percent(surface_uncovered(hulls, mesh))}};
  }
  btCollisionShape& shape() override { return compound_; }
  nlohmann::ordered_json details() const override { return details_; }

 private:
  std::vector<std::unique_ptr<btConvexHullShape>> hulls_;
  btCompoundShape compound_;
  nlohmann::ordered_json details_;
};

class HullMethod : public ContactMethod {
 public:
  std::string name() const override { return "hulls"; }
  std::string description() const override {
    return bench::format(
        "convex decomposition by HACD: decimated to %d triangles, at least %d clusters, concavity %g of %g, compacity "
        "weight %g, volume weight %g, at most %d vertices a hull, extra distance and face points; hull margin %g mm",
        static_cast<int>(most_triangles), static_cast<int>(least_clusters), concavity, scale, compacity_weight,
        volume_weight, static_cast<int>(most_vertices), 1e3 * margin);
  }
  std::unique_ptr<MethodShape> make_shape(const SceneBodyModel& body) const override {
    return std::make_unique<HullShape>(body);
  }
  std::shared_ptr<void> attach(btCollisionDispatcher&) const override { return nullptr; }
};

}  // namespace

std::unique_ptr<ContactMethod> make_hull_method() { return std::make_unique<HullMethod>(); }

}  // namespace encage::bullet_bench
