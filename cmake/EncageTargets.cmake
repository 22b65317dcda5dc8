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

# Headers that most files include are compiled once for each kind of target. Whether files include what they name is
# seen in builds without (-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON), which compiler caches need, and ARM, where targets
# differ in -march.
if(NOT PROJECT_IS_TOP_LEVEL OR CMAKE_CXX_COMPILER_LAUNCHER OR NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
set(encage_common_headers
  <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <atomic> <cmath> <cstdint> <filesystem> <functional> <limits> <map>
  <memory> <mutex> <optional> <random> <set> <span> <sstream> <string> <thread> <utility> <vector>)

# encage_precompile(target KIND kind [OPTIONS option…] [LIBRARIES library…] [HEADERS header…]): what is said of a kind
# has to be the same each time. Options are those that compilers want to be equal.
function(encage_precompile target)
  if(CMAKE_DISABLE_PRECOMPILE_HEADERS)
    return()
  endif()
  # They fill the memory up to which g++ does without collecting garbage: kilobytes, by default 128 MiB.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "KIND" "OPTIONS;LIBRARIES;HEADERS")
  set(headers encage_headers_of_${arg_KIND})
  if(NOT TARGET ${headers})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${headers}.cpp CONTENT "")
    add_library(${headers} OBJECT ${PROJECT_BINARY_DIR}/${headers}.cpp)
    encage_settings(${headers})
    target_compile_options(${headers} PRIVATE ${arg_OPTIONS})
    target_link_libraries(${headers} PRIVATE Eigen3::Eigen ${arg_LIBRARIES})
    target_precompile_headers(${headers} PRIVATE ${encage_common_headers} ${arg_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
  # g++ 12 does not know the standard library by its place any more and warns, wrongly, of the code that it inlines.
  foreach(warning array-bounds free-nonheap-object maybe-uninitialized restrict stringop-overflow stringop-overread)
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-${warning}>)
  endforeach()
endfunction()

# encage_unity(target batch): compiles so many files of the target at a time, which reads headers and instantiates
# templates once for all of them. Names in unnamed namespaces have to differ within a target. Not with compiler caches,
# which know single files.
set(unity ON)
if(NOT PROJECT_IS_TOP_LEVEL OR CMAKE_CXX_COMPILER_LAUNCHER)
  set(unity OFF)
endif()
option(ENCAGE_UNITY_BUILD "Compile several files at a time" ${unity})
function(encage_unity target batch)
  if(ENCAGE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
  endif()
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
  encage_precompile(encage_${name} KIND libraries OPTIONS ${CMAKE_CXX_COMPILE_OPTIONS_VISIBILITY}hidden
                                                          ${CMAKE_CXX_COMPILE_OPTIONS_VISIBILITY_INLINES_HIDDEN})
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

# encage_program(name sources...): a tool with a command line.
function(encage_program name)
  encage_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE CLI11::CLI11 nlohmann_json::nlohmann_json)
  encage_precompile(${name} KIND programs OPTIONS ${CMAKE_CXX_COMPILE_OPTIONS_PIE}
                    LIBRARIES CLI11::CLI11 nlohmann_json::nlohmann_json HEADERS <CLI/CLI.hpp> <nlohmann/json.hpp>)
endfunction()
