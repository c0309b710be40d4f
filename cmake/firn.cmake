# firn_pch, firn_cold_pch: the standard headers, parsed once for each level of optimization: GCC compiles their templates at the
# level of the precompiled header, whatever options the source has. Off under sanitizers, so that a file that forgets an include
# is found.
if(FIRN_SANITIZE OR FIRN_FUZZ)
  set(pch_default OFF)
else()
  set(pch_default ON)
endif()
option(FIRN_PCH "parse the standard headers once" ${pch_default})
function(firn_precompile name headers)
  cmake_parse_arguments(ARG "" "" "OPTIONS" ${ARGN})
  set(source ${CMAKE_BINARY_DIR}/pch/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "namespace firn {}\n")
  add_library(${name} OBJECT ${source})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_precompile_headers(${name} PRIVATE ${headers})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
  # ccache takes this sum for the precompiled header's 80 MB, so that checkouts share what they compiled.
  file(SHA256 ${headers} sum)
  string(SHA256 sum "${sum} ${CMAKE_CXX_COMPILER_VERSION} ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELWITHDEBINFO} ${ARGN}")
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${name}.dir/cmake_pch.hxx.gch.sum "${sum}")
endfunction()
set(FIRN_COLD_OPTIONS -Og)
if(FIRN_PCH)
  firn_precompile(firn_pch ${CMAKE_SOURCE_DIR}/cmake/standard_headers.h)
  firn_precompile(firn_cold_pch ${CMAKE_SOURCE_DIR}/cmake/standard_headers.h OPTIONS ${FIRN_COLD_OPTIONS})
endif()

# firn_shared(TARGET): this shared library is linked with rooms, whose objects must not depend on their place then. A call within a
# room stays direct, as in a program. Other rooms are compiled as before.
function(firn_shared target)
  if(FIRN_PCH)
    set(headers ${CMAKE_SOURCE_DIR}/cmake/standard_headers.h)
    firn_precompile(firn_shared_pch ${headers} OPTIONS ${FIRN_SHARED_OPTIONS})
    firn_precompile(firn_shared_cold_pch ${headers} OPTIONS ${FIRN_COLD_OPTIONS} ${FIRN_SHARED_OPTIONS})
  endif()
  set(waiting ${target})
  set(seen "")
  while(waiting)
    list(POP_FRONT waiting room)
    list(APPEND seen ${room})
    get_target_property(type ${room} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      target_compile_options(${room} PRIVATE ${FIRN_SHARED_OPTIONS})
      get_target_property(precompiled ${room} PRECOMPILE_HEADERS_REUSE_FROM)
      if(precompiled)
        string(REGEX REPLACE "^firn_" "firn_shared_" precompiled ${precompiled})
        set_target_properties(${room} PROPERTIES PRECOMPILE_HEADERS_REUSE_FROM ${precompiled})
      endif()
    endif()
    get_target_property(linked ${room} LINK_LIBRARIES)
    foreach(next ${linked})
      if(next MATCHES "^firn_" AND TARGET ${next} AND NOT next IN_LIST seen)
        list(APPEND waiting ${next})
      endif()
    endforeach()
    list(REMOVE_DUPLICATES waiting)
  endwhile()
endfunction()
set(FIRN_SHARED_OPTIONS -fPIC -fno-semantic-interposition)

# CMAKE_UNITY_BUILD: the sources of a library or of tests are compiled several at a time, since parsing headers and instantiating
# templates is most of their time. Off in Debug and under sanitizers, as above. Two sources that use one name for two things
# cannot share a batch: the compiler says so, and firn_alone takes one of them out. CMake takes out a source with options of its own.
set(unity_default ${pch_default})
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  set(unity_default OFF)
endif()
option(CMAKE_UNITY_BUILD "compile some sources several at a time" ${unity_default})

# firn_batches(NAME MOST): its batches have at most MOST sources, and about as many each.
function(firn_batches name most)
  get_target_property(sources ${name} SOURCES)
  list(LENGTH sources length)
  math(EXPR batches "(${length} + ${most} - 1) / ${most}")
  math(EXPR size "(${length} + ${batches} - 1) / ${batches}")
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE ${size})
  if(length EQUAL 1)
    set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
  elseif(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${name} PRIVATE -Wno-subobject-linkage)  # a class defined in a source is not in the main one here
  endif()
endfunction()

# firn_batches_by_folder(NAME): a batch is a folder.
function(firn_batches_by_folder name)
  set_target_properties(${name} PROPERTIES UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${name} SOURCES)
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "folder_${folder}" group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
endfunction()

