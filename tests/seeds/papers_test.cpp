// Every table and figure of the papers that firn reproduce shows, with few repeats; the full counts are the
// command's.
#include <catch2/catch.hpp>
#include <set>

#include "studies/reproduce/reproduce.h"

using namespace firn;

namespace {

std::vector<PartResult> quick(const std::string& paper) {
  ReproduceOptions options;
  options.paper = paper;
  options.quick = true;
  return reproduce(options, reproduce_parts());
}

void check_paper(const std::string& paper, std::size_t least_rows) {
  std::set<std::string> ids, pictures;
  std::size_t with_verdict = 0;
  for (const PartResult& part : quick(paper)) {
    for (const ReproduceRow& row : part.rows) {
      INFO(row.id << ": " << row.what << ": paper " << text_of(row.paper, row.decimals, row.unit) << ", ours "
                  << text_of(row.ours, row.decimals, row.unit) << ", tolerance " << tolerance_of(row));
      CHECK(row.pass.value_or(true));
      CHECK(ids.insert(row.id).second);
      CHECK((row.pass || row.kind != RowKind::kProperty));  // a property has a verdict
      with_verdict += row.pass.has_value();
    }
    for (const ReproducePicture& picture : part.pictures) {
      INFO(picture.name);
      CHECK(pictures.insert(picture.name).second);
      CHECK(picture.svg.starts_with("<svg "));
    }
  }
  CHECK(with_verdict >= least_rows);
}

}  // namespace

TEST_CASE("Every row of firn reproduce thompson with a tolerance passes", "[seeds]") {
  check_paper("thompson", 25);
}
TEST_CASE("Every row of firn reproduce barnett with a tolerance passes", "[seeds]") {
  check_paper("barnett", 10);
}
TEST_CASE("Every row of firn reproduce lu with a tolerance passes", "[seeds]") { check_paper("lu", 25); }
