# SPDX-License-Identifier: Apache-2.0
# find_package(Encage 0.1 [COMPONENTS broadphase cagegen bullet fcl jolt]): each component is a target encage::COMPONENT.
# Without components, broadphase, which all others need. Looks for what the components asked for need, nothing else.

set(encage_components broadphase ${Encage_FIND_COMPONENTS})
list(REMOVE_DUPLICATES encage_components)
set(Encage_FIND_REQUIRED_broadphase TRUE)

# For the files of the components: what encage_component needs.
macro(encage_find)
  find_package(${ARGV} QUIET)
  if(NOT ${ARGV0}_FOUND)
    string(JOIN " " encage_reason "needs what is not found:" ${ARGV})
    set(Encage_${encage_component}_FOUND FALSE)
  endif()
endmacro()

# The same for what comes with pkg-config alone: target PkgConfig::name.
macro(encage_find_pc name)
  encage_find(PkgConfig)
  if(PkgConfig_FOUND)
    pkg_check_modules(${name} QUIET IMPORTED_TARGET GLOBAL ${ARGN})
  endif()
  if(NOT TARGET PkgConfig::${name})
    string(JOIN " " encage_reason "needs what pkg-config does not find:" ${ARGN})
    set(Encage_${encage_component}_FOUND FALSE)
  endif()
endmacro()

set(Encage_NOT_FOUND_MESSAGE)
foreach(encage_component IN LISTS encage_components)
  set(Encage_${encage_component}_FOUND FALSE)
  if(NOT EXISTS ${CMAKE_CURRENT_LIST_DIR}/Encage-${encage_component}.cmake)
    file(GLOB encage_installed RELATIVE ${CMAKE_CURRENT_LIST_DIR} ${CMAKE_CURRENT_LIST_DIR}/Encage-*-targets.cmake)
    list(TRANSFORM encage_installed REPLACE "Encage-(.*)-targets.cmake" "\\1")
    string(JOIN " " encage_reason "is not installed here; what is:" ${encage_installed})
  elseif(NOT encage_component STREQUAL broadphase AND NOT Encage_broadphase_FOUND)
    set(encage_reason "needs the component broadphase")
  else()
    set(Encage_${encage_component}_FOUND TRUE)
    include(${CMAKE_CURRENT_LIST_DIR}/Encage-${encage_component}.cmake)
  endif()
  if(Encage_${encage_component}_FOUND)
    include(${CMAKE_CURRENT_LIST_DIR}/Encage-${encage_component}-targets.cmake)
  elseif(Encage_FIND_REQUIRED_${encage_component})
    set(Encage_FOUND FALSE)
    string(APPEND Encage_NOT_FOUND_MESSAGE "component ${encage_component} ${encage_reason}\n")
  endif()
endforeach()

foreach(encage_variable IN ITEMS component components installed reason variable)
  unset(encage_${encage_variable})
endforeach()
