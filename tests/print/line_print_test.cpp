// A print of lines in the aerosol lab, in process.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "config/include.h"
#include "config/labs.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/enums.h"
#include "firn/line_plan_t.hpp"
#include "print/labs/full_product.h"
#include "print/preview/print_preview.h"
#include "print/simulated/memory_print.h"

using namespace firn;

namespace {

const std::filesystem::path kPrintFolder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

Experiment meander(std::vector<std::string> more = {}) {
  return load_experiment(kPrintFolder / "aerosol-meander.toml", more);
}

MemoryPrintReport printed(const Experiment& e, std::vector<line_plan_t>* plans = nullptr) {
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    line_plan_t m{};
    if (plans && channel == channels::kLinePlan.name && m.decode(bytes.data(), 0, int(bytes.size())) >= 0)
      plans->push_back(std::move(m));
  };
  return print_in_memory(full_product(), e, make_inputs(full_product(), e, kPrintFolder), options);
}

}  // namespace

TEST_CASE("A meander is printed to its end, and feedback meets the section that open loop drifts away from",
          "[line]") {
  const MemoryPrintReport open = printed(meander({"control.scheme=open_loop", "plant.aerosol.drift=0.2",
                                                  "plant.aerosol.drift_spread=0"})),
                          closed =
                              printed(meander({"plant.aerosol.drift=0.2", "plant.aerosol.drift_spread=0"}));
  CHECK(open.result.status == 0);
  CHECK(closed.result.status == 0);
  CHECK(closed.result.layers == 6);
  INFO("open " << open.lines.section_rms << ", closed " << closed.lines.section_rms << ", start "
               << closed.lines.worst_start_mm << ", end " << closed.lines.worst_end_mm);
  CHECK(closed.lines.section_rms < 0.03);
  CHECK(open.lines.section_rms > 2.0 * closed.lines.section_rms);
  CHECK(closed.lines.worst_start_mm < 0.05);
  CHECK(closed.lines.worst_end_mm < 0.05);
  CHECK(closed.lines.gaps == 0.0);
}

TEST_CASE("The delays that the lab identifies are the shutter's own with its tail", "[line]") {
  std::vector<line_plan_t> plans;
  printed(meander({"aerosol.layers=3"}), &plans);
  REQUIRE(plans.size() == 4);
  CHECK(PlanDecision(plans.back().decision) == PlanDecision::kEnd);
  // Half of the level is reached where the opening is half: delay + tail ln 2; the start-up blob comes first.
  CHECK(plans[2].open_delay_s == Approx(0.03).margin(0.012));
  CHECK(plans[2].close_delay_s == Approx(0.045 + 0.004).margin(0.012));
}

TEST_CASE("A preview of lines names length, layers and ink", "[line]") {
  const Experiment e = meander();
  const PrintPreview p = preview_print(e, make_inputs(full_product(), e, kPrintFolder), kPrintFolder);
  CHECK(p.layers == 6);
  CHECK(p.amount == 6 * 40);
  CHECK(p.volume_mm3 == Approx(6 * 40.0 / 3.0 * 0.005));
  CHECK_THAT(preview_text(p),
             Catch::Contains("lines aerosol-meander.json") && Catch::Contains("240 mm of lines"));
}

TEST_CASE("A preview remarks on a line that is given twice, by file and segments", "[line]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "firn-doubled-lines";
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "twice.json", R"({"start": [0.5, 0.5], "end": [0.5, 5.5], "segments": [)"
                                               R"({"from": [1, 2], "to": [6, 2], "speed_mm_s": 3},)"
                                               R"({"from": [6, 2], "to": [1, 2], "speed_mm_s": 3}]})");
  const Experiment e =
      meander({"aerosol.job='" + (folder / "twice.json").string() + "'", "aerosol.layers=1"});
  const PrintPreview p = preview_print(e, make_inputs(full_product(), e, kPrintFolder), kPrintFolder);
  REQUIRE(p.remarks.size() == 1);
  CHECK_THAT(p.remarks[0], Catch::Contains("twice.json: segments[1] lies on segments[0] along 5 mm"));
  CHECK(preview_print(meander(), make_inputs(full_product(), meander(), kPrintFolder), kPrintFolder)
            .remarks.empty());
}

