// Data that a report reads from a run folder, and the content of its page and of metrics.csv.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <sstream>

#include "config/experiment.h"
#include "config/fields.h"
#include "core/grid/outline.h"
#include "core/grid/random.h"
#include "files/record/event_log.h"
#include "files/usage_error.h"
#include "firn/layer_metrics_t.hpp"
#include "firn/sim_truth_t.hpp"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "report/export/run_tables.h"
#include "report/export/tables.h"
#include "report/run/differing_parameters.h"
#include "report/run/metrics.h"
#include "report/run/report_page.h"
#include "report/run/settings_table.h"
#include "runs/migrate/run_migration.h"
#include "tests/replay/tiny_run.h"
#include "tests/report/markup.h"
#include "tests/support/temp_folder.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using report::LayerRow;
using report::ReportRun;
using report::RunData;

const fs::path kGolden = fs::path(FIRN_SOURCE_DIR) / "tests" / "replay" / "golden";

std::string file_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

fs::path copy_of(const std::string& golden, const std::string& name) {
  const fs::path folder = scratch_folder("run-data-" + name) / golden;
  fs::copy(kGolden / golden, folder, fs::copy_options::recursive);
  return folder;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != text.npos);
  return text.replace(at, from.size(), to);
}

std::string error_of(const fs::path& run) {
  try {
    run_data(full_product(), run);
  } catch (const UsageError& e) {
    return e.what();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

// The messages of one channel straight from the log, the way LCM's own tools read it.
template <class Message>
std::vector<Message> logged(const fs::path& run, std::string_view channel) {
  std::vector<Message> out;
  const record::EventLogFile log(run / "log.lcm");
  record::EventLogReader reader = log.reader();
  while (const auto event = reader.next()) {
    if (event->channel != channel) continue;
    out.emplace_back();
    REQUIRE(runs::decode_recorded(event->data, out.back()));
  }
  return out;
}

RunData run_with_data(const std::string& scheme, const std::string& folder, std::vector<double> rms_um) {
  RunData r;
  r.scheme = scheme;
  r.folder = folder;
  r.result = runs::RunResult{"finished", 0, int(rms_um.size()), "part complete"};
  for (std::size_t n = 0; n < rms_um.size(); ++n) {
    LayerRow l;
    l.layer = int(n);
    l.rms_mm = rms_um[n] * 1e-3;
    l.std_mm = 0.5 * rms_um[n] * 1e-3;
    l.mean_error_mm = -0.25 * rms_um[n] * 1e-3;
    l.drops = 100 + std::int64_t(n);
    l.drops_total = 100 * std::int64_t(n + 1);
    l.deposit_s = 1.0 + double(n);
    l.cure_s = 2.0;
    l.scan_s = 3.0;
    l.decide_s = 0.5;
    l.end_s = 10.0 * double(n + 1);
    r.layers.push_back(l);
  }
  const GridSpec grid{6, 4, 0.1, 0.1};
  r.height = HeightMap(grid, 0.019);
  r.target = HeightMap(grid, 0.020);
  r.mask = Mask(grid, 1);
  r.provenance = {{"run id", "1"}, {"commit", "<" + folder + ">"}};
  return r;
}

const Element& table_after(const Element& page, std::size_t n) { return *page.all("table").at(n); }

}  // namespace

TEST_CASE("Every row of metrics.csv reads back as the layer's values in the header's units") {
  RandomStream random(31, Purpose::kTest);
  RunData run = run_with_data("mpc", "a", {5, 4, 3, 2});
  for (LayerRow& l : run.layers) {
    l.attempt = int(random.below(4));
    l.map_id = std::int64_t(random.bits() >> 2);
    for (double* v :
         {&l.target_mean_mm, &l.mean_height_mm, &l.mean_error_mm, &l.rms_mm, &l.std_mm, &l.min_error_mm,
          &l.max_error_mm, &l.volume_mm3, &l.objective_mm, &l.rms_inside_mm, &l.rms_rim_mm})
      *v = random.uniform(-0.1, 0.1);
    l.rows_lost = int(random.below(40));
    l.cells_guessed = std::int64_t(random.below(4000));
    l.iterations = std::int64_t(random.below(1000000));
  }
  run.layers[2].truth = ErrorStats{};
  run.layers[2].truth->rms_mm = 0.00123;
  run.layers[2].truth->min_mm = -0.0045;
  run.layers[2].true_outline.emplace();
  run.layers[2].true_outline->overspill = 0.0921;
  run.layers[2].true_outline->first_ring_mm = 0.2754;
  run.layers[2].true_outline->size_error_x_mm = 0.0123;
  run.layers[2].true_outline->cut = true;
  run.layers[1].measured_outline.emplace();
  run.layers[1].measured_outline->missing = 0.0042;
  run.layers[1].measured_outline->edge_width_mm = 0.3171;
  run.layers[1].passes = 4;
  const auto rows = csv_rows(report::metrics_csv(run));
  REQUIRE(rows.size() == 5);
  std::map<std::string, std::size_t> column;
  for (std::size_t c = 0; c < rows[0].size(); ++c) column[rows[0][c]] = c;
  REQUIRE(column.size() == rows[0].size());
  for (std::size_t n = 0; n < run.layers.size(); ++n) {
    const LayerRow& l = run.layers[n];
    const auto cell = [&](const char* name) { return rows[n + 1].at(column.at(name)); };
    const auto close = [&](const char* name, double value, double unit) {
      CAPTURE(name, n);
      CHECK(std::abs(printed_number(cell(name)) - value) <= 0.5001 * unit);
    };
    CHECK(cell("layer") == std::to_string(l.layer));
    CHECK(cell("attempt") == std::to_string(l.attempt));
    CHECK(cell("map_id") == std::to_string(l.map_id));
    CHECK(cell("drops_total") == std::to_string(l.drops_total));
    CHECK(cell("iterations") == std::to_string(l.iterations));
    close("target_mean_um", 1e3 * l.target_mean_mm, 1e-3);
    close("mean_height_um", 1e3 * l.mean_height_mm, 1e-3);
    close("mean_error_um", 1e3 * l.mean_error_mm, 1e-3);
    close("rms_um", 1e3 * l.rms_mm, 1e-3);
    close("std_um", 1e3 * l.std_mm, 1e-3);
    close("min_error_um", 1e3 * l.min_error_mm, 1e-3);
    close("max_error_um", 1e3 * l.max_error_mm, 1e-3);
    close("volume_mm3", l.volume_mm3, 1e-6);
    close("objective_um", 1e3 * l.objective_mm, 1e-6);
    close("end_s", l.end_s, 1e-3);
    close("rms_inside_um", 1e3 * l.rms_inside_mm, 1e-3);
    close("rms_rim_um", 1e3 * l.rms_rim_mm, 1e-3);
    CHECK(cell("rows_lost") == std::to_string(l.rows_lost));
    CHECK(cell("cells_guessed") == std::to_string(l.cells_guessed));
    CHECK(cell("true_max_abs_error_um") == (l.truth ? "4.500" : ""));
    CHECK(cell("true_overspill_pct") == (l.true_outline ? "9.210" : ""));
    CHECK(cell("true_first_ring_um") == (l.true_outline ? "275.400" : ""));
    CHECK(cell("true_size_x_um") == (l.true_outline ? "12.300" : ""));
    CHECK(cell("true_size_y_um").empty());
    CHECK(cell("true_size_cut") == (l.true_outline ? "1" : ""));
    CHECK(cell("measured_size_cut") == (l.measured_outline ? "0" : ""));
    CHECK(cell("true_rms_um") == (l.truth ? "1.230" : ""));
    CHECK(cell("true_missing_pct").empty());
    CHECK(cell("measured_missing_pct") == (l.measured_outline ? "0.420" : ""));
    CHECK(cell("measured_edge_width_um") == (l.measured_outline ? "317.100" : ""));
    CHECK(cell("measured_corner_radius_um").empty());
    CHECK(cell("passes") == (l.measured_outline ? "4" : "0"));
  }
}

TEST_CASE("An export and metrics.csv tell the same of every layer's edge") {
  const test::TempFolder folder;
  const auto sink = report::csv_sink(folder.path() / "export.csv");
  report::export_run(kGolden / "v2-estimator", "", *sink, [](double) {});
  sink->finish();
  const auto exported = csv_rows(file_text(folder.path() / "export.csv/metrics/OUTLINE.csv"));
  const auto metrics = csv_rows(report::metrics_csv(run_data(full_product(), kGolden / "v2-estimator")));
  const auto column = [](const auto& rows, std::string_view name) {
    return std::size_t(std::ranges::find(rows[0], name) - rows[0].begin());
  };
  std::size_t compared = 0;
  for (std::size_t n = 1; n < exported.size(); ++n)
    for (const auto& layer : metrics)
      if (layer[0] == exported[n][column(exported, "layer")])
        for (const OutlineMetric& m : kOutlineMetrics) {
          const bool truth = exported[n][column(exported, "is_true")] == "1";
          const std::string& cell =
              layer[column(metrics, (truth ? "true_" : "measured_") + std::string(m.name))];
          const double value = std::strtod(exported[n][column(exported, m.name)].c_str(), nullptr);
          CAPTURE(n, m.name, cell);
          if (cell.empty())
            CHECK(std::isnan(value));
          else
            CHECK(std::abs(std::strtod(cell.c_str(), nullptr) - value) < 6e-4);
          ++compared;
        }
  CHECK(compared >= 2 * std::size(kOutlineMetrics));
}

TEST_CASE("A layer of absurd numbers keeps its row and its columns in metrics.csv") {
  RunData run = run_with_data("mpc", "a", {1, 2});
  LayerRow& l = run.layers[0];
  for (double* v : {&l.target_mean_mm, &l.mean_height_mm, &l.mean_error_mm, &l.rms_mm, &l.std_mm,
                    &l.min_error_mm, &l.max_error_mm, &l.volume_mm3, &l.objective_mm, &l.end_s})
    *v = -std::numeric_limits<double>::max() * 1e-4;
  CHECK(csv_rows(report::metrics_csv(run)).size() == 3);
}

TEST_CASE("Layers of a recorded run are those of its LAYER_METRICS messages") {
  for (const char* name : {"v1-mpc", "v2-estimator", "v3-kalman", "v1-smf-resumed"}) {
    CAPTURE(name);
    const RunData run = run_data(full_product(), kGolden / name);
    std::map<std::int32_t, layer_metrics_t> wanted;
    for (const auto& m : logged<layer_metrics_t>(kGolden / name, "LAYER_METRICS")) wanted[m.layer] = m;
    REQUIRE(run.layers.size() == wanted.size());
    for (const LayerRow& row : run.layers) {
      const layer_metrics_t& m = wanted.at(row.layer);
      CHECK(row.rms_mm == m.rms_mm);
      CHECK(row.mean_error_mm == m.mean_error_mm);
      CHECK(row.drops_total == m.drops_total);
      CHECK(row.attempt == m.attempt);
      CHECK(row.end_s == double(m.header.utime_us) * 1e-6);
    }
  }
}

TEST_CASE("A layer's droplets add up to the total so far") {
  for (const char* name : {"v1-mpc", "v2-two-inks", "v3-kalman"}) {
    std::int64_t sum = 0;
    for (const LayerRow& row : run_data(full_product(), kGolden / name).layers) {
      sum += row.drops;
      CAPTURE(name, row.layer);
      CHECK(row.drops_total == sum);
    }
  }
}

TEST_CASE("The truth of a run is the simulated surface about the target, cell by cell") {
  const fs::path folder = kGolden / "v1-mpc";
  const RunData run = run_data(full_product(), folder);
  const auto truths = logged<sim_truth_t>(folder, "SIM_TRUTH");
  REQUIRE(!truths.empty());
  REQUIRE(run.truth);
  const sim_truth_t& last = truths.back();
  double sum = 0.0;
  int cells = 0;
  for (std::size_t c = 0; c < run.mask.size(); ++c) {
    CHECK(run.truth->cells[c] == double(last.height_mm[c]));
    if (!run.mask.cells[c]) continue;
    const double e = double(last.height_mm[c]) - run.target.cells[c];
    sum += e * e;
    ++cells;
  }
  REQUIRE(cells > 0);
  REQUIRE(run.layers.back().truth);
  CHECK(run.layers.back().truth->rms_mm == Approx(std::sqrt(sum / cells)));
}

TEST_CASE("A run without its log is read from the nodes' files alone, and lacks only the truth") {
  const fs::path folder = copy_of("v1-mpc", "no-log");
  const RunData whole = run_data(full_product(), folder);
  fs::remove(folder / "log.lcm");
  fs::remove(folder / "log.lcm.idx");
  const RunData run = run_data(full_product(), folder);
  CHECK_FALSE(run.truth);
  CHECK(run.layers.size() == whole.layers.size());
  for (std::size_t n = 0; n < run.layers.size(); ++n) CHECK(run.layers[n].rms_mm == whole.layers[n].rms_mm);
  CHECK(run.height.cells.size() == whole.height.cells.size());
}

TEST_CASE("A run whose result is missing or damaged has not ended, and is read all the same") {
  const fs::path folder = copy_of("v1-mpc", "no-result");
  for (const char* text : {"", "{", "[]", "nul", "{\"outcome\": 4, \"reason\": [1]}"}) {
    write_text(folder / "result.json", text);
    const RunData run = run_data(full_product(), folder);
    CHECK_FALSE(run.result);
    CHECK(!run.layers.empty());
  }
}

TEST_CASE("A folder that is no run, or whose provenance is damaged, is refused by its name") {
  const fs::path empty = scratch_folder("run-data-empty");
  CHECK(error_of(empty).find(empty.string()) != std::string::npos);
  CHECK(error_of(empty / "nowhere").find("nowhere") != std::string::npos);
  const fs::path folder = copy_of("v1-mpc", "provenance");
  const std::string whole = file_text(folder / "provenance.json");
  const std::vector<std::string> damaged{"",
                                         "{",
                                         "[1, 2]",
                                         whole.substr(0, whole.size() / 2),
                                         replaced(whole, "\"role\": \"target\"", "\"role\": \"tarGet\""),
                                         replaced(whole, "\"role\": \"target\"", "\"role\": 7"),
                                         replaced(whole, "\"scheme\": \"mpc\"", "\"scheme\": 7"),
                                         replaced(whole, "\"build/bin/firn\"", "7"),
                                         replaced(whole, "\"inputs\": [", "\"inputs\": [3, "),
                                         replaced(whole, "602bf69b", "../../..")};
  for (std::size_t n = 0; n < damaged.size(); ++n) {
    write_text(folder / "provenance.json", damaged[n]);
    CAPTURE(n, error_of(folder));
    CHECK(error_of(folder).find(folder.string()) != std::string::npos);
  }
}

TEST_CASE("A damaged or missing input is refused by its role") {
  const fs::path folder = copy_of("v1-mpc", "inputs");
  const fs::path target =
      folder / "inputs" / "602bf69bb384bc421055d4cd9c8f51b6511292e5084b83e5a2c93efda079f525";
  const std::string whole = file_text(target);
  for (const std::size_t keep : {std::size_t(0), std::size_t(5), std::size_t(60), whole.size() - 1}) {
    write_text(target, whole.substr(0, keep));
    CAPTURE(keep, error_of(folder));
    CHECK(error_of(folder).find("target") != std::string::npos);
  }
  std::string other = whole;
  other.back() = char(other.back() ^ 1);  // as readable as before
  write_text(target, other);
  CHECK(error_of(folder).find("(input 'target' was changed)") != std::string::npos);
  fs::remove(target);
  CHECK(error_of(folder).find("target") != std::string::npos);
}

TEST_CASE("Whatever byte of a node's file is damaged, the report reads the rest or refuses in words") {
  const fs::path folder = copy_of("v1-mpc", "wal");
  const fs::path wal = folder / "nodes" / "scheduler.wal";
  const std::string whole = file_text(wal);
  RandomStream random(32, Purpose::kTest);
  for (int trial = 0; trial < 25; ++trial) {
    std::string bytes = whole;
    const std::size_t at = random.below(std::uint32_t(bytes.size()));
    bytes[at] = char(bytes[at] ^ (1 << random.below(8)));
    if (trial % 5 == 0) bytes.resize(at);
    write_text(wal, bytes);
    CAPTURE(at);
    RunData run;
    try {
      run = run_data(full_product(), folder);
    } catch (const std::exception& e) {
      CHECK(std::string(e.what()).find("scheduler.wal") != std::string::npos);
      continue;
    }
    CHECK(run.layers.size() <= 4);
    for (const LayerRow& l : run.layers) CHECK(std::isfinite(l.rms_mm));
  }
}

TEST_CASE("Settings that differ are those whose resolved values differ, each with its unit") {
  std::vector<Experiment> three(3);
  three[1].control.scheme = "open_loop";
  three[2].grid.pitch_x_mm = 0.25;
  const auto rows = report::differing_parameters(three);
  REQUIRE(rows.size() == 2);
  const auto row = [&](const std::string& key) -> const report::DifferingParameter& {
    return rows[0].key == key ? rows[0] : rows[1];
  };
  CHECK(row("control.scheme").values[1] == "\"open_loop\"");
  CHECK(row("control.scheme").values[0] == row("control.scheme").values[2]);
  CHECK(row("grid.pitch_x_mm").unit == "mm");
  CHECK(row("grid.pitch_x_mm").values[2] == "0.25");
  CHECK(report::differing_parameters({three[0], three[0]}).empty());
  CHECK(report::differing_parameters({three[0]}).empty());
  CHECK(report::differing_parameters({}).empty());
}

TEST_CASE(
    "Of many settings that differ, those of the part are shown and the rest is folded away, none twice") {
  std::vector<report::DifferingParameter> many;
  for (int n = 0; n < 40; ++n) many.push_back({"valve_a.key_" + std::to_string(n) + "_", "", {"1", "2"}});
  many.push_back({"part.shape", "", {"a", "b"}});
  const std::string s = report::settings_table(many, {"one", "two"});
  const auto folded = s.find("<details>");
  REQUIRE(folded != s.npos);
  CHECK(s.find("part.shape") < folded);
  CHECK(s.find("29 more settings") > folded);
  for (const report::DifferingParameter& p : many) {
    CAPTURE(p.key);
    CHECK(s.find(p.key) != s.npos);
    CHECK(s.find(p.key) == s.rfind(p.key));
  }
  CHECK(report::settings_table({many.back()}, {"one", "two"}).find("<details>") == s.npos);
}

TEST_CASE("Any one changed number is the only setting that differs") {
  Experiment changed;
  std::vector<Field> table = fields(changed);
  int tried = 0;
  for (std::size_t k = 0; k < table.size(); k += 7) {
    double* const* value = std::get_if<double*>(&table[k].value);
    if (!value) continue;
    const double before = **value;
    **value = before * 0.5 + 0.1234567;
    const auto rows = report::differing_parameters({Experiment{}, changed});
    CAPTURE(table[k].key);
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].key == table[k].key);
    **value = before;
    ++tried;
  }
  CHECK(tried > 5);
}

