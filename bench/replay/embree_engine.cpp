// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/embree_engine.h"

#include "bench/common/box_pairs.h"
#include "cagegen/certify/exact.h"

#include <encage/error.h>

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <utility>

namespace encage::replay {
namespace {

struct ReleaseModel {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, ReleaseModel>;

/// Vertices in columns, with a fourth coordinate for whole vector registers.
using Points = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// What all bodies share.
struct EmbreeModel {
  TriangleMesh mesh;
  Points points;      ///< of the mesh, fourth coordinate 1
  double extent = 0;  ///< largest coordinate
  Device device{rtcNewDevice("threads=1")};

  void check() const {
    if (!device || rtcGetDeviceError(device.get()) != RTC_ERROR_NONE) throw Error("Embree failed");
  }
};

/// A tree over the triangles of a body in some frame.
class Tree {
 public:
  Tree(const EmbreeModel& model, RTCSceneFlags flags, RTCBuildQuality quality)
      : model_(model), scene_(rtcNewScene(model.device.get())) {
    geometry_.reset(rtcNewGeometry(model.device.get(), RTC_GEOMETRY_TYPE_USER));
    rtcSetGeometryUserPrimitiveCount(geometry_.get(), static_cast<unsigned>(model.mesh.triangles.rows()));
    rtcSetGeometryUserData(geometry_.get(), this);
    rtcSetGeometryBoundsFunction(geometry_.get(), bound, nullptr);
    rtcSetGeometryBuildQuality(geometry_.get(), quality);
    rtcAttachGeometry(scene_.get(), geometry_.get());
    rtcSetSceneFlags(scene_.get(), flags);
    rtcSetSceneBuildQuality(scene_.get(), quality == RTC_BUILD_QUALITY_REFIT ? RTC_BUILD_QUALITY_LOW : quality);
  }

  RTCScene scene() const { return scene_.get(); }

  /// Moves the body and updates the tree.
  void place(const Eigen::Isometry3d& pose) {
    points_.noalias() = pose.matrix().cast<float>() * model_.points;
    // Each coordinate takes 7 roundings of 2^-24 of what is summed up.
    slack_ = static_cast<float>(0x1p-20 * (2 * model_.extent + pose.translation().cwiseAbs().maxCoeff()));
    rtcCommitGeometry(geometry_.get());
    rtcCommitScene(scene_.get());
    model_.check();
  }

 private:
  static void bound(const RTCBoundsFunctionArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const std::int32_t* corner = tree.model_.mesh.triangles.data() + 3 * std::size_t{arguments->primID};
    const Eigen::Array4f a = tree.points_.col(corner[0]), b = tree.points_.col(corner[1]),
                         c = tree.points_.col(corner[2]);
    const Eigen::Array4f low = a.min(b).min(c) - tree.slack_, high = a.max(b).max(c) + tree.slack_;
    // Three coordinates and a fourth that Embree does not read.
    static_assert(offsetof(RTCBounds, upper_x) == sizeof(low));
    std::memcpy(&arguments->bounds_o->lower_x, low.data(), sizeof(low));
    std::memcpy(&arguments->bounds_o->upper_x, high.data(), sizeof(high));
  }

  const EmbreeModel& model_;
  std::unique_ptr<RTCSceneTy, ReleaseModel> scene_;
  std::unique_ptr<RTCGeometryTy, ReleaseModel> geometry_;
  Points points_;
  float slack_ = 0;
};

/// One call of rtcCollide().
struct Collision {
  const TriangleMesh& mesh;
  const Eigen::Isometry3d& pose_a;
  const Eigen::Isometry3d& pose_b;
  bool hit = false;

  proof::Corners corners(const Eigen::Isometry3d& pose, unsigned triangle) const {
    proof::Corners corners = proof::corners(mesh, static_cast<std::int32_t>(triangle));
    for (proof::Point& corner : corners) corner = pose * corner;
    return corners;
  }

