// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/contact.h>

#include <optional>

namespace encage::tank {

/// What a simulation asks about moving copies of one body.
class Detector {
 public:
  virtual ~Detector() = default;

  /// World box of the body at one pose; the box of a linear motion is the union of both ends'.
  virtual Eigen::AlignedBox3d box(const Eigen::Isometry3d& pose) const = 0;
  /// arc_margin() of a motion during which the centre of mass moves on a straight line.
  virtual double arc(const Motion& motion) const = 0;
  virtual std::optional<Contact> pair(const Motion& a, const Motion& b, const ContactOptions& options) const = 0;
  virtual std::optional<Contact> wall(const Motion& motion, const HalfSpace& wall,
                                      const ContactOptions& options) const = 0;
};

/// Encage's own detection.
class ShapeDetector : public Detector {
 public:
  /// `centre` is the centre of mass, in the body frame. Throws Error if the shape has no fine mesh.
  ShapeDetector(ShapePtr shape, const Eigen::Vector3d& centre);

  Eigen::AlignedBox3d box(const Eigen::Isometry3d& pose) const override;
  double arc(const Motion& motion) const override;
  std::optional<Contact> pair(const Motion& a, const Motion& b, const ContactOptions& options) const override;
  std::optional<Contact> wall(const Motion& motion, const HalfSpace& wall,
                              const ContactOptions& options) const override;

 private:
  ShapePtr shape_;
  Eigen::Vector3d centre_;
};

}  // namespace encage::tank
