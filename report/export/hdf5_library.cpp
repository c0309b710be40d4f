#include "report/export/hdf5_library.h"

#include <dlfcn.h>

#include <stdexcept>
#include <string>

namespace firn::report {
namespace {

constexpr const char* kLibrary = "libhdf5_serial.so.103";

}  // namespace

void* Hdf5::open() {
  if (void* library = ::dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL)) return library;
  throw std::runtime_error(std::string("HDF5 is not installed (Debian package libhdf5-103-1): ") +
                           ::dlerror());
}

void* Hdf5::symbol(void* library, const char* name) {
  if (void* found = ::dlsym(library, name)) return found;
  throw std::runtime_error(std::string(kLibrary) + ": lacks " + name);
}

Hdf5::Hdf5() {
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
