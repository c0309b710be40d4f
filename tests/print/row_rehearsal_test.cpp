// The speed of scans that a machine keeps up with.
#include <catch2/catch.hpp>
#include <cmath>

#include "config/labs.h"
#include "files/usage_error.h"
#include "print/live/row_rehearsal.h"

using namespace firn;
using Catch::Matchers::Contains;

TEST_CASE(
    "A scan whose rows come faster than the machine reads them is slowed, and one far too fast refused") {
  Experiment e;  // 0.263256 mm a row at 15 mm/s: 17.55 ms
  CHECK(fit_scan_speed(e, 0.010).empty());
  CHECK(e.process.scan_speed_mm_s == 15.0);
  const std::string said = fit_scan_speed(e, 0.020);  // a row every 30 ms
  CHECK(e.process.scan_speed_mm_s == Approx(8.77));
  CHECK_THAT(said, Contains("process.scan_speed_mm_s = 8.77 instead of 15") && Contains("17.55 ms") &&
                       Contains("20.00 ms"));
  CHECK(fit_scan_speed(e, 0.020).empty());
  Experiment fast;
  fast.process.scan_speed_mm_s = 150.0;
  CHECK_THROWS_AS(fit_scan_speed(fast, 0.010), UsageError);
  CHECK_THROWS_WITH(fit_scan_speed(fast, 0.010),
                    Contains("process.scan_speed_mm_s = 150") && Contains("17.55"));
  CHECK(fast.process.scan_speed_mm_s == 150.0);
  Experiment scaled;
  scaled.run.time_scale = 3.0;
  CHECK_THAT(fit_scan_speed(scaled, 0.010), Contains("= 5.85 instead of 15"));
  Experiment ice;
  ice.lab.kind = "ice";
  CHECK(fit_scan_speed(ice, 10.0).empty());
}

TEST_CASE("The rehearsal measures a time for any period, also one of seconds, within its half second") {
  for (const double period_s : {1e-5, 0.002, 0.02, 5.0}) {
    const double slowest = slowest_row_s(period_s);
    CHECK(std::isfinite(slowest));
    CHECK(slowest > 0.0);
  }
}
