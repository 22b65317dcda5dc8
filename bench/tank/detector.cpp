// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/detector.h"

#include "broadphase/shape/shape.h"

#include <encage/error.h>

#include <utility>

namespace encage::tank {

ShapeDetector::ShapeDetector(ShapePtr shape, const Eigen::Vector3d& centre)
    : shape_(std::move(shape)), centre_(centre) {
  if (shape_->simple().fine.empty()) throw Error("simulation: the asset has no fine mesh");
}

Eigen::AlignedBox3d ShapeDetector::box(const Eigen::Isometry3d& pose) const {
  return world_box(*shape_, Motion::resting(pose));
}

double ShapeDetector::arc(const Motion& motion) const { return arc_margin(*shape_, motion, centre_); }

std::optional<Contact> ShapeDetector::pair(const Motion& a, const Motion& b, const ContactOptions& options) const {
  return first_contact(*shape_, a, *shape_, b, options);
}

std::optional<Contact> ShapeDetector::wall(const Motion& motion, const HalfSpace& wall,
                                           const ContactOptions& options) const {
  return first_contact(*shape_, motion, wall, options);
}

}  // namespace encage::tank