TEST_CASE("The page's table gives each run's last layer, and marks the smallest RMS error") {
  const std::vector<ReportRun> runs{{run_with_data("mpc", "a", {9, 4.5, 2.25}), "identical"},
                                    {run_with_data("smf", "b", {9, 7.251}), "differs"},
                                    {run_with_data("open_loop", "c", {}), ""}};
  const Element page = parse_markup(report::report_page(runs, {}));
  const Element& table = table_after(page, 1);
  const auto rows = table_rows(table);
  REQUIRE(rows.size() == 4);
  std::map<std::string, std::size_t> column;
  for (std::size_t c = 0; c < rows[0].size(); ++c) column[rows[0][c]] = c;
  CHECK(rows[1][column.at("RMS [µm]")] == "2.25");
  CHECK(rows[2][column.at("RMS [µm]")] == "7.25");
  CHECK(rows[3][column.at("RMS [µm]")] == "–");
  CHECK(rows[1][column.at("layers")] == "2");
  CHECK(rows[2][column.at("droplets")] == "200");
  CHECK(rows[1][column.at("print time [s]")] == "30");
  CHECK(rows[1][column.at("mean error [µm]")] == "−0.563");
  CHECK(rows[1][column.at("replay")] == "identical");
  CHECK(rows[3][column.at("replay")] == "–");
  CHECK(table.only("span", "class", "best").text == "2.25");
  CHECK(table.only("span", "class", "bad").text == "differs");
}

