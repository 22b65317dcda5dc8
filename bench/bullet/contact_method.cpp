// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/contact_method.h"

#include "bench/common/report.h"

#include <encage/bullet_mesh.h>
#include <encage/error.h>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <cstdint>

namespace encage::bullet_bench {
namespace {

class EncageMesh : public MethodShape {
 public:
  explicit EncageMesh(const TriangleMesh& mesh) : shape_(encage::make_shape(mesh)) {}
  btCollisionShape& shape() override { return shape_; }

 private:
  BulletMeshShape shape_;
};

class EncageMethod : public ContactMethod {
 public:
  std::string name() const override { return "encage"; }
  std::string description() const override {
    const BulletMeshOptions options;
    return bench::format("BulletMeshShape and BulletMeshContacts, skin %g, speculation up to %g of the radius",
                         options.skin, options.most_speculation);
  }
  std::unique_ptr<MethodShape> make_shape(const SceneBodyModel& body) const override {
    return std::make_unique<EncageMesh>(body.mesh);
  }
  std::shared_ptr<void> attach(btCollisionDispatcher& dispatcher) const override {
    return std::make_shared<BulletMeshContacts>(dispatcher);
  }
};

class GImpactMesh : public MethodShape {
 public:
  GImpactMesh(const TriangleMesh& mesh, double margin)
      : vertices_(mesh.vertices.cast<float>()),
        triangles_(mesh.triangles),
        arrays_(static_cast<int>(triangles_.rows()), triangles_.data(), 3 * sizeof(std::int32_t),
                static_cast<int>(vertices_.rows()), vertices_.data(), 3 * sizeof(float)),
        shape_(&arrays_) {
    static_assert(sizeof(btScalar) == sizeof(float));
    shape_.setMargin(static_cast<btScalar>(margin));
    shape_.updateBound();
  }
  btCollisionShape& shape() override { return shape_; }

 private:
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices_;  // arrays_ points into both
  Triangles triangles_;
  btTriangleIndexVertexArray arrays_;
  btGImpactMeshShape shape_;
};

class GImpactMethod : public ContactMethod {
 public:
  GImpactMethod(std::string name, double margin) : name_(std::move(name)), margin_(margin) {}
  std::string name() const override { return name_; }
  std::string description() const override {
    return bench::format("Bullet's btGImpactMeshShape, margin %g mm", 1e3 * margin_);
  }
  std::unique_ptr<MethodShape> make_shape(const SceneBodyModel& body) const override {
    return std::make_unique<GImpactMesh>(body.mesh, margin_);
  }
  std::shared_ptr<void> attach(btCollisionDispatcher& dispatcher) const override {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
    return nullptr;
  }

 private:
  std::string name_;
  double margin_;
};

}  // namespace

std::vector<std::string> all_method_names() { return {"encage", "gimpact", "gimpact_1mm", "hulls"}; }

std::vector<std::string> method_names() {
  std::vector<std::string> names = {"encage", "gimpact", "gimpact_1mm"};
  if (make_hull_method()) names.emplace_back("hulls");
  return names;
}

std::unique_ptr<ContactMethod> make_contact_method(const std::string& name) {
  if (name == "encage") return std::make_unique<EncageMethod>();
  if (name == "gimpact") return std::make_unique<GImpactMethod>(name, 0);
  if (name == "gimpact_1mm") return std::make_unique<GImpactMethod>(name, 1e-3);
  if (name == "hulls") {
    if (auto method = make_hull_method()) return method;
    throw Error("method 'hulls': this program was built without HACD (Debian: libbullet-extras-dev)");
  }
  std::string names;
  for (const std::string& known : method_names()) names += (names.empty() ? "" : ", ") + known;
  throw Error("method '" + name + "': there are " + names);
}

}  // namespace encage::bullet_bench
