// Any bytes as a 3MF file, read as the user does by lib3mf in its child process, and any bytes as that
// child's message. The first byte chooses: one in 64 is a file, for a process takes long.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "files/mesh/mesh_file.h"
#include "files/mesh/mesh_message.h"
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
  try {
    if (data[0] % 64 == 0) {
      check_mesh(read_mesh(as_bytes(data + 1, size - 1), "fuzz.3mf"));
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
