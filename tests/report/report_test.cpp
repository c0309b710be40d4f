// A real print by the Lab: replay, audit and report of the same folder.
#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "cli/replay_command.h"
#include "cli/report_command.h"
#include "config/include.h"
#include "core/grid/random.h"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "report/draw/svg.h"
#include "report/run/metrics.h"
#include "tests/replay/tiny_run.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;

std::string print_part(const std::string& name, const std::string& scheme, std::uint64_t crash_after = 0) {
  const fs::path file = fs::path(FIRN_SOURCE_DIR) / "experiments" / "demo.toml";
  const Experiment e = load_experiment(file, {"control.scheme=" + scheme, "part.height_mm=0.02"});
  const runs::RunFolder run = runs::RunFolder::create(
      scratch_folder(name), e, make_inputs(full_product(), e, file.parent_path()), {"firn", "print"});
  LabRunOptions options;
  options.crash_after_steps = crash_after;
  for (LabRunReport r = run_in_lab(full_product(), run, options); r.crashed;
       r = run_in_lab(full_product(), run, options)) {
    options.resume = true;
    options.crash_after_steps = 0;
  }
  return run.path().string();
}

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST_CASE(
    "a report of two prints is one page without outside references, and metrics.csv holds every layer") {
  ReportOptions options;
  options.runs = {print_part("report-mpc", "mpc"), print_part("report-open", "open_loop")};
  options.output = (scratch_folder("report") / "report.html").string();
  write_report(full_product(), options);
  const std::string page = text_of(options.output);
  CHECK(page.find("http") == page.find("http://www.w3.org/2000/svg"));
  CHECK(count(page, "<script") == 0);
  CHECK(count(page, "<link") == 0);
  CHECK(count(page, "<svg") == count(page, "</svg>"));
  CHECK(count(page, "data:image/png;base64,") == 2 * 2 + 2);  // height and error of both, two colour bars
  CHECK(count(page, ">identical<") == 2);
  const std::string head = page.substr(0, page.find("</table>"));  // the first screen
  CHECK(count(head, ">within tolerance</span>: RMS") == 2);
  CHECK(count(head, ">clean</span>") == 2);
  for (const char* column : {"stops", "resumes", "doubts", "faults", "warnings", "lost rows"})
    CHECK(head.find("<th>" + std::string(column) + "</th>") != head.npos);
  CHECK(page.find("control.scheme") != page.npos);
  for (const char* no_number : {" nan", "\"nan", ">nan", " inf", "\"inf", ">inf"})
    CHECK(page.find(no_number) == page.npos);

  const report::RunData run = run_data(full_product(), options.runs[0]);
  CHECK(run.layers.size() >= 3);
  CHECK(run.layers.back().truth);
  CHECK(run.layers.back().truth->rms_mm < 0.01);
  CHECK(run.layers.back().drops_total > 1000);
  const std::string csv = text_of(fs::path(options.runs[0]) / "metrics.csv");
  CHECK(csv == report::metrics_csv(run));
  CHECK(count(csv, "\n") == run.layers.size() + 1);
  const std::size_t columns = std::size_t(std::ranges::count(csv.substr(0, csv.find('\n')), ','));
  CHECK(count(csv, ",") == columns * (run.layers.size() + 1));
}

TEST_CASE(
    "a report of a print with two inks shows the wanted and the printed ink of its layers and the block they "
    "make") {
  const fs::path file = fs::path(FIRN_SOURCE_DIR) / "experiments" / "gear.toml";
  const Experiment e = load_experiment(file);
  const runs::RunFolder run =
      runs::RunFolder::create(scratch_folder("report-inks"), e,
                              make_inputs(full_product(), e, file.parent_path()), {"firn", "print"});
  REQUIRE(run_in_lab(full_product(), run, {}).result.status == 0);
  const report::RunData data = run_data(full_product(), run.path());
  REQUIRE(data.inks);
  CHECK(std::int32_t(data.inks->layers.size()) == data.layers.back().layer);
  std::size_t object = 0, printed = 0;
  for (const report::InkLayer& l : data.inks->layers)
    for (std::size_t c = 0; c < l.planned.size(); ++c) {
      object += l.planned.of(c) == Material::kA;
      if (l.planned.of(c) == Material::kNone) continue;
      ++printed;
      CHECK(data.mask.cells[c] != 0);
      CHECK(l.planned.of(c) == l.wanted.of(c));
    }
  CHECK(object > 1000);
  CHECK(printed > object);
  for (std::size_t c = 0; c < data.mask.size(); ++c)
    if (data.mask.cells[c]) CHECK(data.inks->printed.top_mm(c) == Approx(data.height.cells[c]).margin(0.02));
  ReportOptions options;
  options.runs = {run.path().string()};
  options.output = (scratch_folder("report-inks-page") / "report.html").string();
  write_report(full_product(), options);
  const std::string page = text_of(options.output);
  CHECK(page.find("<h2>Inks</h2>") != page.npos);
  CHECK(count(page, ">wanted</text>") == 6 + 1);  // six layers and the block
  CHECK(page.find("0 wrong voxels of") != page.npos);
  CHECK(count(page, "<svg") == count(page, "</svg>"));
}

TEST_CASE("a print that died and was resumed replays identical and its audit is clean") {
  RandomStream random(21, Purpose::kKill);
  for (int trial = 0; trial < 12; ++trial) {
    const std::uint64_t crash_after = 100 + random.below(5000);
    const std::string run = print_part("died", trial % 2 ? "mpc" : "smf", crash_after);
    INFO("died after " << crash_after << " steps");
    ReplayCommandOptions options;
    options.run = run;
    const replay::RunVerdict verdict = replay_verdict(full_product(), options);
    INFO(replay::to_text(verdict));
    CHECK(verdict.identical());
    CHECK(verdict.nodes.size() == 8);
    for (const auto& node : verdict.nodes) CHECK(node.incarnations == 2);
    const replay::AuditVerdict audit = replay::audit_run(run);
    INFO(to_text(audit));
    CHECK(audit.clean());
    CHECK(audit.finished);
    CHECK(audit.with_world);
    CHECK(audit.triggered > 0);
  }
}

TEST_CASE("axes have round ticks inside their range, for any range") {
  for (const auto& [low, high] :
       {std::pair{0.0, 105.0}, {-0.13, 10.4}, {3.0, 3.0}, {-2e-5, 7e-5}, {1e6, 4e9}}) {
    const report::Axis axis(low, high, 0, 400, 6);
    INFO(low << " to " << high);
    CHECK(axis.ticks().size() >= 2);
    CHECK(axis.ticks().size() <= 8);
    for (const auto& t : axis.ticks()) {
      CHECK(axis.px(t.value) >= -0.01);
      CHECK(axis.px(t.value) <= 400.01);
    }
  }
  CHECK(report::number(-0.001, 2) == "0.00");
  CHECK(report::number(-1.5, 1) == "−1.5");
  CHECK(report::number(1.0 / 0.0, 2) == "–");
  CHECK(report::escape_html("a<b>&\"") == "a&lt;b&gt;&amp;&quot;");
}

}  // namespace
}  // namespace firn::test
