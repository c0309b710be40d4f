// Any bytes as the saved state of a world: it is refused in words, or a world goes on from it and saves it
// again. The first byte chooses the lab, and whether the checksum is made true.
#include <sys/mman.h>
#include <unistd.h>

#include <stdexcept>

#include "files/record/checksum.h"
#include "plant/world/world.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/small_worlds.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  static const plant::WorldConfig worlds[] = {small_inkjet_world(), small_ice_world()};
  const int fd = ::memfd_create("state", 0);
  const auto body = as_bytes(data + 1, size - 1);
  require(::write(fd, body.data(), body.size()) == ssize_t(body.size()), "the state is written");
  if (data[0] & 2) {
    const std::uint64_t sum = record::checksum64(body);
    require(::write(fd, &sum, sizeof sum) == sizeof sum, "the checksum is written");
  }
  try {
    plant::World::restore("/proc/self/fd/" + std::to_string(fd), worlds[data[0] & 1], nullptr).exposures();
  } catch (const std::runtime_error&) {
  }
  ::close(fd);
  return 0;
}
