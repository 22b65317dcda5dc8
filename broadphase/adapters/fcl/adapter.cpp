// SPDX-License-Identifier: Apache-2.0
#include <encage/fcl.h>

#include <cassert>
#include <limits>
#include <string>
#include <utility>

namespace encage {

void FclShapes::attach(const std::shared_ptr<::fcl::CollisionGeometryd>& geometry, ShapePtr shape, double scale) {
  if (!geometry) throw Error("FCL adapter: no geometry");
  if (!shape) throw Error("FCL adapter: no shape");
  const Motion motion = Motion::resting(Eigen::Isometry3d::Identity(), scale);
  if (!is_usable(motion)) {
    throw Error("FCL adapter: the scale is " + std::to_string(scale) + ", not between 1e-50 and 1e50");
  }
  geometry->computeLocalAABB();
  const Eigen::AlignedBox3d box(geometry->aabb_local.min_, geometry->aabb_local.max_);
  if (box.isEmpty() || !world_box(*shape, motion).contains(box)) {
    throw Error("FCL adapter: the geometry is not within the bounding box of the shape");
  }
  entries_.insert_or_assign(geometry.get(), Entry{geometry, std::move(shape), scale});
}

void FclShapes::detach(const ::fcl::CollisionGeometryd* geometry) noexcept { entries_.erase(geometry); }

std::optional<FclShapes::Body> FclShapes::body(const ::fcl::CollisionObjectd& object) const {
  const auto found = entries_.find(object.collisionGeometry().get());
  if (found == entries_.end()) return std::nullopt;
  return Body{found->second.shape.get(), Motion::resting(object.getTransform(), found->second.scale)};
}

FclCollision::FclCollision(const FclShapes& shapes, ::fcl::CollisionCallBack<double> user, void* data,
                           const PairOptions& options)
    : shapes_(&shapes), user_(user), data_(data), options_(options) {
  assert(user != nullptr);
}

// Returning true would end the manager's search, so a rejected pair returns false.
bool FclCollision::callback(::fcl::CollisionObjectd* a, ::fcl::CollisionObjectd* b, void* collision) {
  FclCollision& self = *static_cast<FclCollision*>(collision);
  const auto body_a = self.shapes_->body(*a), body_b = self.shapes_->body(*b);
  if (body_a && body_b) {
    ++self.statistics_.asked;
    if (separated(*body_a->shape, body_a->motion, *body_b->shape, body_b->motion, self.options_).separated) {
      ++self.statistics_.rejected;
      return false;
    }
  }
  return self.user_(a, b, self.data_);
}

FclDistance::FclDistance(const FclShapes& shapes, ::fcl::DistanceCallBack<double> user, void* data,
                         const FclDistanceOptions& options)
    : shapes_(&shapes), user_(user), data_(data), options_(options) {
  assert(user != nullptr);
}

bool FclDistance::no_nearer(const FclShapes::Body& a, const FclShapes::Body& b, double least) const {
  CageDistanceOptions cages = options_.cages;
  cages.enough = least;
  if (cage_distance_bound(*a.shape, a.motion, *b.shape, b.motion, cages) >= least) return true;
  return options_.fine && distance(*a.shape, a.motion, *b.shape, b.motion, {.limit = least}).lower >= least;
}

bool FclDistance::callback(::fcl::CollisionObjectd* a, ::fcl::CollisionObjectd* b, void* distance, double& least) {
  FclDistance& self = *static_cast<FclDistance*>(distance);
  // No body is as far away as FCL's initial value. A value that is not positive ends the search, and only the user's
  // callback may return that.
  if (least > 0 && least < std::numeric_limits<double>::max()) {
    const auto body_a = self.shapes_->body(*a), body_b = self.shapes_->body(*b);
    if (body_a && body_b) {
      ++self.statistics_.asked;
      if (self.no_nearer(*body_a, *body_b, least)) {
        ++self.statistics_.rejected;
        return false;
      }
    }
  }
  return self.user_(a, b, self.data_, least);
}

}  // namespace encage
