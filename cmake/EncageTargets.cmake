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

# What other projects link as encage::name: the objects of these parts as one library, static or shared as
# BUILD_SHARED_LIBS says.
#   encage_product(name PARTS part… [OFFLINE]
#                  [HEADERS header…]                         of include/encage/, if no other product has them
#                  [FIND "package argument…"…] [FIND_STATIC …]   what find_package(Encage) has to find with it
#                  [FIND_PC "name module…"…]                 the same by pkg-config, as PkgConfig::name
#                  [PC module…] [PC_STATIC module…] [PC_LIBS_STATIC -llibrary…])       the same for pkg-config
function(encage_product name)
  cmake_parse_arguments(PARSE_ARGV 1 arg OFFLINE "" "PARTS;HEADERS;FIND;FIND_STATIC;FIND_PC;PC;PC_STATIC;PC_LIBS_STATIC")
  set(target encage_${name})
  add_library(${target})
  add_library(encage::${name} ALIAS ${target})
  foreach(part IN LISTS arg_PARTS)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:encage_${part}>)
  endforeach()
  # Until 1.0 a minor version may break the interface.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} LINKER_LANGUAGE CXX INSTALL_RPATH $ORIGIN
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(${target} INTERFACE cxx_std_20)
  target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>)

  get_target_property(type ${target} TYPE)
  if(type STREQUAL STATIC_LIBRARY)
    list(APPEND arg_FIND ${arg_FIND_STATIC})
  else()
    set(arg_PC_STATIC)
    set(arg_PC_LIBS_STATIC)
    if(CMAKE_EXECUTABLE_FORMAT STREQUAL ELF)
      # Instances of the standard library's templates are visible whatever the compiler is told.
      set(map ${PROJECT_SOURCE_DIR}/cmake/encage.map)
      target_link_options(${target} PRIVATE LINKER:--version-script=${map} LINKER:--no-undefined
                                            LINKER:--exclude-libs,ALL)
      set_target_properties(${target} PROPERTIES LINK_DEPENDS ${map})
    endif()
  endif()
  if(ENCAGE_INSTALL)
    set(components runtime development)
    if(arg_OFFLINE)
      set(components offline offline_development)
    endif()
    encage_install_product(${name} ${components} HEADERS ${arg_HEADERS} FIND ${arg_FIND}
                           FIND_PC ${arg_FIND_PC} PC ${arg_PC} PC_STATIC ${arg_PC_STATIC}
                           PC_LIBS_STATIC ${arg_PC_LIBS_STATIC})
  endif()
endfunction()

# encage_executable(name sources...)
function(encage_executable name)
  add_executable(${name} ${ARGN})
  encage_settings(${name})
endfunction()
