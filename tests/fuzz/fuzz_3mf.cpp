// Any bytes as a 3MF file: its archive, its XML, its slicers' metadata.
#include <algorithm>

#include "files/mesh/mesh_file.h"
#include "files/usage_error.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const MeshData mesh = read_mesh(as_bytes(data, size), "fuzz.3mf");
    for (const auto& t : mesh.triangles)
      require(std::max({t[0], t[1], t[2]}) < mesh.vertices.size(), "corners have vertices");
  } catch (const UsageError& e) {
    require(std::string_view(e.what()).starts_with("fuzz.3mf"), "an error names the file");
  }
  return 0;
}
