# SUNDIALS_LIBRARIES and SUNDIALS_INCLUDE: version 6 of Debian 12, or 7 of Debian 13, which has a core of its own. The libraries need
# no libsundials-dev, whose headers may be unpacked without what it depends on.
find_library(SUNDIALS_CVODE NAMES sundials_cvode libsundials_cvode.so.6 libsundials_cvode.so.7 REQUIRED)
find_library(SUNDIALS_NVECSERIAL NAMES sundials_nvecserial libsundials_nvecserial.so.6 libsundials_nvecserial.so.7 REQUIRED)
find_library(SUNDIALS_CORE NAMES sundials_core libsundials_core.so.7)
set(SUNDIALS_LIBRARIES ${SUNDIALS_CVODE} ${SUNDIALS_NVECSERIAL})
if(SUNDIALS_CORE)
  list(APPEND SUNDIALS_LIBRARIES ${SUNDIALS_CORE})
endif()
firn_find_headers(SUNDIALS_INCLUDE cvode/cvode.h libsundials-dev)
