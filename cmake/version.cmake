# Target firn_version: the generated header "firn_version.h", looked at again when HEAD or a source has changed.
set(version_header ${CMAKE_BINARY_DIR}/version/firn_version.h)
set(head_log "")
foreach(name logs/HEAD HEAD)  # the log of HEAD changes with every commit, checkout, reset and merge
  execute_process(COMMAND git -C ${CMAKE_SOURCE_DIR} rev-parse --git-path ${name} OUTPUT_VARIABLE path ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
  if(NOT failed)
    get_filename_component(path ${path} ABSOLUTE BASE_DIR ${CMAKE_SOURCE_DIR})
    if(EXISTS ${path})
      list(APPEND head_log ${path})
    endif()
  endif()
endforeach()
set(version_depfile ${CMAKE_BINARY_DIR}/version/firn_version.d)
add_custom_command(OUTPUT ${version_header}
  COMMAND ${CMAKE_COMMAND} -DOUT=${version_header} -DSOURCE=${CMAKE_SOURCE_DIR} -DVERSION=${PROJECT_VERSION} -DOPENCV=${OPENCV_VERSION_TEXT}
          "-DFLAGS=${CMAKE_CXX_COMPILER_VERSION} ${CMAKE_BUILD_TYPE} ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELWITHDEBINFO} ${FIRN_SANITIZE}"
          -DDEPFILE=${version_depfile} -P ${CMAKE_SOURCE_DIR}/cmake/write_version.cmake
  DEPENDS ${head_log} ${CMAKE_SOURCE_DIR}/cmake/write_version.cmake DEPFILE ${version_depfile} COMMENT "" VERBATIM)
add_custom_target(firn_version_generate DEPENDS ${version_header})
add_library(firn_version INTERFACE)
add_dependencies(firn_version firn_version_generate)
target_include_directories(firn_version INTERFACE ${CMAKE_BINARY_DIR}/version)
