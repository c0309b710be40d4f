#include "tests/drivers/vplus_programs.h"

#include "tests/plant/still_arm.h"

namespace firn::drivers::test {
namespace {

using plant::vplus::Code;
using plant::vplus::Machine;
using plant::vplus::Source;
using plant::vplus::StillArm;

/// The programs of these names, with their lines before them left empty.
std::string only(std::string_view text, const std::vector<std::string_view>& names) {
  std::string kept;
  bool keeps = false;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    for (const std::string_view name : names)
      keeps |= line.starts_with(".PROGRAM " + std::string(name) + "(");
    if (keeps) kept += line;
    kept += '\n';
    if (line.starts_with(".END")) keeps = false;
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return kept;
}

constexpr int kLongLoop = 1600;  // statements in a tick: the text is asked, not its speed

}  // namespace

ServedNetwork serve_network(const std::string& text, const std::vector<ClientEvent>& events, int gone) {
  const std::string others = R"(
.PROGRAM fv.match($text, $hex, same)
	same = FALSE
	IF LEN($hex) == 4 THEN
		TYPE "heard ", $text
	END
.END
.PROGRAM fv.events()
.END
.PROGRAM fv.halted(error)
.END
.PROGRAM fv.send($text)
.END
.PROGRAM fv.points($words, $answer)
.END
.PROGRAM fv.obey($words, $answer)
.END
)";
  const Code code = plant::vplus::parse(
      {{"firn.v2", only(text, {"fv.link", "fv.lines", "fv.line", "fv.gone"})}, {"others", others}});
  StillArm arm;
  Machine machine(code, arm, {.statements_per_tick = kLongLoop, .gone = gone});
  machine.set("fv.hurt", 0.0F);
  machine.set("fv.checks", -1.0F);
  machine.set("fv.lun", 5.0F);
  machine.execute(0, "fv.link", 0);
  std::int64_t now_us = 0;
  for (const ClientEvent& e : events) {
    plant::vplus::run_until(machine, now_us += 50'000);
    if (e.kind == ClientEvent::Kind::kComes) machine.network().connected();
    if (e.kind == ClientEvent::Kind::kGoes) machine.network().disconnected();
    machine.network().arrived(e.bytes);
  }
  plant::vplus::run_until(machine, now_us + 5'000'000);
  ServedNetwork s;
  for (const std::string& line : machine.typed()) {
    constexpr std::string_view kHeard = "heard ";
    if (line.starts_with(kHeard))
      s.heard.push_back(line.substr(kHeard.size()));
    else
      s.typed.push_back(line);
  }
  return s;
}

Calibrated calibrate_by(const std::string& text) {
  const std::string others = R"(
.PROGRAM fv.table()
.END
.PROGRAM fv.link()
.END
.PROGRAM fv.watch()
.END
.PROGRAM fv.move()
.END
.PROGRAM fv.run()
.END
.PROGRAM fv.react()
	RETURNE
.END
)";
  const Code code = plant::vplus::parse({{"firn.v2", only(text, {"a.firn"})}, {"others", others}});
  StillArm arm;
  Machine machine(code, arm, {.statements_per_tick = kLongLoop});
  machine.set("fv.req", 0.0F);
  machine.execute(0, "a.firn", 0);
  plant::vplus::run_until(machine, 100'000);
  for (const char* wish : {"fv.req", "fv.cal"}) machine.set(wish, 4.0F);  // the old program's, today's
  plant::vplus::run_until(machine, 200'000);
  return {arm.calibrations, machine.stopped_by(0)};
}

}  // namespace firn::drivers::test
