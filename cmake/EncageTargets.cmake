# SPDX-License-Identifier: Apache-2.0
# Settings that every target of ours shares.

# Results must not depend on the machine: no fused multiply-add, no -march=native,
# and baked files are compared byte by byte.
function(encage_settings target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON
                        COMPILE_WARNING_AS_ERROR ${PROJECT_IS_TOP_LEVEL})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -ffp-contract=off)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
endfunction()

# encage_library(name sources...): a part of ours, alias encage::name. Always static, and never installed: programs
# and tests of this project link parts and see all of them; other projects link the products made of them.
function(encage_library name)
  add_library(encage_${name} STATIC ${ARGN})
  add_library(encage::${name} ALIAS encage_${name})
  encage_settings(encage_${name})
  # What public headers declare says otherwise (encage/export.h).
  set_target_properties(encage_${name} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_include_directories(encage_${name} PUBLIC ${PROJECT_SOURCE_DIR}/include)
endfunction()

# encage_product(name parts...): what other projects link as encage::name, of the objects of these parts: one static
# or one shared library, as BUILD_SHARED_LIBS says.
function(encage_product name)
  set(target encage_${name})
  add_library(${target})
  add_library(encage::${name} ALIAS ${target})
  foreach(part IN LISTS ARGN)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:encage_${part}>)
  endforeach()
  # Until 1.0 a minor version may break the interface.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} LINKER_LANGUAGE CXX POSITION_INDEPENDENT_CODE ON
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
                        INSTALL_RPATH $ORIGIN)
  target_compile_features(${target} INTERFACE cxx_std_20)
  target_include_directories(${target} INTERFACE
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL SHARED_LIBRARY AND CMAKE_EXECUTABLE_FORMAT STREQUAL ELF)
    # Instances of the standard library's templates are visible whatever the compiler is told.
    set(map ${PROJECT_SOURCE_DIR}/cmake/encage.map)
    target_link_options(${target} PRIVATE LINKER:--version-script=${map} LINKER:--no-undefined
                                          LINKER:--exclude-libs,ALL)
    set_target_properties(${target} PROPERTIES LINK_DEPENDS ${map})
  endif()
endfunction()

# encage_executable(name sources...)
function(encage_executable name)
  add_executable(${name} ${ARGN})
  encage_settings(${name})
endfunction()