TEST_CASE("Lines that no print can do are refused by file, segment and limit", "[line]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "firn-refused-lines";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(std::filesystem::path(FIRN_SOURCE_DIR) / "labs/aerosol.toml",
                             folder / "aerosol.toml", std::filesystem::copy_options::overwrite_existing);
  const auto refusal = [&](const std::string& start, const std::string& segment) -> std::string {
    write_file_atomically(folder / "own.json",
                          "{\"start\": " + start + ", \"end\": [0.5, 5.5], \"segments\": [" +
                              R"({"from": [1, 2], "to": [6, 2], "speed_mm_s": 3}, {)" + segment + "}]}");
    const Experiment e = meander({"aerosol.job='own.json'", "aerosol.machine='aerosol.toml'"});
    try {
      check_inputs(full_product(), e, make_inputs(full_product(), e, folder));
    } catch (const UsageError& problem) {
      return problem.what();
    }
    return "accepted";
  };
  const std::string line = R"("from": [1, 1], "to": [6, 1], "speed_mm_s": )", near = "[0.5, 0.5]";
  CHECK(refusal(near, line + "2") == "accepted");
  CHECK(refusal(near, line + "-2") == "own.json: segments[1]: speed -2 mm/s is not positive");
  CHECK(refusal(near, R"("from": [1, 1], "to": [1, 1], "speed_mm_s": 2)") ==
        "own.json: segments[1]: it has no length: both ends are (1, 1) mm");
  CHECK(refusal("[-60, 0.5]", line + "2") ==
        "own.json: segments[0]: the stage's x would go to -60 mm, its range is -50 to 50 mm");
  CHECK_THAT(refusal(near, line + "0.001"), Catch::Contains("own.json: segments[1]: at 0.001 mm/s") &&
                                                Catch::Contains("process.nozzle_gap_mm = 3"));
}

