# Fuzzers (libFuzzer, clang): build/fuzz_<name> from <folder>/<name>.fuzz.cc with a corpus in
# fuzz/corpus/<name>. A build of its own (preset `fuzz`), which makes only the libraries needed:
# scripts/fuzz.sh.
add_compile_options(-fsanitize=fuzzer-no-link,address -fno-omit-frame-pointer)
add_link_options(-fsanitize=address)
# Warnings are the business of the ordinary builds.
target_compile_options(seam_flags INTERFACE -Wno-error)

function(seam_fuzzers folder)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.fuzz.cc)
  foreach(source ${sources})
    get_filename_component(name ${source} NAME_WE)
    add_executable(fuzz_${name} ${source})
    target_link_libraries(fuzz_${name} PRIVATE seam_${folder})
    target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
    add_dependencies(fuzzers fuzz_${name})
  endforeach()
endfunction()
