# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` copies, and the packages that find it again: CMake's and pkg-config's. All may be moved.
#   --component runtime, development             the run time and the adapters
#   --component offline, offline_development     the program encage and the library that bakes (GPL)
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(encage_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Encage)

# Copies headers, and writes the files by which EncageConfig.cmake finds the component.
function(encage_install_component name development)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "HEADERS;FIND;FIND_PC")
  list(TRANSFORM arg_HEADERS PREPEND ${PROJECT_SOURCE_DIR}/include/encage/)
  install(FILES ${arg_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/encage COMPONENT ${development})

  # EncageConfig.cmake reads the first, then, if all is there that is needed, the second.
  set(calls)
  foreach(package IN LISTS arg_FIND)
    string(APPEND calls "encage_find(${package})\n")
  endforeach()
  foreach(package IN LISTS arg_FIND_PC)
    string(APPEND calls "encage_find_pc(${package})\n")
  endforeach()
  file(CONFIGURE OUTPUT Encage-${name}.cmake CONTENT "${calls}" @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/Encage-${name}.cmake DESTINATION ${encage_package_dir}
          COMPONENT ${development})
  install(EXPORT Encage-${name} NAMESPACE encage:: FILE Encage-${name}-targets.cmake
          DESTINATION ${encage_package_dir} COMPONENT ${development})
endfunction()

# encage_install_header_product(name HEADERS… FIND…): a product without a library, which pkg-config does not know.
function(encage_install_header_product name)
  install(TARGETS encage_${name} EXPORT Encage-${name})
  encage_install_component(${name} development ${ARGN})
endfunction()

# encage_install_product(name component development HEADERS… FIND… FIND_PC… PC… PC_STATIC… PC_LIBS_STATIC…): see
# encage_product.
function(encage_install_product name component development)
  cmake_parse_arguments(PARSE_ARGV 3 arg "" "" "HEADERS;FIND;FIND_PC;PC;PC_STATIC;PC_LIBS_STATIC")
  target_include_directories(encage_${name} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(TARGETS encage_${name} EXPORT Encage-${name}
    LIBRARY COMPONENT ${component} NAMELINK_COMPONENT ${development}
    ARCHIVE COMPONENT ${development})
  encage_install_component(${name} ${development} HEADERS ${arg_HEADERS} FIND ${arg_FIND} FIND_PC ${arg_FIND_PC})

  list(JOIN arg_PC ", " requires)
  list(JOIN arg_PC_STATIC ", " requires_private)
  list(JOIN arg_PC_LIBS_STATIC " " libs_private)
  set(prefix ${CMAKE_INSTALL_PREFIX})
  if(NOT IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
    file(RELATIVE_PATH prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
    string(PREPEND prefix "\${pcfiledir}/")
  endif()
  cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_LIBDIR BASE_DIRECTORY "/prefix" OUTPUT_VARIABLE libdir)
  cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_INCLUDEDIR BASE_DIRECTORY "/prefix" OUTPUT_VARIABLE includedir)
  list(TRANSFORM libdir REPLACE "^/prefix/" "\${prefix}/")
  list(TRANSFORM includedir REPLACE "^/prefix/" "\${prefix}/")
  configure_file(${PROJECT_SOURCE_DIR}/cmake/encage.pc.in encage-${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/encage-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT ${development})
endfunction()

# What belongs to no single product; headers of products that are not built stay away.
function(encage_install_common)
  install(DIRECTORY include/encage DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
    FILES_MATCHING PATTERN *.h
    REGEX "/(bake|bullet|bullet_mesh|decimator|energy|fcl|jolt)\\.h$" EXCLUDE)
  write_basic_package_version_file(EncageConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES cmake/EncageConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/EncageConfigVersion.cmake
          DESTINATION ${encage_package_dir} COMPONENT development)
  install(FILES CHANGELOG.md README.md docs/ENCAGE_cages.schema.json docs/asset.md docs/certificate.md docs/contacts.md
                docs/guarantee.md docs/install.md docs/performance.md
          DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
  set(components runtime development)
  if(ENCAGE_BUILD_CAGEGEN)
    list(APPEND components offline offline_development)
  endif()
  foreach(component IN LISTS components)
    install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT ${component})
    install(DIRECTORY LICENSES DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT ${component})
  endforeach()
endfunction()
