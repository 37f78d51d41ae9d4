# open_r_add_object(): builds an object of an OPEN-R program (docs/open-r.md). Wants SEAM_PROGRAM, the program `seam`, and
# SEAM_OPEN_R_HEADERS, the folder of OPEN-R's headers: find_package(seam) sets both.
#
#   open_r_add_object(TARGET FILE NAME8.BIN SOURCES files... [STUB stub.cfg] [STICK folder] [STANDARD 20])
#
# The object is put into MS/OPEN-R/MW/OBJS of the build folder; what STICK holds (MS, with OPEN-R/MW/CONF) goes there, too.
# STUB makes def.h, entry.h and the stub; without it one of the sources is a stub that is written by hand. The language is
# that of the robot's time, with GNU's extensions, unless STANDARD names another.
function(open_r_add_object target)
  cmake_parse_arguments(ARG "" "FILE;STUB;STICK;STANDARD" "SOURCES" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "open_r_add_object(${target}): ${ARG_UNPARSED_ARGUMENTS}: expected FILE, SOURCES, STUB, STICK or STANDARD")
  endif()
  if(NOT ARG_FILE MATCHES "^[A-Za-z0-9_-]+\\.BIN$")
    message(FATAL_ERROR "open_r_add_object(${target}): FILE '${ARG_FILE}', expected the name in OBJECT.CFG, such as MOVEHEAD.BIN")
  endif()
  if(NOT ARG_SOURCES)
    message(FATAL_ERROR "open_r_add_object(${target}): no SOURCES, expected those of the object")
  endif()
  set(folders)
  foreach(source ${ARG_SOURCES})
    get_filename_component(source ${source} ABSOLUTE)
    get_filename_component(folder ${source} DIRECTORY)
    list(APPEND folders ${folder})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  set(made ${CMAKE_CURRENT_BINARY_DIR}/${target}.made)
  if(ARG_STUB)
    get_filename_component(stub ${ARG_STUB} ABSOLUTE)
    file(STRINGS ${stub} name REGEX "^[ \t]*ObjectName[ \t]*:")
    string(REGEX REPLACE ".*:[ \t]*([A-Za-z0-9_]+).*" "\\1" name "${name}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${stub})
    add_custom_command(OUTPUT ${made}/${name}Stub.cc ${made}/def.h ${made}/entry.h DEPENDS ${stub}
                       COMMAND ${SEAM_PROGRAM} open-r stub ${stub} --out ${made} VERBATIM)
    list(APPEND ARG_SOURCES ${made}/${name}Stub.cc ${made}/def.h ${made}/entry.h)
  endif()
  if(NOT ARG_STANDARD)
    set(ARG_STANDARD 98)
    set(permissive $<$<COMPILE_LANGUAGE:CXX>:-fpermissive>)
  endif()
  set(stick ${CMAKE_CURRENT_BINARY_DIR}/MS)
  add_library(${target} MODULE ${ARG_SOURCES})
  set_target_properties(${target} PROPERTIES PREFIX "" SUFFIX "" OUTPUT_NAME ${ARG_FILE} POSITION_INDEPENDENT_CODE ON
                        LIBRARY_OUTPUT_DIRECTORY ${stick}/OPEN-R/MW/OBJS
                        CXX_STANDARD ${ARG_STANDARD} CXX_EXTENSIONS ON)
  target_include_directories(${target} PRIVATE ${made} ${folders})
  foreach(room system objects robot network)
    target_include_directories(${target} SYSTEM PRIVATE ${SEAM_OPEN_R_HEADERS}/${room})
  endforeach()
  # Objects of one process share no statics of templates; numbers have the same bits everywhere.
  target_compile_options(${target} PRIVATE ${permissive} -w $<$<COMPILE_LANGUAGE:CXX>:-fno-gnu-unique>
                         -fno-strict-aliasing -ffp-contract=off)
  target_link_options(${target} PRIVATE -Wl,-Bsymbolic -Wl,@${SEAM_OPEN_R_HEADERS}/link_options)
  if(ARG_STICK)
    get_filename_component(given ${ARG_STICK} ABSOLUTE)
    add_custom_command(TARGET ${target} POST_BUILD COMMAND ${CMAKE_COMMAND} -E copy_directory ${given} ${stick} VERBATIM)
  endif()
endfunction()
