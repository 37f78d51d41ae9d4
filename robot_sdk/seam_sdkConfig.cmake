# For find_package(seam_sdk) of an installed client library.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Protobuf)
find_dependency(PkgConfig)
pkg_check_modules(SEAM_SDK_GRPC REQUIRED IMPORTED_TARGET grpc++)
get_filename_component(seam_sdk_lib ${CMAKE_CURRENT_LIST_DIR}/../.. ABSOLUTE)
get_filename_component(seam_sdk_prefix ${seam_sdk_lib}/.. ABSOLUTE)
if(NOT EXISTS ${seam_sdk_prefix}/include/robot_sdk)
  get_filename_component(seam_sdk_prefix ${seam_sdk_prefix}/.. ABSOLUTE)  # lib/<architecture>
endif()
add_library(seam::sdk STATIC IMPORTED)
set_target_properties(seam::sdk PROPERTIES
  IMPORTED_LOCATION ${seam_sdk_lib}/libseam_robot_sdk.a
  INTERFACE_INCLUDE_DIRECTORIES ${seam_sdk_prefix}/include
  INTERFACE_COMPILE_FEATURES cxx_std_20
  INTERFACE_LINK_LIBRARIES "${seam_sdk_lib}/libseam_grpc.a;${seam_sdk_lib}/libseam_proto.a;PkgConfig::SEAM_SDK_GRPC;protobuf::libprotobuf;Threads::Threads")
