# Target firn_opencv: core and imgproc alone. Debian puts OpenCVConfig.cmake into libopencv-dev, which brings every module and
# Java. Target firn_opencv_codecs, where it is installed: pictures in tests and in the plug-in of firn droplets; the 120
# libraries behind imgcodecs take 65 ms to load, so no program has it.
find_path(OPENCV_INCLUDE opencv2/core/version.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(firn_opencv INTERFACE)
target_include_directories(firn_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE})
foreach(module core imgproc)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(firn_opencv INTERFACE ${OPENCV_${module}})
endforeach()
find_library(OPENCV_imgcodecs opencv_imgcodecs)
if(BUILD_TESTING AND NOT OPENCV_imgcodecs)
  message(FATAL_ERROR "the tests need libopencv-imgcodecs-dev")
endif()
set(FIRN_HAS_CODECS OFF)
if(OPENCV_imgcodecs)
  set(FIRN_HAS_CODECS ON)
  add_library(firn_opencv_codecs INTERFACE)
  target_link_libraries(firn_opencv_codecs INTERFACE firn_opencv ${OPENCV_imgcodecs})
  find_library(JPEG_LIBRARY jpeg REQUIRED)  # says what of a file is damaged
endif()
file(STRINGS ${OPENCV_INCLUDE}/opencv2/core/version.hpp lines REGEX "define CV_VERSION_(MAJOR|MINOR|REVISION)")
string(REGEX REPLACE "[^0-9;]" "" OPENCV_VERSION_TEXT "${lines}")
string(REPLACE ";" "." OPENCV_VERSION_TEXT "${OPENCV_VERSION_TEXT}")
