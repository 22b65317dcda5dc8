// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/queries/compare.h"

#include "bench/common/clock.h"
#include "bench/common/statistics.h"
#include "bench/suite/queries/engines.h"
#include "oracles/exact_pair.h"
#include "oracles/sampled.h"

#include <encage/casts.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace encage::queries {
namespace {

using Vector = Eigen::Vector3d;

template <class Task>
double median_seconds(int runs, const Task& task) {
  std::vector<double> seconds;
  for (int run = 0; run < runs; ++run) seconds.push_back(1e-3 * bench::cpu_milliseconds(task));
  return bench::median(seconds);
}

Vector vertex_in(const TriangleMesh& mesh, shapes::Random& random) {
  return mesh.vertex(random.integer(static_cast<int>(mesh.vertices.rows())));
}

std::vector<Ray> make_rays(const TriangleMesh& mesh, int count, int aimed_of_ten, std::uint32_t seed) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  const double radius = 0.5 * box.diagonal().norm();
  shapes::Random random(seed);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    Ray ray;
    ray.origin = box.center() + random(0.2, 1.2) * radius * test::random_direction(random);
    const Vector half = 0.5 * box.sizes();
    Vector target = box.center() + half.cwiseProduct(random.point(1));
    if (random.integer(10) < aimed_of_ten) target = vertex_in(mesh, random);
    ray.direction = (target - ray.origin).normalized();
    // Rays are rounded to single precision, so that all engines answer the same ones.
    ray.origin = ray.origin.cast<float>().cast<double>();
    ray.direction = ray.direction.cast<float>().cast<double>();
    rays.push_back(ray);
  }
  return rays;
}

/// The first hit by exact arithmetic on every triangle that is not far from the ray; t in long double.
FirstHit exact_hit(const TriangleMesh& mesh, const Ray& ray) {
  FirstHit first{false, std::numeric_limits<double>::infinity()};
  const Vector d = ray.direction.normalized();
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector a = mesh.corner(t, 0) - ray.origin, b = mesh.corner(t, 1) - ray.origin,
                 c = mesh.corner(t, 2) - ray.origin;
    const double size = std::max((b - a).squaredNorm(), (c - a).squaredNorm()) * (1 + 1e-9);
    if ((a - a.dot(d) * d).squaredNorm() > size) continue;
    TriangleMesh one;
    one.vertices.resize(3, 3);
    for (int k = 0; k < 3; ++k) one.vertices.row(k) = mesh.corner(t, k).transpose();
    one.triangles.resize(1, 3);
    one.triangles << 0, 1, 2;
    const test::ExactBody body(Vector::Zero(), one, Eigen::Isometry3d::Identity());
    if (!test::ray_meets(body, 0, {ray.origin, ray.direction, ray.t_min, ray.t_max})) continue;
    using test::Point;
    const Point n = (b - a).cast<test::Real>().cross((c - a).cast<test::Real>());
    const test::Real rate = n.dot(ray.direction.cast<test::Real>());
    const auto at = rate != 0 ? static_cast<double>(n.dot(a.cast<test::Real>()) / rate) : a.dot(d);
    first.hit = true;
    first.t = std::min(first.t, at);
  }
  return first;
}

RayEngine encage_rays(const Shape& shape) {
  return {"Encage", [&shape](const std::vector<Ray>& rays, std::vector<FirstHit>& hits) {
            static thread_local std::vector<RayResult> results;
            results.resize(rays.size());
            cast_rays(shape, Motion{}, rays, results);
            for (std::size_t i = 0; i < rays.size(); ++i) {
              hits[i] = {results[i].answer == RayAnswer::hit, results[i].hit.t};
            }
          }};
}

}  // namespace

std::vector<QueryRow> compare_rays(const Shape& shape, const TriangleMesh& mesh, int rays, int checks, int runs,
                                   const std::function<void(double fraction)>& progress) {
  const std::vector<RayEngine> engines = {encage_rays(shape), embree_rays(mesh, false), embree_rays(mesh, true)};
  const std::vector<Ray> timed = make_rays(mesh, rays, 0, 1), checked = make_rays(mesh, checks, 1, 2);
  std::vector<FirstHit> truth, hits(timed.size());
  for (const Ray& ray : checked) {
    truth.push_back(exact_hit(mesh, ray));
    progress(0.5 * static_cast<double>(truth.size()) / static_cast<double>(checked.size()));
  }
  const double near = 1e-5 * bounds(mesh).diagonal().norm();
  std::vector<QueryRow> rows;
  for (const RayEngine& engine : engines) {
    QueryRow& row = rows.emplace_back(QueryRow{.name = engine.name, .checked = checks});
    row.per_second = rays / median_seconds(runs, [&] { engine.cast(timed, hits); });
    std::vector<FirstHit> found(checked.size());
    engine.cast(checked, found);
    for (std::size_t i = 0; i < checked.size(); ++i) {
      row.wrong += truth[i].hit && !(found[i].hit && found[i].t <= truth[i].t + near);
    }
    progress(0.5 + 0.5 * static_cast<double>(rows.size()) / static_cast<double>(engines.size()));
  }
  return rows;
}

