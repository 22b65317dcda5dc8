// SPDX-License-Identifier: Apache-2.0
// COUNT copies of a baked model fall on the ground and come to rest. All collision detection of an engine is here.
#include "rigid_body.h"

#include <encage/encage.h>

#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: falling_bodies MODEL.glb COUNT SECONDS\n"), 2;
  encage::World world({.pose_tolerance = 1e-4});  // for rotations in float
  encage::WorldContacts contacts;
  const encage::ShapeId shape = world.add_shape(encage::load_shape(argv[1]));
  const encage::MassProperties mass = encage::mass_properties(*world.shape(shape));
  world.add_half_space({Vector::UnitZ(), 0});
  std::vector<Body> bodies(static_cast<std::size_t>(std::atoi(argv[2])) + 1);  // the last one is the ground
  Body& ground = bodies.back();
  std::vector<encage::BodyId> ids;
  for (float height = 0; Body & body : std::span(bodies).first(bodies.size() - 1)) {
    height += 2.1F * static_cast<float>(mass.radius);
    body.pose =
        Eigen::Translation3f(0.1F * std::sin(height), 0, height) * Eigen::AngleAxisf(height, Eigen::Vector3f::UnitX());
    body.inverse_mass = 1 / mass.mass;
    ids.push_back(world.add_body(shape, body.pose.cast<double>()));
  }
  std::vector<Point> points;
  double deepest = 0;
  for (int step = 0; step * dt < std::atof(argv[3]); ++step) {
    for (std::size_t i = 0; i < ids.size(); ++i) {
      Body& body = bodies[i];
      const Matrix turn = body.pose.linear().cast<double>();
      body.centre = body.pose.cast<double>() * mass.centre;
      body.inverse_inertia = turn * mass.inertia.inverse() * turn.transpose();
      body.velocity.z() -= 9.81 * dt;
      world.set_motion(ids[i], {body.pose.cast<double>(), body.moved().cast<double>()});
    }
    points.clear();
    contacts.find(world, {.margin = 0.003 * mass.radius}, [&](const encage::ContactPair& pair) {
      Body& b = pair.b == encage::BodyId::none ? ground : bodies[index(pair.b)];
      for (const auto& p : pair.points)
        points.push_back({&bodies[index(pair.a)], &b, p.point_a, p.normal, p.separation});
    });
    for (int i = 0; i < 20; ++i) std::for_each(points.begin(), points.end(), [](Point& point) { point.solve(); });
    for (const Point& point : points) deepest = std::max(deepest, -point.separation);
    for (std::size_t i = 0; i < ids.size(); ++i) bodies[i].pose = bodies[i].moved();
  }
  double fastest = 0;
  for (const Body& body : bodies) fastest = std::max(fastest, body.velocity.norm());
  std::printf("%zu bodies, %zu contact points, at most %.1f %% of the radius deep, fastest %.3f\n", ids.size(),
              points.size(), 100 * deepest / mass.radius, fastest);
} catch (const encage::Error& error) {
  return std::fprintf(stderr, "falling_bodies: %s\n", error.what()), 2;
}
