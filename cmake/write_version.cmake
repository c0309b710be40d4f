# cmake -DOUT=firn_version.h -DSOURCE=root -DOPENCV=version -P write_version.cmake: what a build came from.
execute_process(COMMAND git -C ${SOURCE} rev-parse HEAD OUTPUT_VARIABLE commit ERROR_QUIET
  OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()
file(WRITE ${OUT} "#define FIRN_COMMIT \"${commit}\"\n#define FIRN_OPENCV_VERSION \"${OPENCV}\"\n")
