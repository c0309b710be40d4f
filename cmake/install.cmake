# What `cmake --install BUILD --component NAME --prefix PREFIX` lays below PREFIX, which may be moved afterwards:
#   firn      programs, experiments, labs, documents; words for shells, pages of the manual; a rule of udev, a unit of systemd
#   firn-dev  headers and static libraries of core/, for find_package(Firn)
#   python3-firn  the module firn and what runs controllers in Python
# scripts/make_package.sh makes Debian packages of them.
include(CMakePackageConfigHelpers)
set(firn_home lib/firn)

# Programs find each other in one folder, and PREFIX/share/firn by their own place (runtime/source_folder.h).
get_property(firn_programs GLOBAL PROPERTY firn_programs)
list(REMOVE_ITEM firn_programs firn-demo firn-view)  # parts of firn that are built sooner
install(TARGETS ${firn_programs} RUNTIME DESTINATION ${firn_home}/bin COMPONENT firn)
if(FIRN_SPY)
  install(FILES ${CMAKE_BINARY_DIR}/bin/firn-spy.jar DESTINATION ${firn_home}/bin COMPONENT firn)
endif()
install(DIRECTORY experiments labs DESTINATION share/firn COMPONENT firn
  PATTERN results EXCLUDE PATTERN __pycache__ EXCLUDE)
install(DIRECTORY lcmtypes DESTINATION share/firn COMPONENT firn FILES_MATCHING PATTERN *.lcm)  # for programs of the lab's own
install(DIRECTORY docs DESTINATION share/firn COMPONENT firn FILES_MATCHING PATTERN *.md PATTERN openapi.json PATTERN images EXCLUDE)
install(FILES tests/examples/fake_lab.py tests/examples/fake_instruments.py  # the lab of docs/tutorials/your-lab.md
  DESTINATION share/firn/tests/examples COMPONENT firn)
install(FILES cmake/install/60-firn.rules DESTINATION lib/udev/rules.d COMPONENT firn)
install(FILES cmake/install/firn-view.service DESTINATION lib/systemd/user COMPONENT firn)
install(CODE [[
  set(place "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}")
  file(MAKE_DIRECTORY "${place}/bin")
  file(CREATE_LINK ../lib/firn/bin/firn "${place}/bin/firn" SYMBOLIC)]] COMPONENT firn)
install(CODE "
  foreach(words \"bash;bash-completion/completions/firn\" \"zsh;zsh/vendor-completions/_firn\"
      \"fish;fish/vendor_completions.d/firn.fish\" \"man;man/man1\")
    list(GET words 0 form)
    list(GET words 1 file)
    execute_process(COMMAND \"$<TARGET_FILE:firn>\" completion \${form} -o \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share/\${file}\"
      COMMAND_ERROR_IS_FATAL ANY)
  endforeach()" COMPONENT firn)

# core/, whose folders include nothing but each other.
foreach(library ${firn_core_rooms})
  string(REGEX REPLACE "^firn_" "" short ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${short})
  target_compile_features(${library} INTERFACE cxx_std_20)
endforeach()
install(TARGETS ${firn_core_rooms} EXPORT FirnTargets ARCHIVE DESTINATION lib COMPONENT firn-dev)
install(DIRECTORY core DESTINATION include/firn COMPONENT firn-dev FILES_MATCHING PATTERN *.h)
install(EXPORT FirnTargets NAMESPACE Firn:: DESTINATION lib/cmake/Firn COMPONENT firn-dev)
configure_package_config_file(cmake/install/FirnConfig.cmake.in ${CMAKE_BINARY_DIR}/install/FirnConfig.cmake
  INSTALL_DESTINATION lib/cmake/Firn)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/install/FirnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/install/FirnConfig.cmake ${CMAKE_BINARY_DIR}/install/FirnConfigVersion.cmake
  DESTINATION lib/cmake/Firn COMPONENT firn-dev)

if(FIRN_PYTHON AND NOT FIRN_SANITIZE)
  install(FILES $<TARGET_FILE:firn_python_host> $<TARGET_FILE:firn_core> DESTINATION ${firn_home}/python COMPONENT python3-firn)
  install(DIRECTORY python/lib/firn DESTINATION lib/python3/dist-packages COMPONENT python3-firn
    FILES_MATCHING PATTERN *.py PATTERN *.pyi PATTERN py.typed)
endif()
