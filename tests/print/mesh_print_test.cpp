// A mesh as the object of a two-ink print, from its file to the printed block (experiments/gear.toml).
#include <catch2/catch.hpp>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "cli/replay_command.h"
#include "config/include.h"
#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "files/mesh/mesh_file.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "print/simulated/memory_print.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "report/run/voxels.h"
#include "tests/files/record/scratch.h"

using namespace firn;
namespace fs = std::filesystem;

namespace {

const fs::path kMeshFolder = fs::path(FIRN_SOURCE_DIR) / "experiments";

std::string file_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Of the slicer's layers, which know that hub and wheel share a millimetre, scaled as the experiment scales.
double volume_mm3(const Experiment& e) {
  const MeshFile mesh(kMeshFolder / e.geometry.mesh);
  slice::SliceOptions thin;
  thin.layer_height_mm = 0.1;
  double file_mm3 = 0.0;
  for (const geometry::Region& layer : slice::slice(mesh.facets(), {}, thin, serially).layers)
    file_mm3 += geometry::area_mm2(layer) * thin.layer_height_mm;
  return file_mm3 * e.geometry.mesh_scale_xy * e.geometry.mesh_scale_xy * e.geometry.mesh_scale_z;
}

}  // namespace

TEST_CASE("The shipped gear is what scripts/make_mesh.py writes") {
  const test::Scratch scratch("gear");
  const fs::path written = scratch / "gear.stl";
  const std::string command =
      "python3 '" + std::string(FIRN_SOURCE_DIR) + "/scripts/make_mesh.py' '" + written.string() + "' 8";
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(file_text(written) == file_text(kMeshFolder / "gear.stl"));
}

TEST_CASE(
    "A two-ink print of a mesh finishes, replays identical and passes the audit, on the paper's plant and on "
    "Firn's own") {
  const test::Scratch scratch("mesh-print");
  for (const char* plant : {"lu2015", "droplets"}) {
    CAPTURE(plant);
    const Experiment e = load_experiment(kMeshFolder / "gear.toml", {"plant.model=" + std::string(plant)});
    const runs::RunFolder run =
        runs::RunFolder::create(scratch / "runs", e, make_inputs(full_product(), e, kMeshFolder), {"test"});
    const LabRunReport report = run_in_lab(full_product(), run, {});
    INFO(report.result.reason);
    REQUIRE(report.result.status == 0);
    ReplayCommandOptions r;
    r.run = run.path().string();
    const replay::RunVerdict verdict = replay_verdict(full_product(), r);
    INFO(replay::to_text(verdict));
    CHECK(verdict.identical());
    const replay::AuditVerdict audit = replay::audit_run(run.path());
    CHECK(audit.violations_total == 0);
  }
}

TEST_CASE("The printed object has the mesh's volume and shape and is one piece that washing sets free") {
  const Experiment e = load_experiment(kMeshFolder / "gear.toml");
  const Blobs inputs = make_inputs(full_product(), e, kMeshFolder);
  const Geometry geometry = geometry_from_bytes(blob(inputs, "geometry").bytes, e.grid, "geometry");
  double wanted_mm3 = 0.0;
  for (std::size_t c = 0; c < e.grid.size(); ++c)
    for (const Span& s : geometry.spans(c))
      wanted_mm3 += (s.to_mm - s.from_mm) * e.grid.pitch_x_mm * e.grid.pitch_y_mm;
  CHECK(wanted_mm3 == Approx(volume_mm3(e)).epsilon(0.02));  // cells at the rim are in or out

  MemoryPrintOptions options;
  options.materials = true;
  const MemoryPrintReport report = print_in_memory(full_product(), e, inputs, options);
  REQUIRE(report.result.status == 0);
  const double slice_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm;
  const int nz = report::slices_for(report.materials, geometry, slice_mm);
  const report::VoxelBlock wanted = report::voxels_of(geometry, slice_mm, nz),
                           printed = report::voxels_of(report.materials, slice_mm, nz);
  const report::WrongVoxels wrong = report::count_wrong(wanted, printed);
  CHECK(double(wrong.wrong()) <= 0.01 * double(wrong.object));
  const report::Washed washed = report::wash(printed);
  CHECK(washed.largest_piece == washed.object);
  CHECK(washed.support_shut_in == 0);
}
