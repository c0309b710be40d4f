// Instruments that fall silent between commands: docs/safety.md says how soon the print is stopped.
#include <catch2/catch.hpp>

#include <string>

#include "files/exit_codes.h"
#include "firn/safe_stop_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/read/run_reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn {
namespace {

constexpr double kPaused_s = 6.0, kSilent_s = 60.0;  // node time

/// Holds a print that waits for the operator while one of its instruments accepts bytes and answers nothing.
struct SilencedPrint {
  explicit SilencedPrint(const std::string& port)
      : run(runs::RunFolder::create(folder.path(), e, make_inputs(full_product(), e, ""), {"test"})) {
    LabRunOptions o;
    o.later = {{kPaused_s, {new_order_id(), OperatorVerb::kPause, {}, {}}},
               {kSilent_s + 3600.0, {new_order_id(), OperatorVerb::kContinue, {}, {}}}};
    o.faults = {{kSilent_s, {port, plant::FaultKind::kHang, 1, 0}}};
    report = run_in_lab(full_product(), run, o);
  }
  /// Returns the time from the silence to the first SAFE_STOP [s]; below 0: there was none.
  double noticed_s() const {
    double first_s = -1.0;
    runs::RunReader(run.path()).each<safe_stop_t>(channels::kSafeStop.name, [&](const safe_stop_t& m) {
      const double after_s = double(m.header.utime_us) * 1e-6 - kSilent_s;
      if (first_s < 0.0 && after_s >= 0.0) first_s = after_s;
    });
    return first_s;
  }

  Experiment e = test::tiny_print("silence");
  test::TempFolder folder;
  runs::RunFolder run;
  LabRunReport report;
};

TEST_CASE(
    "a lamp and a profiler that fall silent between commands stop the print as soon as safety.md says") {
  for (const auto& [port, within_s] : {std::pair("lamp", 11.0), {"laser_profiler", 7.0}}) {
    CAPTURE(port);
    const SilencedPrint print(port);
    CHECK(print.report.result.status == kSafetyStop);
    CHECK_THAT(print.report.result.reason, Catch::Contains(port) && Catch::Contains("no answer for "));
    CHECK(print.noticed_s() >= 0.0);
    CHECK(print.noticed_s() <= within_s);
  }
}

}  // namespace
}  // namespace firn
