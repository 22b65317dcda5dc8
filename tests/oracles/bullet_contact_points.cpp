// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/bullet_contact_points.h"

#include <btBulletCollisionCommon.h>

namespace encage::bullet_bench {

TouchingPair numbers(const btCollisionObject& a, const btCollisionObject& b) {
  return std::minmax(a.getUserIndex(), b.getUserIndex());
}

std::vector<ContactPoint> contact_points(btDispatcher& dispatcher) {
  static_assert(sizeof(btScalar) == sizeof(float));
  std::vector<ContactPoint> points;
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& p = manifold.getContactPoint(k);
      const btVector3 &a = p.m_localPointA, &b = p.m_localPointB, &n = p.m_normalWorldOnB;
      points.push_back({numbers(*manifold.getBody0(), *manifold.getBody1()),
                        {p.m_partId0, p.m_index0, p.m_partId1, p.m_index1},
                        {a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), n.x(), n.y(), n.z(), p.getDistance()}});
    }
  }
  return points;
}

}  // namespace encage::bullet_bench
