# One target a folder: seam_<folder> from its *.cc, test_<folder> from its *.test.cc.
# Sources are found by name, so that adding a file touches no list.

add_library(seam_flags INTERFACE)
target_compile_features(seam_flags INTERFACE cxx_std_20)
target_compile_options(seam_flags INTERFACE -Wall -Wextra -Wpedantic -Werror -Wno-missing-field-initializers
                       -ffp-contract=off -fno-math-errno)
target_include_directories(seam_flags INTERFACE ${CMAKE_SOURCE_DIR})
target_link_libraries(seam_flags INTERFACE Threads::Threads)
if(SEAM_SANITIZE)
  target_compile_options(seam_flags INTERFACE -fsanitize=${SEAM_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all
                         # gcc 12 takes the sanitizers' own code in std::regex for a use before it is set.
                         -Wno-maybe-uninitialized)
  target_link_options(seam_flags INTERFACE -fsanitize=${SEAM_SANITIZE})
  if(SEAM_SANITIZE MATCHES thread)
    add_library(seam_tsan_suppressions OBJECT ${CMAKE_CURRENT_LIST_DIR}/tsan_suppressions.cc)
    target_link_libraries(seam_flags INTERFACE $<TARGET_OBJECTS:seam_tsan_suppressions>)
  endif()
endif()

# The compiler gives memory back rarely: a tenth of its time, for half a gigabyte.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options("SHELL:--param ggc-min-heapsize=524288" "SHELL:--param ggc-min-expand=200")
endif()

find_program(SEAM_MOLD mold)
if(SEAM_MOLD)
  add_link_options(-fuse-ld=mold)
endif()
find_program(SEAM_CCACHE ccache)
if(SEAM_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_CURRENT_LIST_DIR}/ccache.sh ${CMAKE_SOURCE_DIR})
  add_compile_options(-fpch-preprocess)
endif()

# seam_vector_kernels(): loops of this folder that are compiled once for each vector width
# (*_kernels_base.cc, _avx2, _avx512) and chosen when the program starts. None may fuse a multiply
# and an add, which would change bits: -ffp-contract=off (seam_flags) forbids it. Unoptimised
# builds stay so.
function(seam_vector_kernels)
  set(flags -fno-trapping-math)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    list(APPEND flags -O3)
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *_kernels_base.cc *_kernels_avx2.cc *_kernels_avx512.cc)
  foreach(source ${sources})
    set(width_flags)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      if(source MATCHES "_avx2\\.cc$")
        set(width_flags -mavx2 -mno-fma)
      elseif(source MATCHES "_avx512\\.cc$")
        set(width_flags -mavx512f -mavx512vl -mavx512dq -mavx512bw -mprefer-vector-width=512)
      endif()
    endif()
    set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "${flags};${width_flags}" SKIP_PRECOMPILE_HEADERS ON)
  endforeach()
endfunction()

