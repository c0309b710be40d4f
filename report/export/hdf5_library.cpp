#include "report/export/hdf5_library.h"

#include <dlfcn.h>

#include <stdexcept>
#include <string>

namespace firn::report {
namespace {

// The libraries of the version whose header this file was compiled with: Debian 12 has 1.10, Debian 13
// has 1.14.
#if H5_VERSION_GE(1, 14, 0)
constexpr const char* kLibrary = "libhdf5_serial.so.310";
constexpr const char* kScales = "libhdf5_serial_hl.so.310";
constexpr const char* kPackage = "libhdf5-310";
constexpr const char* kScalesPackage = "libhdf5-hl-310";
#else
constexpr const char* kLibrary = "libhdf5_serial.so.103";
constexpr const char* kScales = "libhdf5_serial_hl.so.100";
constexpr const char* kPackage = "libhdf5-103-1";
constexpr const char* kScalesPackage = "libhdf5-hl-100";
#endif

}  // namespace

void* Hdf5::open(const char* name, const char* package) {
  if (void* library = ::dlopen(name, RTLD_NOW | RTLD_LOCAL)) return library;
  throw std::runtime_error(std::string("HDF5 is not installed (Debian package ") + package +
                           "): " + ::dlerror());
}

void* Hdf5::symbol(void* library, const char* name) {
  if (void* found = ::dlsym(library, name)) return found;
  throw std::runtime_error(std::string(kLibrary) + " and " + kScales + ": lack " + name);
}

Hdf5::Hdf5() : library_(open(kLibrary, kPackage)), scales_(open(kScales, kScalesPackage)) {
  // At the exit of the program the library would close a file that it could not write, and crashes there.
  H5dont_atexit();
  H5open();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its own report goes to stderr
}

hid_t Hdf5::id(const char* variable) const { return *static_cast<hid_t*>(symbol(library_, variable)); }

const Hdf5& Hdf5::library() {
  static const Hdf5 loaded;
  return loaded;
}

}  // namespace firn::report
