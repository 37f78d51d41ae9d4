# For find_package(seam) of an installed SEAM: effects outside its tree link seam::plugin, SEAM_PROGRAM is the program that
# loads them, and open_r_add_object() builds objects of programs for an AIBO (seamOpenR.cmake). Every path is relative to this file, so that the tree may be moved.
include(CMakeFindDependencyMacro)
find_dependency(fmt)
get_filename_component(seam_prefix ${CMAKE_CURRENT_LIST_DIR}/../../.. ABSOLUTE)
if(NOT EXISTS ${seam_prefix}/include/seam)
  get_filename_component(seam_prefix ${seam_prefix}/.. ABSOLUTE)  # lib/<architecture>
endif()
set(SEAM_PROGRAM ${seam_prefix}/bin/seam)
if(NOT TARGET seam::plugin)
  add_library(seam::plugin INTERFACE IMPORTED)
  set_target_properties(seam::plugin PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES ${seam_prefix}/include/seam
    INTERFACE_COMPILE_FEATURES cxx_std_20
    # The program and its effects give the same bits on all machines.
    INTERFACE_COMPILE_OPTIONS -ffp-contract=off
    INTERFACE_LINK_LIBRARIES fmt::fmt)
endif()
set(SEAM_OPEN_R_HEADERS ${seam_prefix}/share/seam/open_r/include)
include(${CMAKE_CURRENT_LIST_DIR}/seamOpenR.cmake)
