#include "page/api_v1.h"

#include <catch2/catch.hpp>

using namespace firn;
using page::metrics_text;

TEST_CASE("a print that goes on has its layer and error in the metrics, with its labels escaped", "[page]") {
  const std::string text = metrics_text(
      R"({"runs": [{"label": "a \"b\\c\nd", "scheme": "smf", "state": "paused", "live": true, "outcome": "printing",
                    "layers": 7, "rms_um": 1.25},
                   {"label": "e", "scheme": "mpc", "live": true, "outcome": "printing", "layers": 0, "rms_um": null},
                   {"label": "f", "live": false, "outcome": "finished", "layers": 9, "rms_um": 2.0}]})");
  CHECK_THAT(text,
             Catch::Contains("\nfirn_runs{outcome=\"finished\"} 1\nfirn_runs{outcome=\"printing\"} 2\n"));
  const std::string of = R"({run="a \"b\\c\nd",scheme="smf",state="paused"})";
  CHECK_THAT(text, Catch::Contains("\nfirn_print_layers" + of + " 7\n"));
  CHECK_THAT(text, Catch::Contains("\nfirn_print_rms_um" + of + " 1.25\n"));
  CHECK_THAT(text, Catch::Contains("\nfirn_print_layers{run=\"e\",scheme=\"mpc\",state=\"\"} 0\n"));
  CHECK_THAT(text, !Catch::Contains("rms_um{run=\"e\"") && !Catch::Contains("run=\"f\""));
}

TEST_CASE("a request of version 1 is the page's own without its version, others stay, unknown ones are none",
          "[page]") {
  const auto target = [](const char* method, const char* asked) {
    return page::without_version(method, asked).value_or("none");
  };
  CHECK(target("GET", "/api/v1/runs") == "/api/runs");
  CHECK(target("GET", "/api/v1/runs/1@2/audit") == "/api/runs/1@2/audit");
  CHECK(target("POST", "/api/v1/runs/1@2/resume") == "/api/runs/1@2/resume");
  CHECK(target("GET", "/api/runs/1@2/notes") == "/api/runs/1@2/notes");
  CHECK(target("GET", "/api/v1x") == "/api/v1x");
  for (const char* other :
       {"/api/v1", "/api/v1/", "/api/v1/runs/", "/api/v1/runs/1/2/3", "/api/v1/runs/1/resume"})
    CHECK(target("GET", other) == "none");
}
