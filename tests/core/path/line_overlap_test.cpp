#include "core/path/line_overlap.h"

#include <catch2/catch.hpp>

#include "core/grid/random.h"

using namespace firn;

namespace {

PrintJob job_of(std::vector<PrintSegment> segments) { return {{0, 0}, {0, 0}, std::move(segments)}; }

}  // namespace

TEST_CASE("A line that is given twice, forwards, backwards or in part, lies on itself") {
  const PrintSegment line{{1, 1}, {6, 1}, 3};
  for (const auto& [again, length_mm] : {std::pair{PrintSegment{{1, 1}, {6, 1}, 2}, 5.0},
                                         {PrintSegment{{6, 1}, {1, 1}, 3}, 5.0},
                                         {PrintSegment{{4, 1}, {9, 1}, 3}, 2.0},
                                         {PrintSegment{{2, 1.005}, {3, 1.005}, 3}, 1.0}}) {
    const auto found = line_overlaps(job_of({line, {{1, 3}, {6, 3}, 3}, again}));
    REQUIRE(found.size() == 1);
    CHECK(found[0].first == 0);
    CHECK(found[0].second == 2);
    CHECK(found[0].length_mm == Approx(length_mm));
  }
}

TEST_CASE("Lines that cross, touch, go on, turn or run side by side lie on no other") {
  CHECK(line_overlaps(job_of({{{0, 0}, {5, 0}, 3}, {{5, 0}, {9, 0}, 3}})).empty());
  CHECK(line_overlaps(job_of({{{0, 0}, {5, 0}, 3}, {{5, 0}, {5, 5}, 3}, {{2, -2}, {2, 2}, 3}})).empty());
  CHECK(line_overlaps(job_of({{{0, 0}, {5, 0}, 3}, {{0, 0.02}, {5, 0.02}, 3}})).empty());
  CHECK(line_overlaps(job_of({{{0, 0}, {5, 0}, 3}, {{5, 0}, {0, 0.5}, 3}})).empty());  // a hairpin
}

TEST_CASE("The pairs of a job are those of all segments compared one by one, along x or along y") {
  for (const bool turned : {false, true}) {
    RandomStream random(4, Purpose::kTest, turned);
    std::vector<PrintSegment> segments;
    for (int n = 0; n < 200; ++n) {
      const double row = 0.5 * int(random.uniform(0, 12)), from = random.uniform(0, 20),
                   to = from + random.uniform(1, 3);
      const Point2 a{from, row}, b{to, row};
      segments.push_back(turned ? PrintSegment{{a.y_mm, a.x_mm}, {b.y_mm, b.x_mm}, 3}
                                : PrintSegment{a, b, 3});
    }
    std::size_t pairs = 0;
    for (std::size_t a = 0; a < segments.size(); ++a)
      for (std::size_t b = a + 1; b < segments.size(); ++b)
        pairs += line_overlaps(job_of({segments[a], segments[b]})).size();
    CHECK(pairs > 50);
    CHECK(line_overlaps(job_of(segments)).size() == pairs);
  }
}

TEST_CASE("Remarks on lines that are given twice name the segments of the first pairs and count the others") {
  std::vector<PrintSegment> segments(4, {{1, 1}, {6, 1}, 3});
  const auto remarks = overlap_remarks(job_of(segments));
  REQUIRE(remarks.size() == 4);
  CHECK_THAT(remarks[0], Catch::StartsWith("segments[1] lies on segments[0] along 5 mm: "));
  CHECK(remarks[3] == "3 more pairs of segments lie on each other");
  CHECK(overlap_remarks(job_of({segments[0]})).empty());
}
