// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/queries/engines.h"

#include <encage/error.h>

#include <embree3/rtcore.h>

#include <limits>

namespace encage::queries {
namespace {

class EmbreeMesh {
 public:
  EmbreeMesh(const TriangleMesh& mesh, bool robust) : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    rtcSetSceneFlags(scene_, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto vertices = static_cast<std::size_t>(mesh.vertices.rows());
    const auto triangles = static_cast<std::size_t>(mesh.triangles.rows());
    auto* v = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
    for (std::size_t i = 0; i < 3 * vertices; ++i) v[i] = static_cast<float>(mesh.vertices.data()[i]);
    auto* t = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), triangles));
    for (std::size_t i = 0; i < 3 * triangles; ++i) t[i] = static_cast<unsigned>(mesh.triangles.data()[i]);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw Error("Embree failed");
  }
  ~EmbreeMesh() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeMesh(const EmbreeMesh&) = delete;
  EmbreeMesh& operator=(const EmbreeMesh&) = delete;

  FirstHit cast(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(ray.origin.x());
    query.ray.org_y = static_cast<float>(ray.origin.y());
    query.ray.org_z = static_cast<float>(ray.origin.z());
    query.ray.dir_x = static_cast<float>(ray.direction.x());
    query.ray.dir_y = static_cast<float>(ray.direction.y());
    query.ray.dir_z = static_cast<float>(ray.direction.z());
    query.ray.tfar = std::numeric_limits<float>::infinity();
    query.ray.mask = ~0U;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    return {query.hit.geomID != RTC_INVALID_GEOMETRY_ID, static_cast<double>(query.ray.tfar)};
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace

RayEngine embree_rays(const TriangleMesh& mesh, bool robust) {
  const auto scene = std::make_shared<EmbreeMesh>(mesh, robust);
  return {robust ? "Embree, robust" : "Embree", [scene](const std::vector<Ray>& rays, std::vector<FirstHit>& hits) {
            for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = scene->cast(rays[i]);
          }};
}

}  // namespace encage::queries
