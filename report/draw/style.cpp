// Colours: Okabe and Ito's, lighter ones of the same hues on dark.
#include "report/draw/style.h"

namespace firn::report {

const char* const kReportStyle = R"css(
:root { color-scheme: light dark;
  --bg: #ffffff; --fg: #1c2024; --soft: #5b6670; --line: #d8dde2; --grid: #e9edf0; --card: #ffffff; --good: #00664b; --bad: #b03a00;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #a8508a; --c4: #b07d00; --c5: #3a3a3a;
  --p0: #0072b2; --p1: #e69f00; --p2: #56b4e9; --p3: #cc79a7; --p4: #009e73; }
@media (prefers-color-scheme: dark) { :root {
  --bg: #14181c; --fg: #e6eaee; --soft: #a2adb7; --line: #343c44; --grid: #262d34; --card: #191e23; --good: #5fd3ad; --bad: #ff9d66;
  --c0: #56b4e9; --c1: #ff8a3d; --c2: #38c79b; --c3: #e39cc9; --c4: #f0c14b; --c5: #d0d0d0;
  --p0: #3f9bd6; --p1: #e69f00; --p2: #9ad4f5; --p3: #e39cc9; --p4: #4fc3a1; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1360px; padding: 28px 24px 60px; background: var(--bg); color: var(--fg);
  font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 19px; margin: 38px 0 6px; } h3 { font-size: 15px; margin: 0 0 6px; }
p { margin: 4px 0 12px; max-width: 78ch; } .soft { color: var(--soft); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th, td { padding: 5px 8px; text-align: right; border-bottom: 1px solid var(--line); vertical-align: top; }
thead th { color: var(--soft); font-weight: 600; border-bottom: 2px solid var(--line); vertical-align: bottom; }
th:first-child, td:first-child { white-space: nowrap; }
th:first-child, td:first-child, .text td, .text th { text-align: left; }
.text td:not(:first-child) { overflow-wrap: anywhere; } .text.whole td { overflow-wrap: normal; }
.best { font-weight: 700; } .good { color: var(--good); font-weight: 600; white-space: nowrap; } .bad { color: var(--bad); font-weight: 600; }
.swatch { display: inline-block; width: 26px; height: 8px; margin-right: 8px; vertical-align: middle; }
svg.sample { display: inline-block; width: 28px; height: 14px; margin-right: 6px; vertical-align: middle; }
.legend { position: sticky; top: 0; z-index: 1; max-width: none; margin: 18px 0 0; padding: 6px 0; background: var(--bg);
  border-bottom: 1px solid var(--line); font-size: 13.5px; }
.legend span { display: inline-block; margin-right: 20px; white-space: nowrap; } .still .legend { position: static; border: 0; }
h2.part { font-size: 22px; margin-top: 46px; padding-top: 10px; border-top: 2px solid var(--line); }
.row { display: grid; gap: 18px; grid-template-columns: repeat(auto-fill, minmax(min(100%, 360px), 1fr)); }
figure { margin: 0; padding: 14px 14px 8px; background: var(--card); border: 1px solid var(--line); border-radius: 8px; }
figcaption { font-size: 14px; margin-bottom: 8px; } .bar { max-width: 470px; margin: 10px 0 0; }
svg { display: block; width: 100%; height: auto; } .map svg { max-width: 400px; margin: 0 auto; }
.tick { font-size: 12px; fill: var(--soft); } .name { font-size: 13px; fill: var(--fg); } text { font-family: inherit; }
.grid { stroke: var(--grid); fill: none; } .axis { stroke: var(--soft); fill: none; }
.cells { image-rendering: pixelated; } .outline { stroke: var(--fg); stroke-width: 1; fill: none; }
code { font: 13px ui-monospace, "DejaVu Sans Mono", monospace; }
/* Long names of runs give way to their numbers. */
@media (max-width: 1320px) { th:first-child, td:first-child { white-space: normal; } }
@media (max-width: 600px) { td:first-child { min-width: 9em; overflow-wrap: anywhere; } }
@media print { body { max-width: none; } figure { break-inside: avoid; } }
)css";

std::string standalone_svg(std::string svg) {
  const std::size_t end_of_tag = svg.find('>');
  if (svg.compare(0, 4, "<svg") != 0 || end_of_tag == std::string::npos) return svg;
  svg.insert(
      end_of_tag + 1,
      "<style>" + std::string(kReportStyle) +
          "svg { background: var(--bg); font-family: system-ui, \"DejaVu Sans\", sans-serif; }</style>\n");
  return svg;
}

}  // namespace firn::report