# compile_together(TARGET n): n files of a room at a time, which saves the time of their heavy headers. Files
# of different rooms never meet, so that a name is free to mean another thing next door. In the development
# build each file is compiled alone, which finds what it forgot to include.
function(compile_together target count)
  if(NOT count OR CMAKE_BUILD_TYPE STREQUAL "Debug")
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(room ${source} DIRECTORY)
    file(RELATIVE_PATH room ${CMAKE_SOURCE_DIR} ${room})
    string(MAKE_C_IDENTIFIER "${room}" room)
    list(LENGTH files_${room} position)
    list(APPEND files_${room} ${source})
    math(EXPR batch "${position} / ${count}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room}_${batch})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

# read_headers_once(TARGET FAMILY headers...): what nearly every file includes, and these, is compiled once for all targets of
# a family that ask for the same; targets of a family have the same options. A file still includes what it uses: the
# development build reads each file alone, which finds what was forgotten.
function(read_headers_once target family)
  if(CMAKE_BUILD_TYPE STREQUAL "Debug")
    return()
  endif()
  string(MAKE_C_IDENTIFIER "seam_headers_${family}_${ARGN}" name)
  get_property(first GLOBAL PROPERTY ${name})
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
    return()
  endif()
  set_property(GLOBAL PROPERTY ${name} ${target})
  target_precompile_headers(${target} PRIVATE <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <map> <memory>
                            <mutex> <optional> <string> <thread> <vector> <fmt/format.h> <glm/mat3x3.hpp> ${ARGN})
endfunction()

# seam_module(NAME [ROOMS rooms...] [EXCLUDE regex] [LINK targets...] [UNITY n] [UNITY_TESTS n] [HEADERS headers...]
#             [SLOW tests...] [ALONE]):
# the library of this folder, or of these rooms of it, and, if there are *.test.cc, its test program. UNITY compiles n
# files of the library at a time, UNITY_TESTS those of the tests: for folders of many files. HEADERS are the heavy ones
# that most of them include. SLOW: tests that ./test.sh leaves out (seam_test_program). ALONE: without the headers of the rest
# of the tree, where the folder builds without it.
function(seam_module name)
  cmake_parse_arguments(ARG "ALONE" "UNITY;UNITY_TESTS;EXCLUDE" "ROOMS;LINK;HEADERS;SLOW" ${ARGN})
  set(patterns *.cc)
  if(ARG_ROOMS)
    list(TRANSFORM ARG_ROOMS APPEND /*.cc OUTPUT_VARIABLE patterns)
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${patterns})
  if(ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX "${ARG_EXCLUDE}")
  endif()
  set(tests ${sources})
  list(FILTER tests INCLUDE REGEX "\\.test\\.cc$")
  list(FILTER sources EXCLUDE REGEX "\\.(test|perf|fuzz|main)\\.cc$")
  add_library(seam_${name} STATIC ${sources})
  target_link_libraries(seam_${name} PUBLIC seam_flags ${ARG_LINK})
  compile_together(seam_${name} "${ARG_UNITY}")
  if(NOT ARG_ALONE)
    read_headers_once(seam_${name} libraries ${ARG_HEADERS})
  endif()
  if(SEAM_BUILD_TESTS AND tests)
    seam_test_program(test_${name} SOURCES ${tests} LINK seam_${name} SLOW ${ARG_SLOW})
    compile_together(test_${name} "${ARG_UNITY_TESTS}")
    if(NOT ARG_ALONE)
      read_headers_once(test_${name} tests <gmock/gmock.h> ${ARG_HEADERS})
    endif()
  endif()
endfunction()

# seam_test_program(NAME SOURCES files... LINK targets... [SLOW tests...]): a GoogleTest program known to CTest.
# SEAM_SOURCE_DIR lets a test find the scenarios, models and golden files of the tree. SLOW names tests, as
# --gtest_filter takes them, that take longer than four seconds beside faster tests of the same subject: they have the
# label `slow` (tests/CMakeLists.txt), as have all suites whose names end with Slow.
function(seam_test_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;SLOW" ${ARGN})
  list(JOIN ARG_SLOW ":" slow)
  string(PREPEND slow "*Slow.*:")
  add_executable(${name} ${ARG_SOURCES} ${CMAKE_SOURCE_DIR}/tests/own_folder.cc)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE SEAM_SOURCE_DIR="${CMAKE_SOURCE_DIR}"
                             SEAM_BINARY_DIR="${CMAKE_BINARY_DIR}")
  # The code under test has its full optimisation; what tests themselves compute needs little. g++ 12 warns of strings in
  # the standard library's own headers, where these are read once for a target.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1> $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds> $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 TEST_FILTER "-${slow}" PROPERTIES TIMEOUT 300
                       ENVIRONMENT SEAM_CACHE=off LABELS unit)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 TEST_FILTER "${slow}" TEST_LIST ${name}_SLOW_TESTS PROPERTIES TIMEOUT 600
                       ENVIRONMENT SEAM_CACHE=off LABELS slow)
endfunction()
