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
# The communicator of SUNDIALS 7 is MPI's, if it was compiled with MPI. Nothing here starts MPI.
file(STRINGS ${SUNDIALS_INCLUDE}/sundials/sundials_config.h with_mpi REGEX "^#define SUNDIALS_MPI_ENABLED 1")
if(with_mpi AND SUNDIALS_CORE)
  find_library(MPI_LIBRARY NAMES mpi libmpi.so.40 REQUIRED)
  find_path(MPI_INCLUDE mpi.h REQUIRED PATHS /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/openmpi/include
    ${FIRN_HEADERS}/libopenmpi-dev/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/openmpi/include)
  list(APPEND SUNDIALS_LIBRARIES ${MPI_LIBRARY})
  list(APPEND SUNDIALS_INCLUDE ${MPI_INCLUDE})
endif()