TEST_CASE("Runs of one scheme are told apart by their folders, runs of different schemes by the scheme") {
  const auto names = [](const std::vector<ReportRun>& runs) {
    std::vector<std::string> out;
    const Element page = parse_markup(report::report_page(runs, {}));
    for (const auto& row : table_rows(table_after(page, 0))) out.push_back(row[0]);
    out.erase(out.begin());
    return out;
  };
  CHECK(names({{run_with_data("mpc", "a", {1}), ""}, {run_with_data("smf", "b", {1}), ""}}) ==
        std::vector<std::string>{"mpc", "smf"});
  CHECK(names({{run_with_data("mpc", "a", {1}), ""}, {run_with_data("mpc", "b", {1}), ""}}) ==
        std::vector<std::string>{"mpc (a)", "mpc (b)"});
}

TEST_CASE("A page is well formed and holds no number that is none, whatever the runs hold") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RunData odd = run_with_data("<i>&\"", "b", {nan, nan});
  odd.height.cells.assign(odd.height.size(), nan);
  RunData huge = run_with_data("huge", "c", {1e300, 1e-300});
  huge.height.cells[3] = 1e250;
  RunData bare;
  bare.scheme = "bare";
  bare.provenance = odd.provenance;
  for (const std::vector<ReportRun>& runs : std::vector<std::vector<ReportRun>>{
           {{odd, "x<y"}}, {{huge, ""}}, {{bare, ""}}, {{odd, ""}, {bare, ""}, {huge, ""}}}) {
    const std::string html = report::report_page(runs, {{"a.b", "mm", {"1", "2", "<3>"}}});
    const Element page = parse_markup(html);
    for (const char* word : {"nan", "inf"}) {
      for (const Element* text : page.all("text")) CHECK(text->text != word);
      for (const Element* cell : page.all("td")) CHECK(cell->all_text().find(word) == std::string::npos);
    }
    for (const Element* path : page.all("path")) CHECK_NOTHROW(polylines_of(path->attribute("d")));
  }
}

