// Prints whose profiler loses rows: a driver that asks too seldom, as on a busy machine.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "config/include.h"
#include "firn/fault_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"

using namespace firn;

namespace {

struct PrintedWithGaps {
  MemoryPrintReport report;
  std::vector<layer_metrics_t> layers;
  int measured_again = 0, decided_without = 0;
};

// 0.263256 mm a row at 15 mm/s: a row every 17.6 ms.
PrintedWithGaps printed_with_gaps(std::vector<std::string> overrides) {
  const std::filesystem::path folder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";
  for (const char* small : {"part.height_mm=0.06", "grid.nx=24", "grid.ny=24", "part.diameter_mm=5"})
    overrides.insert(overrides.begin(), small);
  const Experiment e = load_experiment(folder / "cylinder.toml", overrides);
  PrintedWithGaps p;
  MemoryPrintOptions o;
  o.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    if (channel == "LAYER_METRICS") p.layers.emplace_back().decode(bytes.data(), 0, int(bytes.size()));
    fault_t f{};
    if (channel != "FAULT_SCHEDULER" || f.decode(bytes.data(), 0, int(bytes.size())) < 0 || f.code != 13)
      return;
    p.measured_again += f.text.find("measuring again at") != f.text.npos;
    p.decided_without += f.text.find("without them") != f.text.npos;
  };
  p.report = print_in_memory(full_product(), e, make_inputs(full_product(), e, folder), o);
  return p;
}

}  // namespace

TEST_CASE(
    "Lost rows are counted, the scan is made again slower, and the part is as good as without the loss") {
  const PrintedWithGaps whole = printed_with_gaps({}),
                        lossy = printed_with_gaps({"laser_profiler.poll_s=0.025"});
  REQUIRE(whole.report.result.status == 0);
  REQUIRE(lossy.report.result.status == 0);
  for (const layer_metrics_t& m : whole.layers) CHECK(m.rows_lost == 0);
  CHECK(whole.measured_again == 0);
  CHECK(lossy.measured_again >= 1);
  CHECK(lossy.layers.front().rows_lost > 4);
  for (std::size_t n = 1; n < lossy.layers.size(); ++n) CHECK(lossy.layers[n].rows_lost == 0);
  CHECK(lossy.report.error.rms_mm < 1.2 * whole.report.error.rms_mm + 2e-4);
  const layer_metrics_t& end = whole.layers.back();  // inside and rim together are the whole part
  CHECK(end.rms_mm >= std::min(end.rms_inside_mm, end.rms_rim_mm));
  CHECK(end.rms_mm <= std::max(end.rms_inside_mm, end.rms_rim_mm));
  CHECK(end.rms_inside_mm != end.rms_rim_mm);
}

TEST_CASE(
    "Where rows are lost for good, the print goes on by the model's heights there and counts the cells") {
  for (const char* scheme : {"mpc", "smf"}) {
    CAPTURE(scheme);
    const PrintedWithGaps p = printed_with_gaps(
        {"laser_profiler.poll_s=0.025", "process.max_rescans=0", "process.min_measured_fraction=0.4",
         "part.shape=wedge", "part.width_mm=4.5", "part.depth_mm=4.5", "part.low_height_mm=0.01",
         std::string("control.scheme=") + scheme});
    CHECK(p.report.result.status == 0);
    CHECK(p.decided_without > 3);
    CHECK(p.layers.back().rows_lost > 0);
    CHECK(p.layers.back().cells_guessed > 0);
  }
}
