// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/engine.h"

#include <encage/error.h>

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

namespace encage::scale {
namespace {

/// Embree's tree by Morton codes, built anew, met with itself.
class Embree : public BroadPhase {
 public:
  explicit Embree(const ScaleScene& scene) : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(scene.frame().motions.size()));
    rtcSetGeometryUserData(geometry_, this);
    rtcSetGeometryBoundsFunction(geometry_, bound, nullptr);
    rtcAttachGeometry(scene_, geometry_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
  }
  ~Embree() override {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  void step(const ScaleFrame& frame, std::vector<PairKey>& pairs) override {
    frame_ = frame;
    pairs_ = &pairs;
    arena_.execute([this] {
      rtcCommitGeometry(geometry_);
      rtcCommitScene(scene_);
      rtcCollide(scene_, scene_, visit, this);
    });
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw Error("Embree failed");
  }

 private:
  static void bound(const RTCBoundsFunctionArguments* arguments) {
    const FloatBox& box = static_cast<const Embree*>(arguments->geometryUserPtr)->frame_.float_box[arguments->primID];
    RTCBounds& out = *arguments->bounds_o;
    out.lower_x = box.lower[0];
    out.lower_y = box.lower[1];
    out.lower_z = box.lower[2];
    out.upper_x = box.upper[0];
    out.upper_y = box.upper[1];
    out.upper_z = box.upper[2];
  }

  static void visit(void* data, RTCCollision* collisions, unsigned count) {
    const Embree& self = *static_cast<const Embree*>(data);
    for (unsigned k = 0; k < count; ++k) {
      // Each pair comes in both orders.
      const unsigned a = collisions[k].primID0, b = collisions[k].primID1;
      if (a < b && overlap(self.frame_, a, b)) self.pairs_->push_back(pair_key(a, b));
    }
  }

  RTCDevice device_;
  RTCScene scene_;
  RTCGeometry geometry_;
  tbb::task_arena arena_{1};
  ScaleFrame frame_;
  std::vector<PairKey>* pairs_ = nullptr;
};

}  // namespace

std::unique_ptr<BroadPhase> make_embree(const ScaleScene& scene) { return std::make_unique<Embree>(scene); }

}  // namespace encage::scale
