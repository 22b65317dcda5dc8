// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/mesh_source.h"

#include "broadphase/adapters/bullet/convert.h"

#include <encage/error.h>

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

namespace encage::bullet {
namespace {

/// One part of a mesh, which may be read while this object lives.
class LockedPart {
 public:
  LockedPart(const btStridingMeshInterface& source, int part) : source_(source), part_(part) {
    source.getLockedReadOnlyVertexIndexBase(&vertex_base_, vertex_count, vertex_type_, vertex_stride_, &index_base_,
                                            index_stride_, triangle_count, index_type_, part);
  }
  ~LockedPart() { source_.unLockReadOnlyVertexBase(part_); }
  LockedPart(const LockedPart&) = delete;
  LockedPart& operator=(const LockedPart&) = delete;

  Eigen::RowVector3d vertex(int v) const {
    const unsigned char* const at = vertex_base_ + static_cast<std::ptrdiff_t>(v) * vertex_stride_;
    if (vertex_type_ == PHY_FLOAT) return numbers<float>(at).cast<double>();
    if (vertex_type_ == PHY_DOUBLE) return numbers<double>(at);
    throw unknown("vertices", vertex_type_);
  }

  Eigen::RowVector3i triangle(int t) const {
    const unsigned char* const at = index_base_ + static_cast<std::ptrdiff_t>(t) * index_stride_;
    if (index_type_ == PHY_INTEGER) return numbers<std::int32_t>(at);
    if (index_type_ == PHY_SHORT) return numbers<std::uint16_t>(at).cast<std::int32_t>();
    if (index_type_ == PHY_UCHAR) return numbers<std::uint8_t>(at).cast<std::int32_t>();
    throw unknown("indices", index_type_);
  }

  int vertex_count = 0, triangle_count = 0;

 private:
  template <class Number>
  static Eigen::Matrix<Number, 1, 3> numbers(const unsigned char* at) {
    return Eigen::Map<const Eigen::Matrix<Number, 1, 3>>(reinterpret_cast<const Number*>(at));
  }

  Error unknown(const char* what, PHY_ScalarType type) const {
    return Error("Bullet mesh: part " + std::to_string(part_) + " has " + what + " of unknown type " +
                 std::to_string(type));
  }

  const btStridingMeshInterface& source_;
  int part_;
  const unsigned char *vertex_base_ = nullptr, *index_base_ = nullptr;
  int vertex_stride_ = 0, index_stride_ = 0;
  PHY_ScalarType vertex_type_ = PHY_FLOAT, index_type_ = PHY_INTEGER;
};

class Collector final : public btTriangleCallback {
 public:
  void processTriangle(btVector3* triangle, int, int) override {
    for (int k = 0; k < 3; ++k) corners.push_back({triangle[k].x(), triangle[k].y(), triangle[k].z()});
  }

  std::vector<std::array<btScalar, 3>> corners;
};

}  // namespace

TriangleMesh copy_source(const btStridingMeshInterface& source) {
  TriangleMesh mesh;
  for (int p = 0; p < source.getNumSubParts(); ++p) {
    const LockedPart part(source, p);
    const Eigen::Index first = mesh.vertices.rows(), begin = mesh.triangles.rows();
    mesh.vertices.conservativeResize(first + part.vertex_count, 3);
    mesh.triangles.conservativeResize(begin + part.triangle_count, 3);
    for (int v = 0; v < part.vertex_count; ++v) mesh.vertices.row(first + v) = part.vertex(v);
    for (int t = 0; t < part.triangle_count; ++t) {
      mesh.triangles.row(begin + t) = part.triangle(t).array() + static_cast<std::int32_t>(first);
    }
  }
  return mesh;
}

TriangleMesh collect_triangles(const btConcaveShape& shape) {
  btVector3 low, high;
  shape.getAabb(btTransform::getIdentity(), low, high);
  const btVector3 more = btScalar(0.01) * (high - low) + btVector3(1, 1, 1) * shape.getMargin();
  Collector collector;
  shape.processAllTriangles(&collector, low - more, high + more);

  const auto& corners = collector.corners;
  std::vector<std::int32_t> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t i, std::int32_t j) {
    return corners[static_cast<std::size_t>(i)] < corners[static_cast<std::size_t>(j)];
  });
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(corners.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(corners.size() / 3), 3);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::array<btScalar, 3>& corner = corners[static_cast<std::size_t>(order[i])];
    if (i == 0 || corner != corners[static_cast<std::size_t>(order[i - 1])]) {
      mesh.vertices.row(count++) << corner[0], corner[1], corner[2];
    }
    mesh.triangles(order[i] / 3, order[i] % 3) = count - 1;
  }
  mesh.vertices.conservativeResize(count, 3);
  return mesh;
}

}  // namespace encage::bullet
