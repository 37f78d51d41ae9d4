# Fuzz targets: fuzz_<name> from <folder>/<name>.fuzz.cc, with a corpus in fuzz/corpus/<name>.
#
# Two ways to run each. In every build with tests it is linked with fuzz/driver.cc, and CTest gives it the corpus and
# mutations of it for SEAM_FUZZ_SECONDS: cheap, with any compiler, blind to coverage. The preset `fuzz` (SEAM_FUZZ)
# links it with libFuzzer, AddressSanitizer and UBSan instead: scripts/fuzz.sh.
set(SEAM_FUZZ_SECONDS 1 CACHE STRING "How long CTest mutates inputs of each fuzz target")
if(SEAM_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
  # Warnings are the business of the ordinary builds.
  target_compile_options(seam_flags INTERFACE -Wno-error)
  add_custom_target(fuzzers)
endif()

# seam_fuzzers(FOLDER LIBRARY): one program for each *.fuzz.cc of the folder.
function(seam_fuzzers folder library)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.fuzz.cc)
  foreach(source ${sources})
    get_filename_component(name ${source} NAME_WE)
    add_executable(fuzz_${name} ${source})
    target_link_libraries(fuzz_${name} PRIVATE ${library})
    target_compile_definitions(fuzz_${name} PRIVATE SEAM_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
    set_target_properties(fuzz_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/fuzz)
    if(SEAM_FUZZ)
      target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
      add_dependencies(fuzzers fuzz_${name})
      continue()
    endif()
    target_sources(fuzz_${name} PRIVATE $<TARGET_OBJECTS:seam_fuzz_driver>)
    read_headers_once(fuzz_${name} libraries)
    set(corpus ${CMAKE_SOURCE_DIR}/fuzz/corpus/${name})
    if(name STREQUAL log)  # One corpus for all readers of logs.
      set(corpus ${CMAKE_SOURCE_DIR}/replays/corpus)
    endif()
    add_test(NAME fuzz.${name} COMMAND fuzz_${name} --seconds ${SEAM_FUZZ_SECONDS} ${corpus})
    set_tests_properties(fuzz.${name} PROPERTIES TIMEOUT 120 LABELS unit)
  endforeach()
endfunction()

# Behind all folders, whose libraries the targets link.
function(seam_all_fuzzers)
  if(NOT SEAM_FUZZ)
    add_library(seam_fuzz_driver OBJECT ${CMAKE_SOURCE_DIR}/fuzz/driver.cc)
    target_link_libraries(seam_fuzz_driver PRIVATE seam_flags)
  endif()
  foreach(folder sim_core effects mcap measurement app)
    seam_fuzzers(${folder} seam_${folder})
  endforeach()
  seam_fuzzers(scheduler seam_replay)
endfunction()