namespace {

// Why a print of lines is refused on a stage of 50 mm with the part's origin in its middle; "": it is not.
std::string refused_on_small_stage(const std::vector<std::string>& set) {
  const Experiment e = meander(set);
  Blobs inputs = make_inputs(full_product(), e, kPrintFolder);
  const std::string machine =
      "[machine]\nname = \"small\"\nkind = \"aerosol\"\n[aerosol]\nv_max_mm_s = 4.0\n"
      "stage_origin_x_mm = 25.0\nstage_origin_y_mm = 25.0\n"
      "[axis_1]\nlow_mm = 0.0\nhigh_mm = 50.0\n[axis_2]\nlow_mm = 0.0\nhigh_mm = 50.0\n";
  const auto* bytes = reinterpret_cast<const std::byte*>(machine.data());
  for (Blob& b : inputs)
    if (b.role == "machine") b.bytes = {bytes, bytes + machine.size()};
  try {
    check_inputs(full_product(), e, inputs);
  } catch (const UsageError& problem) {
    return problem.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A scan or a picture beyond the travel of a small stage is refused by file, place and keys",
          "[line]") {
  CHECK(refused_on_small_stage({}) == "");
  CHECK_THAT(refused_on_small_stage({"grid.ny=1830"}),
             Catch::Contains(
                 "aerosol.toml: the scan would take the stage's y to 36.59 mm, it reaches -25 to 25 mm") &&
                 Catch::Contains("axis_2.high_mm") && Catch::Contains("grid.ny = 1830"));
  CHECK_THAT(refused_on_small_stage({"grid.origin_y_mm=-25", "grid.ny=1700"}),
             Catch::Contains("the scan would take the stage's y to -25.02 mm"));
  CHECK(refused_on_small_stage({"stage.y_max_mm=6"}) == "");
  CHECK_THAT(refused_on_small_stage({"stage.y_max_mm=5.9"}),
             Catch::Contains("the scan would take the stage's y to 5.99 mm, it reaches -25 to 5.9 mm") &&
                 Catch::Contains("stage.y_max_mm"));
  CHECK_THAT(refused_on_small_stage({"camera.use=on"}),
             Catch::Contains("aerosol.toml: the camera's stop over segments[") &&
                 Catch::Contains("would take the stage's x to -") &&
                 Catch::Contains("aerosol.camera_x_mm = 30"));
  CHECK(refused_on_small_stage({"camera.use=on", "aerosol.camera_x_mm=20"}) == "");
  CHECK(refused_on_small_stage({"camera.use=on", "aerosol.camera_x_mm=20", "aerosol.width_by=speed",
                                "devices.laser_profiler.port=none", "grid.ny=1830"}) == "");
  CHECK_THAT(refused_on_small_stage({"stage.x_min_mm=40", "stage.x_max_mm=50"}),
             Catch::Contains("aerosol.toml: x of the machine, -25 to 25 mm, and stage.x_min_mm = 40 to "
                             "stage.x_max_mm = 50 mm have no travel in common"));
}

TEST_CASE("The shipped jobs of lines and their scans fit the shipped machine", "[line]") {
  const auto check = [](const std::vector<std::string>& set) {
    const Experiment e = load_experiment(kPrintFolder / "aerosol-fig7.toml", set);
    CHECK_NOTHROW(check_inputs(full_product(), e, make_inputs(full_product(), e, kPrintFolder)));
  };
  check({"camera.use=on"});
  check({"aerosol.job=thompson-fig11.json", "grid.nx=410", "grid.ny=1830", "grid.origin_x_mm=-0.8",
         "camera.use=on"});
  const Experiment e = meander({"camera.use=on"});
  CHECK_NOTHROW(check_inputs(full_product(), e, make_inputs(full_product(), e, kPrintFolder)));
}

TEST_CASE("An open loop never changes its way", "[line]") {
  std::vector<line_plan_t> plans;
  printed(meander({"aerosol.layers=3", "control.scheme=open_loop"}), &plans);
  REQUIRE(plans.size() == 4);
  CHECK(plans[1].switch_mm == plans[0].switch_mm);
  CHECK(plans[2].x_mm == plans[0].x_mm);
}

TEST_CASE("The camera walks the lines after each layer: width, middle and overspray of every station",
          "[line]") {
  std::vector<line_plan_t> plans;
  const std::vector<std::string> two{"aerosol.job=aerosol-lines.json", "aerosol.layers=2", "grid.nx=250",
                                     "grid.ny=80", "camera.use=on"};
  const MemoryPrintReport r = printed(meander(two), &plans);
  INFO(r.result.reason);
  REQUIRE(r.result.status == 0);
  REQUIRE(plans.size() == 3);
  CHECK(plans[0].looks == plans[0].stations);
  for (const line_plan_t& p : {plans[1], plans[2]}) {
    int seen = 0;
    for (int s = 0; s < p.looks; ++s) {
      if (std::isnan(p.seen_width_mm[std::size_t(s)])) continue;
      ++seen;
      // Ink looks wider than it is at half height, the more the thicker it is.
      CHECK(p.seen_width_mm[std::size_t(s)] > p.width_mm[std::size_t(s)]);
      CHECK(p.seen_width_mm[std::size_t(s)] < 0.15);
      CHECK(std::abs(p.seen_offset_mm[std::size_t(s)]) < 0.004);
      CHECK(p.seen_overspray[std::size_t(s)] == Approx(0.08).margin(0.08));
    }
    CHECK(seen == p.looks);
  }
  CHECK(r.looks.stations == plans[2].looks);
  CHECK(r.looks.width_rms_mm < 0.01);
  CHECK(r.looks.offset_rms_mm < 0.004);
  CHECK(r.looks.overspray == Approx(0.04).margin(0.04));
  CHECK(r.looks.gap_mm == 0.0);
}

TEST_CASE("Width in the camera's pictures steers the speed, and meets the wanted width under drift",
          "[line]") {
  const std::vector<std::string> all{"aerosol.job=aerosol-lines.json",
                                     "aerosol.layers=5",
                                     "grid.nx=250",
                                     "grid.ny=80",
                                     "camera.use=on",
                                     "plant.aerosol.drift=-0.2",
                                     "plant.aerosol.drift_s=20",
                                     "plant.aerosol.drift_spread=0"};
  std::vector<std::string> open = all, closed = all;
  open.push_back("control.scheme=open_loop");
  open.push_back("camera.use=off");
  closed.push_back("aerosol.width_by=speed");
  const double free_um = 1e3 * printed(meander(open)).lines.visible_rms_mm,
               held_um = 1e3 * printed(meander(closed)).lines.visible_rms_mm;
  INFO("open " << free_um << " um, by the width " << held_um << " um");
  CHECK(held_um < 0.6 * free_um);
}

TEST_CASE("A camera alone holds the lines' width as it does beside a profiler, and finds their ends",
          "[line]") {
  const std::vector<std::string> all{"aerosol.job=aerosol-lines.json",
                                     "aerosol.layers=4",
                                     "grid.nx=250",
                                     "grid.ny=80",
                                     "camera.use=on",
                                     "aerosol.width_by=speed",
                                     "plant.aerosol.drift=-0.2",
                                     "plant.aerosol.drift_s=20",
                                     "plant.aerosol.drift_spread=0"};
  std::vector<std::string> without = all;
  without.push_back("devices.laser_profiler.port=none");
  std::vector<line_plan_t> plans;
  const MemoryPrintReport both = printed(meander(all)), alone = printed(meander(without), &plans);
  INFO(alone.result.reason);
  REQUIRE(alone.result.status == 0);
  CHECK(alone.result.layers == 4);
  INFO("both " << 1e3 * both.lines.visible_rms_mm << " um, alone " << 1e3 * alone.lines.visible_rms_mm
               << " um; delays " << plans.at(1).open_delay_s << ", " << plans.at(1).close_delay_s
               << " s; ends " << alone.lines.worst_start_mm << ", " << alone.lines.worst_end_mm
               << " mm, with both " << both.lines.worst_start_mm << ", " << both.lines.worst_end_mm);
  CHECK(alone.lines.visible_rms_mm < 1.2 * both.lines.visible_rms_mm);
  CHECK(alone.lines.worst_start_mm < 0.05);
  CHECK(alone.lines.worst_end_mm < 0.05);
  // Layers print upon each other: seen as one they would begin and end at the farthest.
  CHECK(std::abs(plans.at(2).start_error_mm) < 0.02);
  CHECK(std::abs(plans.at(2).end_error_mm) < 0.02);
}

TEST_CASE("The sheath's gas holds the lines' width and the speed their height, layer by layer", "[line]") {
  const std::vector<std::string> all{"aerosol.job=aerosol-lines.json", "aerosol.layers=5", "grid.nx=250",
                                     "grid.ny=80", "plant.aerosol.nozzle_mm=0.295"};
  std::vector<std::string> free = all, held = all;
  free.push_back("aerosol.hold=height");
  held.insert(held.end(), {"aerosol.hold=height", "aerosol.width_by=gas"});
  std::vector<line_plan_t> plans;
  const LineTruth wide = printed(meander(free)).lines, line = printed(meander(held), &plans).lines;
  INFO("width off by " << 1e3 * wide.width_rms_mm << " um, held " << 1e3 * line.width_rms_mm << " um; height "
                       << wide.height_rms << ", " << line.height_rms);
  CHECK(line.width_rms_mm < 0.4 * wide.width_rms_mm);
  CHECK(line.height_rms < 0.03);
  REQUIRE(plans.size() == 6);
  CHECK(plans[0].sheath_share == 1.0);
  for (std::size_t n = 1; n < 5; ++n) CHECK(plans[n].sheath_share > 1.02);
}

TEST_CASE("More atomizer gas than the lab believes brings more ink, and a stronger sheath a narrower line",
          "[line]") {
  const auto lines = [](const std::string& gas) {
    return printed(meander({"aerosol.job=aerosol-lines.json", "grid.nx=250", "grid.ny=80", "aerosol.layers=1",
                            "control.scheme=open_loop", "plant.aerosol.drift_spread=0",
                            "plant.aerosol.wander=0", "plant.sensor_noise_mm=0", gas}))
        .lines;
  };
  const LineTruth usual = lines("gas.sheath_sccm=40"), more = lines("gas.atomizer_sccm=24"),
                  narrow = lines("gas.sheath_sccm=120"), wide = lines("gas.sheath_sccm=15");
  INFO("section " << usual.section_mean << ", " << more.section_mean << "; width [mm] " << usual.width_mean_mm
                  << ", " << narrow.width_mean_mm << ", " << wide.width_mean_mm);
  CHECK((1.0 + more.section_mean) / (1.0 + usual.section_mean) == Approx(1.2).epsilon(0.02));
  CHECK(narrow.width_mean_mm < 0.85 * usual.width_mean_mm);
  CHECK(wide.width_mean_mm > 1.2 * usual.width_mean_mm);
  CHECK(narrow.section_mean == Approx(usual.section_mean).margin(0.03));
}
