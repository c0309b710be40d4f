// The facts of a print, as a report shows them: keys, tags, notes, acknowledged alarms, use.
#include "report/run/meta_table.h"

#include <catch2/catch.hpp>

namespace firn::report {
namespace {

using Catch::Contains;
using NoteOf = runs::NoteEntry::Kind;

ReportRun used_run(double volume_mm3) {
  ReportRun r;
  r.data.result.emplace();
  r.data.result->use = runs::PrintUse{
      10, volume_mm3, "jet", {{"stage", {"simulated", 0.25, 0.0}}, {"jet", {"simulated", 0.0, volume_mm3}}}};
  return r;
}

}  // namespace

TEST_CASE("a report without anything to tell of what was printed has no such part") {
  CHECK(meta_table({ReportRun{}}, {"a"}).empty());
  CHECK(meta_table({}, {}).empty());
}

TEST_CASE("a report says what each run used, with the hours of instruments that worked") {
  const std::string page = meta_table({used_run(1.5), ReportRun{}}, {"a", "b"});
  CHECK_THAT(page, Contains("used"));
  CHECK_THAT(page, Contains("1.5 mm^3 in 10 droplets; stage 15 min"));
  CHECK_THAT(page, !Contains("jet 0"));
}

TEST_CASE("a report lists who acknowledged which alarm, with the run's name where there are several") {
  ReportRun r;
  r.data.notes.entries = {{NoteOf::kAck, "12.3 s, jet: no <droplets>", "Ada", "2026-12-01T10:00:00Z", "lab"},
                          {NoteOf::kAck, "12.3 s, jet: no <droplets>", "Lee", "2026-12-01T10:05:00Z", "lab"},
                          {NoteOf::kNote, "rim falls", "Kim", "2026-12-01T11:00:00Z", "lab"}};
  const std::string one = meta_table({r}, {"a"});
  CHECK_THAT(one, Contains("alarm at 12.3 s, jet: no &lt;droplets&gt;"));
  CHECK_THAT(one, Contains("acknowledged by Ada, 2026-12-01T10:00:00Z"));
  CHECK_THAT(one, !Contains("Lee"));
  CHECK_THAT(one, Contains("rim falls"));
  CHECK_THAT(one, !Contains("<b>a</b>"));
  CHECK_THAT(meta_table({r, r}, {"a", "b"}), Contains("<b>b</b>: alarm at"));
}

}  // namespace firn::report
