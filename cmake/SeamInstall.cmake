# What `cmake --install` and `cpack -G DEB` put where. Programs find their files from their own place
# (sim_core/system/own_files.h), packages from that of their .cmake and .pc files, so that the tree may be moved.
#
# Components: program, images (what needs OpenCV), sdk (headers and libraries of behaviours and plugins), python; debian_python is the same package
# where Debian's python looks, for the .deb alone.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# seam_install_package(NAME CONFIG PC_IN): what find_package(NAME) and pkg-config read.
function(seam_install_package name config pc)
  set(here ${CMAKE_CURRENT_BINARY_DIR}/package)
  write_basic_package_version_file(${here}/${name}ConfigVersion.cmake VERSION ${PROJECT_VERSION}
                                   COMPATIBILITY SameMinorVersion)
  install(FILES ${config} ${here}/${name}ConfigVersion.cmake
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/${name} COMPONENT sdk)
  file(RELATIVE_PATH prefix_from_here /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  configure_file(${pc} ${here}/${name}.pc @ONLY)
  install(FILES ${here}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT sdk)
endfunction()

# seam_install_program(): everything but the SDK, and the packages of Debian.
function(seam_install_program)
  set(share ${CMAKE_INSTALL_DATADIR}/seam)
  install(TARGETS seam seam-render RUNTIME DESTINATION bin COMPONENT program)
  if(TARGET seam-pictures)
    install(TARGETS seam-pictures RUNTIME DESTINATION bin COMPONENT images)
    install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION share/doc/seam-images RENAME copyright COMPONENT images)
  endif()
  foreach(target ${SEAM_BEHAVIOURS})
    install(TARGETS ${target} RUNTIME DESTINATION lib/seam/behaviours COMPONENT program)
  endforeach()
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/models ${CMAKE_SOURCE_DIR}/scenarios ${CMAKE_SOURCE_DIR}/docs/reference/schemas
          DESTINATION ${share} COMPONENT program PATTERN "*.new" EXCLUDE PATTERN "*.py" EXCLUDE)
  # A sample of the workbench.
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs/tutorial DESTINATION ${share}/docs COMPONENT program PATTERN "*.py" EXCLUDE)
  # Made where npm and python were there.
  install(FILES ${CMAKE_BINARY_DIR}/share/seam/report.html DESTINATION ${share} COMPONENT program OPTIONAL)
  foreach(folder seam/viewer seam/workbench man bash-completion zsh)
    get_filename_component(above ${CMAKE_INSTALL_DATADIR}/${folder} DIRECTORY)
    install(DIRECTORY ${CMAKE_BINARY_DIR}/share/${folder} DESTINATION ${above} COMPONENT program OPTIONAL)
  endforeach()
  foreach(folder effects sim_core)
    install(DIRECTORY ${CMAKE_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/seam COMPONENT sdk
            FILES_MATCHING PATTERN "*.h" PATTERN "*_testing.h" EXCLUDE)
  endforeach()
  set(CMAKE_CURRENT_BINARY_DIR ${CMAKE_BINARY_DIR})
  seam_install_package(seam ${CMAKE_SOURCE_DIR}/tools/seamConfig.cmake ${CMAKE_SOURCE_DIR}/tools/seam.pc.in)
  foreach(package "program seam" "sdk libseam-sdk-dev" "debian_python python3-seam")
    string(REPLACE " " ";" package ${package})
    list(GET package 0 component)
    list(GET package 1 name)
    set(kind COMPONENT ${component})
    if(component STREQUAL debian_python)
      list(APPEND kind EXCLUDE_FROM_ALL)
    endif()
    install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION share/doc/${name} RENAME copyright ${kind})
  endforeach()
  include(SeamPackages)
endfunction()
