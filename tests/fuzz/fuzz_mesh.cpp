// Any bytes as a mesh: the first byte chooses STL, PLY or OBJ, and which count of facets holds.
#include "files/mesh/mesh_file.h"
#include "files/usage_error.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  static const std::string kNames[] = {"fuzz.stl", "fuzz.ply", "fuzz.obj"};
  const std::string& name = kNames[data[0] % 3];
  try {
    const MeshData mesh = read_mesh(as_bytes(data + 1, size - 1), name, FacetCount(data[0] / 3 % 3));
    const slice::FacetView view = mesh.facets();
    require(view.size() > 0, "a mesh has facets");
    for (const auto& t : view.triangles)
      for (std::uint32_t v : t) require(v < view.vertices.size(), "corners have vertices");
    float sum = 0.0f;
    for (std::size_t n = 0; n < view.size(); ++n) sum += view.facet(n)[2][2];  // every corner can be read
    require(view.size() <= size, "no more facets than bytes");
    static_cast<void>(sum);
  } catch (const UsageError& e) {
    require(std::string(e.what()).starts_with(name), "an error names the file");
  }
  return 0;
}
