// A print that a page watches is the print that nobody watches, whatever happens to the page.
#include <catch2/catch.hpp>

#include "tests/page/besieged_print.h"
#include "tests/support/temp_folder.h"

using namespace firn;

TEST_CASE(
    "a print whose page is besieged, killed and begun anew writes the bytes of one that nobody watches") {
  const test::TempFolder place;
  const runs::RunFolder alone = test::part_to_besiege(place.path() / "alone"),
                        watched = test::part_to_besiege(place.path() / "watched");
  test::print_alone(alone);
  const test::PageAttack::Size size{200, 2'000, 8};
  const test::Siege siege = test::print_besieged(watched, size);
  CHECK(siege.killed > 2);
  CHECK(siege.frames >= size.frames);
  CHECK(siege.page_serves);
  CHECK(test::differing_files(alone, watched) == std::vector<std::string>());
}