std::vector<QueryRow> compare_points(const Shape& shape, const TriangleMesh& mesh, int points, int runs,
                                     const std::function<void(double fraction)>& progress) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  const double diagonal = box.diagonal().norm();
  shapes::Random random(3);
  std::vector<Vector> asked;
  for (int i = 0; i < points; ++i) {
    const double away = i % 3 == 1 ? 1e-6 : 0.05;
    const std::int64_t t = random.integer(static_cast<int>(mesh.triangles.rows()));
    const Vector on = 0.3 * mesh.corner(t, 0) + 0.3 * mesh.corner(t, 1) + 0.4 * mesh.corner(t, 2);
    asked.push_back(i % 3 == 0 ? Vector(box.center() + (0.5 * box.sizes()).cwiseProduct(random.point(1)))
                               : Vector(on + random(0, away) * diagonal * test::random_direction(random)));
  }
  const PointEngine cgal = cgal_points(mesh);
  std::vector<ClosestPoint> closest(asked.size());
  std::vector<SignedDistance> distances(asked.size());
  std::vector<PointSide> sides(asked.size());
  std::vector<double> others(asked.size());
  std::vector<QueryRow> rows;
  const auto add = [&](const std::string& name, const auto& task) {
    rows.push_back({.name = name, .per_second = points / median_seconds(runs, task)});
    progress(0.25 * static_cast<double>(rows.size()));
  };
  add("Encage, closest_points", [&] { closest_points(shape, Motion{}, asked, closest); });
  add("Encage, signed_distances", [&] { signed_distances(shape, Motion{}, asked, distances); });
  add("Encage, contains", [&] { contains(shape, Motion{}, asked, sides); });
  add(cgal.name, [&] { cgal.measure(asked, others); });
  // Encage's bounds include what the asset's mesh may be off the source; CGAL measures the former.
  for (QueryRow& row : rows) row.checked = points;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const double slack = 1e-12 * diagonal;
    rows[0].wrong += others[i] < closest[i].lower - slack || others[i] > closest[i].upper + slack;
    rows[1].wrong += distances[i].side != sides[i] || distances[i].closest.upper != closest[i].upper;
  }
  return rows;
}

std::vector<QueryRow> measure_casts(const Shape& shape, const TriangleMesh& mesh, int casts, int runs,
                                    const std::function<void(double fraction)>& progress) {
  const double diagonal = bounds(mesh).diagonal().norm();
  const std::vector<Ray> ways = make_rays(mesh, casts, 0, 4);
  std::vector<CastResult> found(ways.size());
  std::vector<QueryRow> rows;
  const auto add = [&](const std::string& name, const auto& volume_at) {
    QueryRow& row = rows.emplace_back(QueryRow{.name = name, .checked = casts});
    const auto way = [&](const Ray& ray) { return Vector(diagonal * ray.direction); };
    row.per_second = casts / median_seconds(runs, [&] {
                       for (std::size_t i = 0; i < ways.size(); ++i) {
                         found[i] = cast(shape, Motion{}, volume_at(ways[i].origin), way(ways[i]));
                       }
                     });
    for (std::size_t i = 0; i < ways.size(); ++i) {
      bool early = false;
      for (int k = 0; k < 4; ++k) {
        const Vector moved = (found[i].time * k / 4) * way(ways[i]);
        early = early || (found[i].time > 0 && overlaps(shape, Motion{}, volume_at(ways[i].origin + moved)));
      }
      row.wrong += early;
    }
    progress(static_cast<double>(rows.size()) / 5);
  };
  for (const double share : {0.001, 0.02}) {
    const double radius = share * diagonal;
    add("sphere, radius " + std::to_string(share).substr(0, 5) + " diagonals", [=](const Vector& p) {
      return Sphere{p, radius};
    });
  }
  add("capsule, 0.02 wide, 0.06 long", [=](const Vector& p) {
    return Capsule{p - Vector(0, 0, 0.02 * diagonal), p + Vector(0, 0, 0.02 * diagonal), 0.01 * diagonal};
  });
  for (const double share : {0.001, 0.02}) {
    const double half = share * diagonal;
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.7, Vector(1, 2, 3).normalized()).toRotationMatrix();
    add("box, half size " + std::to_string(share).substr(0, 5) + " diagonals", [=](const Vector& p) {
      OrientedBox box{Eigen::Isometry3d::Identity(), Vector::Constant(half)};
      box.pose.linear() = turned;
      box.pose.translation() = p;
      return box;
    });
  }
  return rows;
}

}  // namespace encage::queries
