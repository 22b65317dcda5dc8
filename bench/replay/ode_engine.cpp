// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/ode_engine.h"

#include <encage/error.h>

#include <ode/ode.h>

#include <algorithm>
#include <map>

namespace encage::replay {
namespace {

/// ODE is initialised once for the process, in the thread that first makes an engine.
void start_ode() {
  static const bool started = dInitODE2(0) != 0 && dAllocateODEDataForThread(dAllocateMaskAll) != 0;
  if (!started) throw Error("ODE cannot be initialised");
}

struct Destroy {
  void operator()(dGeomID geom) const { dGeomDestroy(geom); }
};
using Geom = std::unique_ptr<std::remove_pointer_t<dGeomID>, Destroy>;

class OdeEngine : public Engine {
 public:
  explicit OdeEngine(const TriangleMesh& mesh) : vertices_(mesh.vertices.cast<float>()) {
    start_ode();
    for (std::int64_t k = 0; k < mesh.triangles.size(); ++k) {
      indices_.push_back(static_cast<dTriIndex>(mesh.triangles.data()[k]));
    }
    data_ = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildSingle(data_, vertices_.data(), 3 * sizeof(float), static_cast<int>(vertices_.rows()),
                                indices_.data(), static_cast<int>(indices_.size()), 3 * sizeof(dTriIndex));
    space_ = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XZY);
    dSpaceSetCleanup(space_, 0);
  }
  ~OdeEngine() override {
    geoms_.clear();
    dSpaceDestroy(space_);
    dGeomTriMeshDataDestroy(data_);
  }
  OdeEngine(const OdeEngine&) = delete;
  OdeEngine& operator=(const OdeEngine&) = delete;

  std::string name() const override { return "ode"; }

  std::vector<BodyPair> touching(const StepQuestion& question) override {
    std::vector<dGeomID> present;
    for (const BodyPose& body : question.step.bodies) present.push_back(place(body));
    if (present != present_) {
      for (const dGeomID geom : present_) dSpaceRemove(space_, geom);
      for (const dGeomID geom : present) dSpaceAdd(space_, geom);
      present_ = present;
    }
    OdeQuery query{question, {}};
    dSpaceCollide(space_, &query, visit);
    std::sort(query.pairs.begin(), query.pairs.end());
    return std::move(query.pairs);
  }

 private:
  struct OdeQuery {
    const StepQuestion& question;
    std::vector<BodyPair> pairs;
  };

  dGeomID place(const BodyPose& body) {
    Geom& geom = geoms_[body.body];
    if (!geom) geom.reset(dCreateTriMesh(nullptr, data_, nullptr, nullptr, nullptr));
    dMatrix3 rotation{};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation[4 * i + j] = body.pose(i, j);
    }
    dGeomSetRotation(geom.get(), rotation);
    dGeomSetPosition(geom.get(), body.pose(0, 3), body.pose(1, 3), body.pose(2, 3));
    dGeomSetData(geom.get(), const_cast<BodyPose*>(&body));
    return geom.get();
  }

  static void visit(void* data, dGeomID a, dGeomID b) {
    OdeQuery& query = *static_cast<OdeQuery*>(data);
    const BodyPose& body_a = *static_cast<const BodyPose*>(dGeomGetData(a));
    const BodyPose& body_b = *static_cast<const BodyPose*>(dGeomGetData(b));
    if (query.question.skips(body_a, body_b)) return;
    dContactGeom contact;
    if (dCollide(a, b, 1 | CONTACTS_UNIMPORTANT, &contact, sizeof(contact)) > 0) {
      query.pairs.push_back(make_pair(body_a.body, body_b.body));
    }
  }

  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices_;  // data_ points into both
  std::vector<dTriIndex> indices_;
  dTriMeshDataID data_ = nullptr;
  dSpaceID space_ = nullptr;
  std::map<std::int32_t, Geom> geoms_;  // by body number; user data: its pose
  std::vector<dGeomID> present_;        // in space_
};

}  // namespace

std::unique_ptr<Engine> make_ode_engine(const TriangleMesh& mesh) { return std::make_unique<OdeEngine>(mesh); }

}  // namespace encage::replay
