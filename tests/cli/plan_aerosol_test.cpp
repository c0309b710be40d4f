#include "cli/plan_aerosol.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "config/aerosol_lab.h"
#include "core/motion/aerosol/paper_jobs.h"
#include "files/exit_codes.h"
#include "files/path/print_job_file.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

const std::string kSource = FIRN_SOURCE_DIR;

std::filesystem::path written(const Scratch& scratch, const std::string& name, const std::string& text) {
  std::ofstream(scratch / name) << text;
  return scratch / name;
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("The stored job is the paper's Fig. 7 and plans on the stored machine", "[aerosol]") {
  const PrintJob job = read_print_job(kSource + "/experiments/thompson-fig7.json"),
                 fig7 = motion::thompson_fig7();
  REQUIRE(job.segments.size() == fig7.segments.size());
  CHECK(job.start == fig7.start);
  CHECK(job.end == fig7.end);
  for (std::size_t n = 0; n < job.segments.size(); ++n) {
    CHECK(job.segments[n].from == fig7.segments[n].from);
    CHECK(job.segments[n].to == fig7.segments[n].to);
    CHECK(job.segments[n].speed_mm_s == fig7.segments[n].speed_mm_s);
  }
  const motion::AerosolMachine machine = aerosol_machine(load_machine(kSource + "/labs/aerosol.toml"));
  CHECK(machine.axis.v_max_mm_s == 4.0);
  CHECK(machine.axis.alpha_mm_s2 == 30.0);
  CHECK(machine.stage_high.x_mm == 100.0);
  CHECK(motion::plan_aerosol(job, machine).ok());
}

TEST_CASE("firn plan writes the trajectory and the picture, whole, for an aerosol machine", "[aerosol]") {
  Scratch scratch{"plan-aerosol"};
  PlanCommandOptions o;
  o.paths = kSource + "/experiments/thompson-fig7.json";
  o.csv = (scratch / "out.csv").string();
  o.plot = (scratch / "out.svg").string();
  CHECK(run_plan_aerosol(load_machine(kSource + "/labs/aerosol.toml"), o) == kOk);
  const std::string csv = text_of(o.csv);
  CHECK_THAT(csv, Catch::StartsWith("t_s,x_mm,y_mm,joint_1_mm,joint_2_mm,shutter_command\n0,0,10,50,40,0\n"));
  CHECK_THAT(csv, Contains(",1\n"));
  CHECK_THAT(text_of(o.plot), Catch::StartsWith("<svg ") && Catch::EndsWith("</svg>\n"));
}

TEST_CASE("A job with a refused segment exits with 1 and writes nothing", "[aerosol]") {
  Scratch scratch{"plan-aerosol-refused"};
  PlanCommandOptions o;
  o.paths = written(scratch, "fast.csv", "x_mm,y_mm,speed_mm_s\n0,0,0\n5,0,3\n5,9,7\n").string();
  o.csv = (scratch / "out.csv").string();
  CHECK(run_plan_aerosol(load_machine(kSource + "/labs/aerosol.toml"), o) == kFailed);
  CHECK_FALSE(std::filesystem::exists(o.csv));
  o.corner = "round";
  CHECK_THROWS_WITH(run_plan_aerosol(load_machine(kSource + "/labs/aerosol.toml"), o),
                    Contains("--corner round: must be one of paper, loop, hybrid"));
}

TEST_CASE("A mistake in a job's file is named with file, key or line", "[aerosol]") {
  Scratch scratch{"print-job"};
  const auto of = [&](const std::string& name, const std::string& text) {
    return read_print_job(written(scratch, name, text));
  };
  CHECK_THROWS_WITH(of("a.json", "{\"segments\": [}"), Contains("a.json: byte 15: is no JSON"));
  CHECK_THROWS_WITH(of("a.json", "{}"), Contains("has no key \"segments\""));
  CHECK_THROWS_WITH(of("a.json", R"({"segment": []})"),
                    Contains("a.json.segment: unknown key; the nearest known one is segments"));
  CHECK_THROWS_WITH(of("a.json", R"({"segments": [{"from": [0, 0], "to": [1, 1]}]})"),
                    Contains("segments[0]: has no key \"speed_mm_s\""));
  CHECK_THROWS_WITH(of("a.json", R"({"segments": [{"from": [0, null], "to": [1, 1], "speed_mm_s": 3}]})"),
                    Contains("segments[0].from[1]: must be a number"));
  CHECK_THROWS_WITH(of("a.json", R"({"segments": [{"from": [0, 1e9], "to": [1, 1], "speed_mm_s": 3}]})"),
                    Contains("must lie within +-100000"));
  CHECK_THROWS_WITH(of("a.csv", "x,y\n"),
                    Contains("a.csv:1: a job of lines has the columns x_mm, y_mm and speed_mm_s"));
  CHECK_THROWS_WITH(of("a.csv", "x_mm,y_mm,speed_mm_s\n0,0,0\n1,nan,3\n"),
                    Contains("a.csv:3: y_mm = nan: is not a finite number"));
  CHECK_THROWS_WITH(of("a.csv", "x_mm,y_mm,speed_mm_s\n0,0,0\n1,1\n"),
                    Contains("a.csv:3: 2 columns, the header has 3"));
  CHECK_THROWS_WITH(of("a.csv", "x_mm,y_mm,speed_mm_s\n0,0,0\n"), Contains("fewer than two points"));
  CHECK_THROWS_WITH(of("a.txt", ""), Contains("must end in .json or .csv"));
  CHECK_THROWS_WITH(read_print_job("nowhere.json"), Contains("nowhere.json: cannot be read"));
}
