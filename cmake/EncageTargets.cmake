# SPDX-License-Identifier: Apache-2.0
# Settings that every target of ours shares.

# Results must not depend on the machine: no fused multiply-add, no -march=native,
# and baked files are compared byte by byte.
function(encage_settings target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
                                           -Werror -ffp-contract=off)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
endfunction()

# encage_library(name sources...): static or shared library, alias encage::name.
function(encage_library name)
  add_library(encage_${name} ${ARGN})
  add_library(encage::${name} ALIAS encage_${name})
  set_target_properties(encage_${name} PROPERTIES EXPORT_NAME ${name})
  encage_settings(encage_${name})
  target_include_directories(encage_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
endfunction()

# encage_executable(name sources...)
function(encage_executable name)
  add_executable(${name} ${ARGN})
  encage_settings(${name})
endfunction()
