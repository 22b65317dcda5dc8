# SPDX-License-Identifier: GPL-3.0-or-later
# The same programs for every way to link: consumer_COMPONENT of COMPONENT.cpp, for each of COMPONENTS.
foreach(component IN LISTS COMPONENTS)
  add_executable(consumer_${component} ${CMAKE_CURRENT_LIST_DIR}/${component}.cpp)
  target_link_libraries(consumer_${component} PRIVATE encage::${component})
endforeach()
if(TARGET consumer_jolt)
  # Jolt's headers assert without it, by functions that only a debug build of Jolt has.
  target_compile_definitions(consumer_jolt PRIVATE NDEBUG)
endif()
