// The gap between layer and bound closing, over processor seconds: a picture of all instances.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "core/control/mpc/layer/layer_solver.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_page.h"
#include "tests/bench/mpc_instances.h"
#include "tests/bench/mpc_tables.h"

namespace firn::bench {
namespace {

using namespace firn::control::mpc;

constexpr double kFrom_ms = 4.0, kTo_ms = 2000.0;
constexpr double kWidth = 400, kHeight = 236;
constexpr int kColumns = 3;

struct Moment {
  double s = 0.0, found_um = 0.0, bound_um = 0.0;
};

std::vector<Moment> record(const HeightMap& h, const control::Setup& setup) {
  std::vector<Moment> moments;
  const double start = thread_cpu_s();
  LayerProblem problem(setup, h, {});
  problem.set_drops(DropletPattern(setup.grid, 1));
  const double per_cell = 1e3 / double(problem.counted());
  solve_layer(problem, {3, 2, 40, 1e-6}, serially, [&](const LayerSolution& s) {
    moments.push_back({thread_cpu_s() - start, s.found_mm * per_cell, s.lower_bound_mm * per_cell});
  });
  return moments;
}

// Steps: a value holds until the next moment.
std::string line(const std::vector<Moment>& moments, double Moment::*value, const report::Axis& x,
                 const report::Axis& y, const char* look) {
  std::string d;
  double before = 0.0;
  for (const Moment& m : moments) {
    if (!(m.*value > 0.0)) continue;
    const double px = x.px(std::clamp(1e3 * m.s, kFrom_ms, kTo_ms));
    const auto py = [&](double v) { return y.px(std::clamp(v, y.low(), y.high())); };
    char text[96];
    if (d.empty())
      std::snprintf(text, sizeof text, "M%.1f %.1f", px, py(m.*value));
    else
      std::snprintf(text, sizeof text, "L%.1f %.1fL%.1f %.1f", px, py(before), px, py(m.*value));
    d += text;
    before = m.*value;
  }
  char text[64];
  std::snprintf(text, sizeof text, "H%.1f", x.px(kTo_ms));
  return "<path fill=\"none\" " + std::string(look) + " d=\"" + d + text + "\"/>\n";
}

std::string panel(const std::string& name, const std::vector<Moment>& moments, double left, double top) {
  const Moment& last = moments.back();
  const report::Frame frame{62, 34, kWidth - 20, kHeight - 40};
  const report::Axis x(kFrom_ms, kTo_ms, frame.left, frame.right, 4, report::Axis::Kind::kLogarithmic);
  const report::Axis y(0.99 * last.found_um, 1.012 * last.found_um, frame.bottom, frame.top, 4);
  std::string s = report::draw_axes(frame, x, y, "processor time [ms]", "mean |error| [um]");
  s += line(moments, &Moment::found_um, x, y, "stroke=\"var(--c0)\" stroke-width=\"2\"");
  s += line(moments, &Moment::bound_um, x, y,
            "stroke=\"var(--c1)\" stroke-width=\"2\" stroke-dasharray=\"6 3\"");
  char text[160];
  std::snprintf(text, sizeof text, "%s: gap %.4f %%", name.c_str(),
                std::max(0.0, 100.0 * (last.found_um - last.bound_um) / last.found_um));
  s += report::svg_text(frame.left, 24, "start", "head", text);
  std::snprintf(text, sizeof text, "<g transform=\"translate(%g %g)\">\n", left, top);
  return text + s + "</g>\n";
}

}  // namespace

int draw_gap(const std::string& folder, const std::string& svg, const std::string& csv) {
  const control::Setup setup = setup_of(100);
  const int rows = (int(kInstances.size()) + kColumns - 1) / kColumns;
  const double width = kColumns * kWidth, height = rows * kHeight + 40;
  std::string out = report::svg_open(width, height, "Layers and bounds of six instances over processor time");
  out += "<style>" + std::string(report::kReportStyle) +
         "svg { background: var(--bg); font-family: system-ui, \"DejaVu Sans\", sans-serif; } .head { "
         "font-size: 14px; fill: var(--fg); }</style>\n";
  std::string table = "instance,cpu_s,found_um,bound_um\n";
  for (std::size_t n = 0; n < kInstances.size(); ++n) {
    const auto moments = record(read_instance(folder, kInstances[n]), setup);
    out += panel(kInstances[n], moments, double(n % kColumns) * kWidth, double(n / kColumns) * kHeight);
    for (const Moment& m : moments) {
      char text[128];
      std::snprintf(text, sizeof text, "%s,%.4f,%.6f,%.6f\n", kInstances[n], m.s, m.found_um, m.bound_um);
      table += text;
    }
  }
  const double y = rows * kHeight + 18;
  char legend[256];
  std::snprintf(legend, sizeof legend,
                "<path d=\"M62 %.0fh34\" stroke=\"var(--c0)\" stroke-width=\"2\"/><path d=\"M262 %.0fh34\" "
                "stroke=\"var(--c1)\" "
                "stroke-width=\"2\" stroke-dasharray=\"6 3\"/>\n",
                y - 4, y - 4);
  out += legend + report::svg_text(102, y, "start", "head", "best layer so far") +
         report::svg_text(302, y, "start", "head", "lower bound for every layer (axes cut at 1 % below)") +
         "</svg>\n";
  std::ofstream(svg) << out;
  if (!csv.empty()) std::ofstream(csv) << table;
  return 0;
}

}  // namespace firn::bench
