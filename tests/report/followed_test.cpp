// The followed path on a report's page.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "report/run/report_followed.h"
#include "tests/report/markup.h"

using namespace firn;
using namespace firn::report;

namespace {

/// A corner that is cut by some micrometres.
report::FollowedLayer cut_corner(int layer, double off_um) {
  report::FollowedLayer l;
  l.layer = layer;
  for (int k = 0; k <= 20; ++k) {
    const double s = 0.5 * k;
    l.planned.push_back(k < 10 ? Point2{s, 0.0} : Point2{5.0, s - 5.0});
    l.beside.push_back({0.0, k == 10 ? off_um * 1e-3 : 0.0});
    l.time_s.push_back(0.01 * k);
    l.contour_um.push_back(k == 10 ? off_um : 0.0);
  }
  l.contour_max_um = off_um;
  l.contour_rms_um = off_um / 4;
  l.lag_ms = 0.37;
  l.switch_um = NAN;
  return l;
}

}  // namespace

TEST_CASE("the followed path is drawn over the planned one, its deviations enlarged by a round number",
          "[followed]") {
  const std::vector<report::FollowedLayer> layers{cut_corner(1, 12.5), cut_corner(2, 2.5)};
  const std::string page = report::followed_sections({{"smf", &layers, 0}});
  CHECK_NOTHROW(firn::test::parse_markup("<div>" + page + "</div>"));
  CHECK_THAT(page, Catch::Contains("smf, layer 2: deviation across the path, 50 times"));
  for (const char* words : {"Contour error along the path", "<td>12.50</td>", "<td>0.37</td>", "<td>–</td>"})
    CHECK_THAT(page, Catch::Contains(words));
}

TEST_CASE("names of runs are escaped, and runs without a recorded path have no section", "[followed]") {
  const std::vector<report::FollowedLayer> none, one{cut_corner(1, 1.0)};
  CHECK(report::followed_sections({{"a", &none, 0}}).empty());
  const std::string page = report::followed_sections({{"a", &none, 0}, {"<b>", &one, 1}});
  CHECK_THAT(page, Catch::Contains("&lt;b&gt;") && !Catch::Contains("<b>"));
}

TEST_CASE("a path that was followed exactly is drawn without an endless enlargement", "[followed]") {
  const std::vector<report::FollowedLayer> exact{cut_corner(1, 0.0)};
  const std::string page = report::followed_sections({{"smf", &exact, 0}});
  CHECK_NOTHROW(firn::test::parse_markup("<div>" + page + "</div>"));
  CHECK(page.find("nan") == std::string::npos);
  CHECK(page.find("inf") == std::string::npos);
}
