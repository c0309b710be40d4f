# Headers of packages that are too large to install (scripts/packages.txt, [headers]). ./firn unpacks them below FIRN_HEADERS, a
# folder that every checkout and every build folder finds; an installed package goes before it.
file(STRINGS /etc/os-release codename REGEX "^VERSION_CODENAME=")
string(REGEX REPLACE "^VERSION_CODENAME=\"?([^\"]*).*" "\\1" codename "${codename}")
set(default_headers $ENV{FIRN_HEADERS})
if(NOT default_headers AND NOT "$ENV{XDG_CACHE_HOME}" STREQUAL "")
  set(default_headers $ENV{XDG_CACHE_HOME}/firn/headers/${codename})
elseif(NOT default_headers)
  set(default_headers $ENV{HOME}/.cache/firn/headers/${codename})
endif()
set(FIRN_HEADERS ${default_headers} CACHE PATH "where ./firn unpacks the headers of large packages")

# firn_find_headers(VARIABLE HEADER PACKAGE [folder of the header below usr/include]): the folder to include.
function(firn_find_headers variable header package)
  if(${variable} AND NOT EXISTS ${${variable}}/${header})
    unset(${variable} CACHE)
  endif()
  find_path(${variable} ${header} PATHS ${FIRN_HEADERS}/${package}/usr/include PATH_SUFFIXES ${ARGN})
  if(NOT ${variable})
    message(FATAL_ERROR "${header} is missing: install the package ${package}, or run ./firn, which unpacks its headers into "
      "${FIRN_HEADERS}")
  endif()
endfunction()
