#include "print/simulated/memory_print.h"

#include <catch2/catch.hpp>

#include "core/grid/npy.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "tests/files/record/scratch.h"

using namespace firn;

namespace {

Experiment small_part(const std::string& scheme, const std::string& plant) {
  Experiment e;
  e.grid.nx = e.grid.ny = 14;
  e.part.shape.kind = "cylinder";
  e.part.shape.diameter_mm = 2.6;
  e.part.shape.height_mm = 0.03;
  e.control.scheme = scheme;
  e.plant.model = plant;
  return e;
}

}  // namespace

TEST_CASE("a print in memory leaves the part that a print with a run folder leaves, to the last bit") {
  for (const char* plant : {"droplets", "lu2015"}) {
    CAPTURE(plant);
    const Experiment e = small_part("mpc", plant);
    const Blobs inputs = make_inputs(full_product(), e, "");
    const MemoryPrintReport m = print_in_memory(full_product(), e, inputs, {true, true});
    const test::Scratch scratch("memory-print");
    const LabRunReport f =
        run_in_lab(full_product(), runs::RunFolder::create(scratch / "runs", e, inputs, {"test"}), {});
    CHECK(m.result.outcome == f.result.outcome);
    CHECK(m.result.layers == f.result.layers);
    CHECK(m.surface.cells == f.truth.cells);
    CHECK(m.node_s == f.node_seconds);
  }
}

TEST_CASE("the series of a print in memory holds every layer and ends at the final surface") {
  const Experiment e = small_part("smf", "droplets");
  const Blobs inputs = make_inputs(full_product(), e, "");
  const MemoryPrintReport m = print_in_memory(full_product(), e, inputs, {true, true});
  REQUIRE(m.result.status == 0);
  REQUIRE(int(m.series.size()) == m.result.layers);
  for (std::size_t n = 0; n < m.series.size(); ++n) CHECK(m.series[n].layer == int(n) + 1);
  for (std::size_t n = 1; n < m.series.size(); ++n)
    CHECK(m.series[n].droplets_total >= m.series[n - 1].droplets_total);
  CHECK(m.series.back().droplets_total == m.droplets);
  CHECK(m.series.back().error.rms_mm == m.error.rms_mm);
  const ErrorStats s =
      error_stats(m.surface, height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target"),
                  mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask"));
  CHECK(s.rms_mm == m.error.rms_mm);
}

TEST_CASE("a print in memory that stops for the operator says so and does not count as finished") {
  Experiment e = small_part("mpc", "droplets");
  e.control.max_layers = 2;
  const MemoryPrintReport m = print_in_memory(full_product(), e, make_inputs(full_product(), e, ""));
  CHECK(m.result.status != 0);
  CHECK(m.result.outcome == "waits for operator");
  CHECK(m.series.empty());
  CHECK(m.surface.size() == 0);
}

TEST_CASE("Ink beside the part is counted beyond the grid too, and its volume is that of the field") {
  Experiment e = small_part("smf", "droplets");
  e.part.shape.diameter_mm = 3.5;  // 14 cells of 0.263 mm: the part touches the grid's border
  const Blobs inputs = make_inputs(full_product(), e, "");
  const MemoryPrintReport m = print_in_memory(full_product(), e, inputs, {.surface = true, .outline = true});
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  double part_mm3 = 0.0, inside_mm3 = 0.0;
  const double cell_mm2 = e.grid.pitch_x_mm * e.grid.pitch_y_mm;
  for (std::size_t c = 0; c < target.size(); ++c)
    if (mask.cells[c]) {
      part_mm3 += target.cells[c] * cell_mm2;
      inside_mm3 += m.surface.cells[c] * cell_mm2;
    }
  CHECK(m.outline.overspill == Approx((m.volume_mm3 - inside_mm3) / part_mm3).epsilon(1e-9));
  CHECK(m.outline.overspill > outline_stats(m.surface, target, mask).overspill);
  CHECK_FALSE(m.outline.cut);
  CHECK(m.outline.misplaced == m.outline.overspill + m.outline.missing);
  CHECK(m.passes >= m.result.layers);
}
