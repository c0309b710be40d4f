# Target firn_opencv: core and imgproc alone. Debian puts OpenCVConfig.cmake into libopencv-dev, which brings every module and
# Java. Target firn_opencv_codecs: pictures in tests; the 120 libraries behind imgcodecs take 65 ms to load, so no program
# has it.
find_path(OPENCV_INCLUDE opencv2/core/version.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(firn_opencv INTERFACE)
target_include_directories(firn_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE})
foreach(module core imgproc)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(firn_opencv INTERFACE ${OPENCV_${module}})
endforeach()
if(BUILD_TESTING)
  find_library(OPENCV_imgcodecs opencv_imgcodecs REQUIRED)
  add_library(firn_opencv_codecs INTERFACE)
  target_link_libraries(firn_opencv_codecs INTERFACE firn_opencv ${OPENCV_imgcodecs})
endif()
file(STRINGS ${OPENCV_INCLUDE}/opencv2/core/version.hpp lines REGEX "define CV_VERSION_(MAJOR|MINOR|REVISION)")
string(REGEX REPLACE "[^0-9;]" "" OPENCV_VERSION_TEXT "${lines}")
string(REPLACE ";" "." OPENCV_VERSION_TEXT "${OPENCV_VERSION_TEXT}")