TEST_CASE("A page without runs says so") {
  const Element page = parse_markup(report::report_page({}, {}));
  CHECK(page.only("body").all_text().find("No runs.") != std::string::npos);
  CHECK(page.all("table").empty());
}

TEST_CASE("The charts by layer hold the RMS error of every layer but the substrate") {
  const RunData run = run_with_data("mpc", "a", {99, 8, 4, 2, 1});
  const Element page = parse_markup(report::report_page({{run, ""}}, {}));
  const Element* chart = nullptr;
  for (const Element* svg : page.all("svg", "role", "img"))
    if (svg->only("title").text == "RMS per layer") chart = svg;
  REQUIRE(chart);
  const ReadAxis x = x_axis_of(*chart), y = y_axis_of(*chart, true);
  const auto line = polylines_of(chart->only("path", "stroke-linejoin", "round").attribute("d")).at(0);
  REQUIRE(line.size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    CHECK(x.value(line[n].x) == Approx(double(n + 1)).margin(0.01));
    CHECK(y.value(line[n].y) == Approx(1e3 * run.layers[n + 1].rms_mm).epsilon(0.01));
  }
}

TEST_CASE("The error map of a page is empty outside the part and orange where the surface is too high") {
  RunData run = run_with_data("mpc", "a", {1, 1});
  run.mask.at(0, 0) = 0;
  run.height.at(1, 0) = run.target.at(1, 0) + 0.005;
  run.height.at(2, 0) = run.target.at(2, 0) - 0.005;
  const Element page = parse_markup(report::report_page({{run, ""}}, {}));
  const Element* map = nullptr;
  for (const Element* svg : page.all("svg", "role", "img"))
    if (svg->only("title").text == "error of mpc") map = svg;
  REQUIRE(map);
  const ReadPicture p = picture_of(map->only("image"));
  CHECK(p.at(0, 3)[3] == 0);
  CHECK(p.at(1, 3)[0] > p.at(1, 3)[2]);
  CHECK(p.at(2, 3)[2] > p.at(2, 3)[0]);
}

TEST_CASE("Provenance on the page names the commit and the digest of the configuration that the run holds") {
  const RunData run = run_data(full_product(), kGolden / "v1-mpc");
  std::map<std::string, std::string> facts(run.provenance.begin(), run.provenance.end());
  CHECK(facts.at("commit") == "5a93015b6c8a1f5655fd794f495ede2d45d8a752");
  CHECK(facts.at("run id") == "1795263705748301");
  CHECK(facts.at("command line").find("build/bin/firn print tests/replay/golden/tiny.toml") == 0);
  const fs::path other = copy_of("v1-mpc", "digest");
  write_text(other / "experiment.toml", file_text(other / "experiment.toml") + "\n");
  std::map<std::string, std::string> changed;
  for (const auto& [key, value] : run_data(full_product(), other).provenance) changed[key] = value;
  CHECK(changed.at("configuration digest (XXH64)") != facts.at("configuration digest (XXH64)"));
  CHECK(changed.at("commit") == facts.at("commit"));
}

}  // namespace firn::test