  static void visit(void* data, RTCCollision* collisions, unsigned count) {
    Collision& self = *static_cast<Collision*>(data);
    for (unsigned k = 0; k < count && !self.hit; ++k) {
      self.hit = proof::touch(self.corners(self.pose_a, collisions[k].primID0),
                              self.corners(self.pose_b, collisions[k].primID1));
    }
  }
};

/// Root of an entry in a forest of groups, the least of its group.
std::size_t root_of(std::vector<std::size_t>& parent, std::size_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

class EmbreeEngine : public Engine {
 public:
  EmbreeEngine(const TriangleMesh& mesh, ShapePtr shape, EmbreeUpdate update)
      : shape_(std::move(shape)), update_(update) {
    model_.mesh = mesh;
    model_.points.setOnes(4, mesh.vertices.rows());
    model_.points.topRows(3) = mesh.vertices.transpose().cast<float>();
    model_.extent = mesh.vertices.cwiseAbs().maxCoeff();
    model_.check();
    arena_.execute([&] {
      resting_ = std::make_unique<Tree>(model_, RTC_SCENE_FLAG_NONE, RTC_BUILD_QUALITY_HIGH);
      resting_->place(Eigen::Isometry3d::Identity());
    });
  }

  std::string name() const override { return update_ == EmbreeUpdate::refit ? "embree_refit" : "embree_rebuild"; }

  std::vector<BodyPair> touching(const StepQuestion& question) override {
    std::vector<BodyPair> pairs;
    arena_.execute([&] { find(question, pairs); });
    return pairs;
  }

 private:
  void find(const StepQuestion& question, std::vector<BodyPair>& pairs) {
    const std::vector<BodyPose>& bodies = question.step.bodies;
    bench::BoxPairs::Places asked;
    for (const auto& [i, j] : boxes_.overlaps(*shape_, question.step)) {
      if (!question.skips(bodies[i], bodies[j])) asked.emplace_back(i, j);
    }
    std::vector<std::size_t> root(bodies.size());
    std::iota(root.begin(), root.end(), std::size_t{0});
    for (const auto& [i, j] : asked) {
      const std::size_t one = root_of(root, i), other = root_of(root, j);
      root[std::max(one, other)] = std::min(one, other);
    }
    std::vector<Eigen::Isometry3d> poses(bodies.size());
    std::vector<const Tree*> trees(bodies.size(), resting_.get());
    std::size_t used = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const std::size_t frame = root_of(root, i);
      poses[i] = frame == i ? Eigen::Isometry3d::Identity() : bodies[frame].pose.inverse() * bodies[i].pose;
      if (frame == i) continue;
      Tree& moved = tree(used++);
      moved.place(poses[i]);
      trees[i] = &moved;
    }
    for (const auto& [i, j] : asked) {
      Collision collision{model_.mesh, poses[i], poses[j]};
      rtcCollide(trees[i]->scene(), trees[j]->scene(), Collision::visit, &collision);
      if (collision.hit) pairs.push_back({bodies[i].body, bodies[j].body});
    }
  }

  /// Any tree will do for any body, as they are copies of one mesh.
  Tree& tree(std::size_t number) {
    if (number == pool_.size()) {
      const bool refit = update_ == EmbreeUpdate::refit;
      pool_.push_back(std::make_unique<Tree>(model_, RTC_SCENE_FLAG_DYNAMIC,
                                             refit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW));
    }
    return *pool_[number];
  }

  ShapePtr shape_;
  EmbreeUpdate update_;
  bench::BoxPairs boxes_;
  tbb::task_arena arena_{1};
  EmbreeModel model_;
  std::unique_ptr<Tree> resting_;
  std::vector<std::unique_ptr<Tree>> pool_;
};

}  // namespace

std::unique_ptr<Engine> make_embree_engine(const TriangleMesh& mesh, ShapePtr shape, EmbreeUpdate update) {
  return std::make_unique<EmbreeEngine>(mesh, std::move(shape), update);
}

}  // namespace encage::replay
