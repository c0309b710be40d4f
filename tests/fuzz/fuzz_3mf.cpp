// Any bytes as a 3MF file, whose structure is checked here or which lib3mf reads in its child process as for
// the user, and any bytes as that child's message. The first byte chooses: a child, which takes long, seldom.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "files/mesh/mesh_file.h"
#include "files/mesh/mesh_message.h"
#include "files/mesh/package_3mf.h"
#include "files/usage_error.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

void check_mesh(const MeshData& mesh) {
  for (const auto& t : mesh.triangles)
    require(std::max({t[0], t[1], t[2]}) < mesh.vertices.size(), "corners have vertices");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::string name = "fuzz.3mf";
  try {
    if (data[0] % 64 == 0) {
      check_mesh(read_mesh(as_bytes(data + 1, size - 1), name));
      return 0;
    }
    if (data[0] % 2) {
      mesh::check_3mf_package(as_bytes(data + 1, size - 1), name);
      return 0;
    }
  } catch (const UsageError& e) {
    require(std::string_view(e.what()).starts_with("fuzz.3mf: "), "an error names the file");
    return 0;
  }
  const int fd = ::memfd_create("mesh", 0);
  require(::write(fd, data + 1, size - 1) == ssize_t(size - 1) && ::lseek(fd, 0, SEEK_SET) == 0,
          "the message is written");
  try {
    check_mesh(mesh::receive_mesh(fd, 1 << 20));
  } catch (const std::runtime_error&) {
  }
  ::close(fd);
  return 0;
}