# firn_alone(sources…): sources that no batch takes in.
function(firn_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# firn_hot(sources…): sources of a COLD library that compute. Without its precompiled header, which is of another level.
function(firn_hot)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -O2 SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# firn_library(NAME sources… [COLD] [BY_FOLDER] LINK targets… PRIVATE_LINK targets…): one library of the house; headers are
# included by full path from the root. COLD code runs once or waits for people or instruments: -Og compiles it in half of the
# time, and a batch may be large, which has less to compile twice and inlines less. BY_FOLDER: no batch crosses folders, of which
# some may call what others may not (scripts/check_symbols.py).
function(firn_library name)
  cmake_parse_arguments(ARG "COLD;BY_FOLDER" "" "LINK;PRIVATE_LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/firn>)
  target_link_libraries(${name} PUBLIC ${ARG_LINK} PRIVATE ${ARG_PRIVATE_LINK})
  set(pch firn_pch)
  set(most 10)
  if(ARG_COLD)
    target_compile_options(${name} PRIVATE ${FIRN_COLD_OPTIONS})
    set(pch firn_cold_pch)
    set(most 24)
  endif()
  if(FIRN_PCH)
    target_precompile_headers(${name} REUSE_FROM ${pch})
  endif()
  firn_batches(${name} ${most})
  if(ARG_BY_FOLDER)
    firn_batches_by_folder(${name})
  endif()
  set_property(GLOBAL APPEND PROPERTY firn_libraries ${name})
endfunction()

# firn_write_links(): BUILD/links.txt, a line for each library and the libraries that it is linked with: scripts/check_links.py
# holds them against what the object files call.
function(firn_write_links)
  get_property(waiting GLOBAL PROPERTY firn_libraries)
  set(seen "")
  set(text "")
  while(waiting)
    list(POP_FRONT waiting library)
    if(library IN_LIST seen)
      continue()
    endif()
    list(APPEND seen ${library})
    get_target_property(linked ${library} LINK_LIBRARIES)
    get_target_property(passed ${library} INTERFACE_LINK_LIBRARIES)
    set(line "${library}")
    foreach(next ${linked} ${passed})
      string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" next ${next})
      if(TARGET ${next} AND next MATCHES "^firn_")
        string(APPEND line " ${next}")
        list(APPEND waiting ${next})
      endif()
    endforeach()
    string(APPEND text "${line}\n")
  endwhile()
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/links.txt CONTENT "${text}")
endfunction()

# firn_process(NAME main.cpp [DEMO] LINK targets…): one executable in build/bin; `programs` builds them all, `demo` those
# that ./firn demo starts.
add_custom_target(programs)
add_custom_target(demo)
function(firn_process name)
  cmake_parse_arguments(ARG "DEMO" "" "LINK" ${ARGN})
  add_executable(${name} ${ARG_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
  target_compile_options(${name} PRIVATE ${FIRN_COLD_OPTIONS})
  if(FIRN_PCH)
    target_precompile_headers(${name} REUSE_FROM firn_cold_pch)
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD OFF RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
  add_dependencies(programs ${name})
  set_property(GLOBAL APPEND PROPERTY firn_programs ${name})
  if(ARG_DEMO)
    add_dependencies(demo ${name})
  endif()
endfunction()

# firn_without_lines(PROGRAM): tests and benches keep their functions' names but no line numbers, half of their bytes. A
# sanitizer's report and a Debug build have them.
function(firn_without_lines name)
  if(NOT FIRN_SANITIZE AND CMAKE_BUILD_TYPE STREQUAL RelWithDebInfo)
    target_link_options(${name} PRIVATE -Wl,--strip-debug)
  endif()
endfunction()

# firn_test(NAME sources… [COMPUTES] LINK targets… LABELS labels…): one Catch2 program; each TEST_CASE becomes one ctest test.
# COMPUTES: most of its time is spent in its own sources and in templates that these instantiate.
# Labels: live = separate processes and real time, runs alone; threads = runs under ./firn test --tsan;
# full = only in ./firn test --full: builds the tree again, or takes more than half a minute. COST: [s].
add_custom_target(thread_tests)
set(FIRN_TEST_OPTIONS -O0 -g0)  # three fifths of -O1's time to compile; precompiled headers are of one level too
set(FIRN_COMPUTING_TEST_OPTIONS -Og -g0)
if(FIRN_SANITIZE)
  set(FIRN_TEST_OPTIONS -O1)
  set(FIRN_COMPUTING_TEST_OPTIONS -Og)
endif()
function(firn_test name)
  cmake_parse_arguments(ARG "COMPUTES" "LABEL;TIMEOUT" "LINK;LABELS" ${ARGN})
  set(kind TEST)
  if(ARG_COMPUTES)
    set(kind COMPUTING_TEST)
  endif()
  add_executable(${name} ${ARG_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE firn_catch_main ${ARG_LINK})
  target_compile_options(${name} PRIVATE ${FIRN_${kind}_OPTIONS})
  target_compile_definitions(${name} PRIVATE
    FIRN_SOURCE_DIR="${CMAKE_SOURCE_DIR}" FIRN_BINARY_DIR="${CMAKE_BINARY_DIR}")
  if(FIRN_PCH)
    string(TOLOWER firn_${kind}_pch pch)
    target_precompile_headers(${name} REUSE_FROM ${pch})
  endif()
  firn_batches(${name} 32)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  firn_without_lines(${name})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  if(FIRN_SANITIZE)  # ASan and TSan are 2 to 15 times slower
    math(EXPR ARG_TIMEOUT "4 * ${ARG_TIMEOUT}")
  endif()
  set(labels ${ARG_LABEL} ${ARG_LABELS})
  set(alone FALSE)
  if("live" IN_LIST labels)
    set(alone TRUE)
  endif()
  if("threads" IN_LIST labels)
    add_dependencies(thread_tests ${name})
  endif()
  list(JOIN labels "-" labels)  # one label, which ctest -L and -LE match by part
  catch_discover_tests(${name} TEST_PREFIX "${name}: " PROPERTIES TIMEOUT ${ARG_TIMEOUT} RUN_SERIAL ${alone} LABELS "${labels}"
    SKIP_RETURN_CODE 77)  # tests/support/skip.h
endfunction()

# firn_bench_program(NAME [sources…] [OUTCOMES] LINK targets…): one program in build/bench, which measures. OUTCOMES: it counts
# what happens and times nothing of its own process, so that it is compiled like a test.
function(firn_bench_program name)
  cmake_parse_arguments(ARG "OUTCOMES" "" "LINK" ${ARGN})
  add_executable(${name} ${ARG_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
  target_compile_definitions(${name} PRIVATE
    FIRN_SOURCE_DIR="${CMAKE_SOURCE_DIR}" FIRN_BINARY_DIR="${CMAKE_BINARY_DIR}")
  set(pch firn_pch)
  if(ARG_OUTCOMES)
    target_compile_options(${name} PRIVATE ${FIRN_TEST_OPTIONS})
    set(pch firn_test_pch)
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
  if(FIRN_PCH)
    target_precompile_headers(${name} REUSE_FROM ${pch})
  endif()
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bench)
  firn_without_lines(${name})
endfunction()

# firn_bench(NAME sources… IN PROGRAM): build/bench/NAME is PROGRAM by another name, which chooses this bench
# (tests/bench/bench.h): most of a bench's cost is what its headers bring, once for all of a program.
# firn_bench(NAME sources… [OUTCOMES] LINK targets…): a program of its own.
function(firn_bench name)
  cmake_parse_arguments(ARG "" "IN" "" ${ARGN})
  if(NOT ARG_IN)
    firn_bench_program(${name} ${ARGN})
    return()
  endif()
  target_sources(${ARG_IN} PRIVATE ${ARG_UNPARSED_ARGUMENTS})
  set(link ${CMAKE_BINARY_DIR}/bench/${name})
  add_custom_command(OUTPUT ${link} COMMAND ${CMAKE_COMMAND} -E create_symlink ${ARG_IN} ${link} DEPENDS ${ARG_IN} VERBATIM)
  add_custom_target(${name} ALL DEPENDS ${link})
endfunction()

# firn_lcm_types(TARGET): every .lcm file here becomes a message. lcm-gen makes the classes; generate.py makes the list of
# all types, enums, channel constants and, in FIRN_MESSAGE_TABLES, limits, channel rows and the texts of the .lcm files.
function(firn_lcm_types target)
  find_program(LCM_GEN lcm-gen REQUIRED)
  find_program(PYTHON3 python3 REQUIRED)
  set(out ${CMAKE_BINARY_DIR}/lcmgen)
  # A new file changes its folder: CMake runs again then. CONFIGURE_DEPENDS would look anew at every build, and
  # no build would ever be "no work to do" (./firn asks for that).
  file(GLOB files ${CMAKE_CURRENT_SOURCE_DIR}/*_t.lcm)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR})
  set(generated ${out}/firn/all_types.h ${out}/firn/enums.h ${out}/firn/channels.h ${out}/message_tables.cpp)
  add_custom_command(OUTPUT ${out}/generated
    COMMAND ${PYTHON3} -B ${CMAKE_CURRENT_SOURCE_DIR}/generate.py ${CMAKE_SOURCE_DIR} ${out} ${files}
    BYPRODUCTS ${generated}
    DEPENDS ${files} generate.py channels.table DEPFILE ${out}/generated.d VERBATIM)
  set(headers ${out}/generated)
  foreach(file ${files})
    get_filename_component(type ${file} NAME_WE)
    set(header ${out}/firn/${type}.hpp)
    add_custom_command(OUTPUT ${header}
      COMMAND ${LCM_GEN} --cpp --cpp-std=c++11 --cpp-hpath=${out} ${file}
      DEPENDS ${file} VERBATIM)
    list(APPEND headers ${header})
  endforeach()
  add_custom_target(${target}_generate DEPENDS ${headers})
  add_library(${target} INTERFACE)
  add_dependencies(${target} ${target}_generate)
  target_include_directories(${target} SYSTEM INTERFACE ${out})
  target_link_libraries(${target} INTERFACE ${LCM_LIBRARY})
  set(FIRN_LCM_FILES ${files} PARENT_SCOPE)
  set(FIRN_MESSAGE_TABLES ${out}/message_tables.cpp PARENT_SCOPE)
endfunction()
