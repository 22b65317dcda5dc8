// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/surface.h"

#include <algorithm>
#include <new>
#include <numeric>

namespace encage::render {
namespace {

constexpr double crease_cosine = 0.766;  // 40 degrees

// Vertices at the same position share the lowest index among them.
std::vector<std::int32_t> weld(const TriangleMesh& mesh) {
  const auto less = [&](std::int32_t a, std::int32_t b) {
    for (int k = 0; k < 3; ++k) {
      if (mesh.vertices(a, k) != mesh.vertices(b, k)) return mesh.vertices(a, k) < mesh.vertices(b, k);
    }
    return a < b;
  };
  std::vector<std::int32_t> order(static_cast<std::size_t>(mesh.vertices.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), less);
  std::vector<std::int32_t> representative(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && mesh.vertices.row(order[i]) == mesh.vertices.row(order[i - 1]);
    representative[order[i]] = same ? representative[order[i - 1]] : order[i];
  }
  return representative;
}

Eigen::Vector3d area_normal(const TriangleMesh& mesh, std::int64_t t) {
  const Eigen::Vector3d a = mesh.corner(t, 0);
  return (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a);
}

RTCRay to_embree(const Ray& ray, const Eigen::Vector3d& centre) {
  const Eigen::Vector3f o = (ray.origin - centre).cast<float>(), d = ray.direction.cast<float>();
  RTCRay r{};
  r.org_x = o.x(), r.org_y = o.y(), r.org_z = o.z();
  r.dir_x = d.x(), r.dir_y = d.y(), r.dir_z = d.z();
  r.tnear = static_cast<float>(ray.near);
  r.tfar = static_cast<float>(ray.far);
  r.mask = ~0U;
  return r;
}

}  // namespace

std::vector<Eigen::Vector3f> corner_normals(const TriangleMesh& mesh, bool smooth) {
  const std::int64_t count = mesh.triangles.rows();
  std::vector<Eigen::Vector3d> area(static_cast<std::size_t>(count));
  for (std::int64_t t = 0; t < count; ++t) area[t] = area_normal(mesh, t);
  std::vector<Eigen::Vector3f> normals(static_cast<std::size_t>(count) * 3);
  if (!smooth) {
    for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = area[i / 3].normalized().cast<float>();
    return normals;
  }
  // Triangles around each vertex, by counting sort.
  const std::vector<std::int32_t> representative = weld(mesh);
  std::vector<std::int64_t> first(representative.size() + 1);
  for (std::int64_t i = 0; i < 3 * count; ++i) ++first[representative[mesh.triangles(i / 3, i % 3)] + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::int32_t> around(static_cast<std::size_t>(count) * 3);
  std::vector<std::int64_t> next(first.begin(), first.end() - 1);
  for (std::int64_t i = 0; i < 3 * count; ++i) {
    around[next[representative[mesh.triangles(i / 3, i % 3)]]++] = static_cast<std::int32_t>(i / 3);
  }
  for (std::int64_t i = 0; i < 3 * count; ++i) {
    const Eigen::Vector3d& own = area[i / 3];
    const std::int32_t v = representative[mesh.triangles(i / 3, i % 3)];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::int64_t k = first[v]; k < first[v + 1]; ++k) {
      const Eigen::Vector3d& other = area[around[k]];
      if (own.dot(other) >= crease_cosine * own.norm() * other.norm()) sum += other;
    }
    normals[i] = sum.normalized().cast<float>();
  }
  return normals;
}

Scene::Scene(std::span<const Item> items, const std::vector<std::uint32_t>& chosen, const Eigen::Vector3d& centre)
    : device_(rtcNewDevice(nullptr)), centre_(centre) {
  if (device_ == nullptr) throw std::bad_alloc();
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);  // no ray slips through an edge
  for (const std::uint32_t item : chosen) {
    const TriangleMesh& mesh = *items[item].mesh;
    const std::size_t vertex_count = static_cast<std::size_t>(mesh.vertices.rows());
    const std::size_t triangle_count = static_cast<std::size_t>(mesh.triangles.rows());
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    float* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                  RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertex_count));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangle_count));
    if (vertices != nullptr && indices != nullptr) {
      for (std::size_t i = 0; i < 3 * vertex_count; ++i) {
        vertices[i] = static_cast<float>(mesh.vertices.data()[i] - centre[static_cast<int>(i % 3)]);
      }
      std::copy_n(mesh.triangles.data(), 3 * triangle_count, indices);
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene_, geometry, item);
    }
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene_);
  if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
    throw std::bad_alloc();  // the only error that valid calls can meet
  }
}

Scene::~Scene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

std::optional<Hit> Scene::nearest(const Ray& ray) const {
  RTCRayHit query{};
  query.ray = to_embree(ray, centre_);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return Hit{query.hit.geomID, query.hit.primID, query.ray.tfar, query.hit.u, query.hit.v};
}

bool Scene::blocked(const Ray& ray) const {
  RTCRay query = to_embree(ray, centre_);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_, &context, &query);
  return query.tfar < 0;  // Embree sets -infinity
}

}  // namespace encage::render
