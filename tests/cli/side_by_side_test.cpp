#include "cli/side_by_side.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <stdexcept>
#include <thread>

using namespace firn;

namespace {

LivePrint ends_with(const std::string& scheme, int layers, double rms_um) {
  return {scheme, [=] {
            PrintSummary s;
            s.scheme = scheme;
            s.folder = "runs/" + scheme;
            s.result = {"finished", 0, layers, "last layer"};
            s.result.error = runs::MapError{.rms_um = rms_um};
            return s;
          }};
}

LivePrint that_waits(const std::string& scheme) {
  LivePrint print = ends_with(scheme, 1, 1.0);
  return {scheme, [print] {
            std::this_thread::sleep_for(std::chrono::milliseconds(400));
            return print.carry_out();
          }};
}

}  // namespace

TEST_CASE("Prints side by side give their summaries back in the order of the prints") {
  const auto all = print_side_by_side({that_waits("slow"), ends_with("fast", 12, 0.125)});
  REQUIRE(all.size() == 2);
  CHECK(all[0].scheme == "slow");
  CHECK(all[1].scheme == "fast");
  CHECK(all[1].folder == "runs/fast");
  CHECK(all[1].result.outcome == "finished");
  CHECK(all[1].result.layers == 12);
  CHECK(all[1].result.reason == "last layer");
  REQUIRE(all[1].result.error);
  CHECK(all[1].result.error->rms_um == 0.125);
}

TEST_CASE("A print that throws beside others is named, after the others have ended") {
  const LivePrint broken{"smf", []() -> PrintSummary { throw std::runtime_error("no room on the disk"); }};
  CHECK_THROWS_WITH(print_side_by_side({broken, that_waits("mpc")}),
                    Catch::Equals("smf ended without a result"));
}

TEST_CASE("Changes that a print makes to this process's memory stay in its own process") {
  int told = 0;
  LivePrint print = ends_with("mpc", 1, 1.0);
  print.carry_out = [&told, inner = print.carry_out] {
    told = 1;
    return inner();
  };
  CHECK(print_side_by_side({print}).size() == 1);
  CHECK(told == 0);
}
