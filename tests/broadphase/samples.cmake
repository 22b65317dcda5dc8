# SPDX-License-Identifier: GPL-3.0-or-later
include_guard(GLOBAL)

# Small shapes with hand-made cages.
add_library(broadphase_samples STATIC ${CMAKE_CURRENT_LIST_DIR}/sample_shapes.cpp
            ${CMAKE_CURRENT_LIST_DIR}/twin_bodies.cpp)
encage_settings(broadphase_samples)
target_link_libraries(broadphase_samples PUBLIC encage::runtime)
