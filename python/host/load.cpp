#include "python/host/load.h"

#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace firn::python {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "firn_python_host.so";

fs::path own_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

// The programs of a build lie in build/bin and build/tests; installed ones in bin.
std::array<fs::path, 2> places() {
  const fs::path home = own_folder().parent_path();
  return {home / "python" / kFile, home / "lib" / "firn" / kFile};
}

Host* load() {
  std::string searched;
  for (const fs::path& place : places()) {
    searched += (searched.empty() ? "" : ", ") + place.string();
    std::error_code error;
    if (!fs::exists(place, error)) continue;
    // Global: the modules of Python that are libraries themselves look for the interpreter's symbols.
    void* library = dlopen(place.c_str(), RTLD_NOW | RTLD_GLOBAL);
    if (!library)
      throw std::runtime_error("Firn's plug-in for Python does not load: " + std::string(dlerror()));
    const auto make = reinterpret_cast<HostFunction>(dlsym(library, kHostFunction));
    Host* host = make ? make(FIRN_HOST_INTERFACE) : nullptr;
    if (!host)
      throw std::runtime_error(place.string() + " was built from other sources: ./firn python builds it");
    return host;
  }
  throw std::runtime_error("Firn's plug-in for Python is not here: ./firn python builds it (searched " +
                           searched + ")");
}

}  // namespace

Host& host() {
  static Host* const loaded = load();
  return *loaded;
}

}  // namespace firn::python
