// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/embree_tree.h"

#include "tests/bench/tank/swept_meshes.h"

#include <gtest/gtest.h>

namespace encage::tank {
namespace {

class EmbreeTreeOf : public testing::TestWithParam<RTCBuildQuality> {
 protected:
  EmbreeTree a{GetParam()}, b{GetParam()};
};

TEST_P(EmbreeTreeOf, ReportsOverlappingBoxesOfTriangles) { test::expect_brute_force(a, b, 3); }

TEST_P(EmbreeTreeOf, CoincidentTriangles) { test::expect_coincident_triangles(a, b); }

TEST_P(EmbreeTreeOf, EmptyMesh) { test::expect_nothing_of_an_empty_mesh(a, b); }

INSTANTIATE_TEST_SUITE_P(Qualities, EmbreeTreeOf, testing::Values(RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM),
                         [](const auto& quality) { return quality.param == RTC_BUILD_QUALITY_LOW ? "Low" : "Medium"; });

}  // namespace
}  // namespace encage::tank
