# What `--version` says: the project's version and, where git knows it, the commit that was built. Logs and results hold
# the version alone, so that their bytes do not depend on the commit.
#
# seam_version_header(TARGET): the target includes "seam_built_from.h", which each build looks after and rewrites only
# where it has changed.
if(CMAKE_SCRIPT_MODE_FILE)
  execute_process(COMMAND git -C ${SOURCE} describe --always --exclude=* --abbrev=10 --dirty=-changed
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  set(built_from "${VERSION}")
  # An archive of the sources lies in no repository, or in somebody else's.
  if(commit AND EXISTS ${SOURCE}/.git)
    string(APPEND built_from " (commit ${commit})")
  endif()
  set(text "#pragma once\n#define SEAM_BUILT_FROM \"${built_from}\"\n")
  set(old "")
  if(EXISTS ${HEADER})
    file(READ ${HEADER} old)
  endif()
  if(NOT text STREQUAL old)
    file(WRITE ${HEADER} "${text}")
  endif()
  return()
endif()

function(seam_version_header)
  set(folder ${CMAKE_BINARY_DIR}/generated/version)
  set(header ${folder}/seam_built_from.h)
  add_custom_target(built_from BYPRODUCTS ${header} VERBATIM
    COMMAND ${CMAKE_COMMAND} -DSOURCE=${CMAKE_SOURCE_DIR} -DVERSION=${PROJECT_VERSION} -DHEADER=${header}
            -P ${CMAKE_SOURCE_DIR}/cmake/SeamVersion.cmake)
  foreach(target ${ARGV})
    add_dependencies(${target} built_from)
    target_include_directories(${target} PRIVATE ${folder})
  endforeach()
endfunction()
