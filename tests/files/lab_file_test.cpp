// A lab file with keys changed keeps all its other lines.
#include <catch2/catch.hpp>

#include "files/lab_file.h"

namespace firn {

TEST_CASE(
    "Keys are replaced where they stand, added where they are missing, and nothing else of the file "
    "changes") {
  const std::string lab =
      "# a lab\n[laser_point]\nlatency_s = 0.1   # was guessed\nrate_hz = 100.0\n\n# the "
      "valve\n[valve_a]\ntable_hz = [1, 2, # low\n  3]\npulse_us = 1250.0\n";
  const std::string out = with_keys(lab, {{"laser_point", "latency_s", "-0.03", "firn calibrate"},
                                          {"laser_point", "offset_x_mm", "1.5", ""},
                                          {"valve_a", "table_hz", "[10, 20]", ""},
                                          {"valve_b", "latency_s", "0.2", ""}});
  CHECK(out ==
        "# a lab\n[laser_point]\nlatency_s = -0.03  # firn calibrate\nrate_hz = 100.0\noffset_x_mm = "
        "1.5\n\n# the valve\n[valve_a]\ntable_hz = [10, 20]\n"
        "pulse_us = 1250.0\n\n[valve_b]\nlatency_s = 0.2\n");
  CHECK(with_keys(out, {}) == out);
  CHECK(changed_lines(lab, with_keys(lab, {{"laser_point", "rate_hz", "50.0", ""}})) ==
        "- rate_hz = 100.0\n+ rate_hz = 50.0\n");
  CHECK(changed_lines(lab, lab).empty());
}

}  // namespace firn
