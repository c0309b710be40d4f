# Target firn_opencv: core, imgproc and imgcodecs alone. Debian puts OpenCVConfig.cmake into libopencv-dev, which
# brings every module and Java; three libraries are enough here.
find_path(OPENCV_INCLUDE opencv2/core/version.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(firn_opencv INTERFACE)
target_include_directories(firn_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE})
foreach(module core imgproc imgcodecs)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(firn_opencv INTERFACE ${OPENCV_${module}})
endforeach()
file(STRINGS ${OPENCV_INCLUDE}/opencv2/core/version.hpp lines REGEX "define CV_VERSION_(MAJOR|MINOR|REVISION)")
string(REGEX REPLACE "[^0-9;]" "" OPENCV_VERSION_TEXT "${lines}")
string(REPLACE ";" "." OPENCV_VERSION_TEXT "${OPENCV_VERSION_TEXT}")
