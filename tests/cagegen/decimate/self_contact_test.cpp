// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/self_contact.h"

#include "cagegen/decimate/decimate.h"
#include "tests/cagegen/decimate/shapes.h"

#include <algorithm>

namespace encage::makers {
namespace {

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh, std::int32_t t) {
  Eigen::AlignedBox3d box;
  for (const Point& p : corners(mesh, t)) box.extend(p);
  return box;
}

TEST(SelfContacts, AgreeWithBruteForce) {
  shapes::Random random(5);
  std::size_t total = 0;
  for (int round = 0; round < 40; ++round) {
    TriangleMesh soup = shapes::mesh({}, {});
    for (int i = 0; i < 60; ++i) {
      const Corners t = shapes::awkward_triangle(random, 0.4);
      const Point at = random.point(1);
      soup = shapes::with_triangle(soup, t[0] + at, t[1] + at, t[2] + at);
    }
    for (const double gap : {0.0, 1e-5, 0.05}) {
      auto found = self_contacts(soup, gap);
      std::sort(found.begin(), found.end());
      total += found.size();
      for (std::int32_t s = 0; s < 60; ++s) {
        const bool valid = Prism(corners(soup, s)).valid;
        EXPECT_EQ(std::binary_search(found.begin(), found.end(), TrianglePair{s, s}), !valid);
        for (std::int32_t t = s + 1; t < 60 && valid; ++t) {
          // Of slivers, whose own axes fail, the tree may rule out more than the test of the pair.
          const bool apart = separated(indices(soup, s), corners(soup, s), indices(soup, t), corners(soup, t), gap);
          const bool far = box_of(soup, s).exteriorDistance(box_of(soup, t)) > gap;
          const bool hit = std::binary_search(found.begin(), found.end(), TrianglePair{s, t});
          if (apart) {
            EXPECT_FALSE(hit);
          } else if (!far) {
            EXPECT_TRUE(hit) << s << ' ' << t;
          }
        }
      }
    }
  }
  EXPECT_GT(total, 1000u);
}

TEST(SelfContacts, NoneWhereExactArithmeticFindsSome) {
  int clean = 0;
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    const TriangleMesh mesh = shapes::bumpy_sphere(3, seed, 0.02 * (seed % 6));
    if (!self_contacts(mesh, 1e-5).empty()) continue;
    ++clean;
    EXPECT_TRUE(shapes::embedded(mesh)) << seed;
  }
  EXPECT_GE(clean, 10);
  EXPECT_TRUE(self_contacts(shapes::stabbed_sphere(3, -0.2), 1e-3).empty()) << "a spike inside";
  EXPECT_FALSE(self_contacts(shapes::stabbed_sphere(3, 0.2), 0).empty()) << "and through";
}

TEST(SelfContacts, WithinTheGapOnly) {
  const TriangleMesh cubes = shapes::joined(shapes::cube(1), shapes::cube(1, {2.01, 0, 0}));
  EXPECT_TRUE(self_contacts(cubes, 0.0099).empty());
  const auto pairs = self_contacts(cubes, 0.0101);
  ASSERT_FALSE(pairs.empty());
  for (const TrianglePair& pair : pairs) {
    EXPECT_LT(pair[0], 12);
    EXPECT_GE(pair[1], 12);
  }
}

}  // namespace
}  // namespace encage::makers
