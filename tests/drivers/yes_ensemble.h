// YesEnsemble is a stage whose controller says yes to everything, whose axes stand where they were sent and
// which counts what was listed. The including test includes Catch.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "drivers/stage/stage.h"
#include "tests/drivers/bench.h"

namespace firn::drivers::test {

struct YesEnsemble {
  Stage stage;
  Bench bench{stage};
  std::array<std::string, 3> at{"0", "0", "0"};
  std::string pulses = "0";
  std::vector<std::string> log;
  std::int64_t line_us = 0;  ///< from one answer to the next
  std::vector<std::int64_t> answered_us;
  std::string refused;     ///< the one line that the controller does not understand
  int swallow_after = -1;  ///< lines after which nothing is answered any more

  explicit YesEnsemble(StageOptions config) : stage(std::move(config)) {
    bench.open();
    run([&] { return stage.safe(); });
  }
  template <class Until>
  void run(Until until) {
    for (int n = 0; n < 20'000 && !until(); ++n) {
      answer();
      if (!until()) bench.advance_to_wake();
    }
    REQUIRE(until());
  }
  void answer() {
    for (std::string line; !(line = bench.take_line()).empty();) {
      line.pop_back();
      log.push_back(line);
      bench.advance_us(line_us);
      answered_us.push_back(bench.now_us);
      if (swallow_after >= 0 && int(log.size()) > swallow_after) continue;
      if (line == refused) {
        bench.feed("!\n");
      } else if (line.starts_with("LINEAR")) {
        for (int a = 0; a < 3; ++a)
          if (const auto n = line.find("@" + std::to_string(a)); n != std::string::npos)
            at[std::size_t(a)] = line.substr(n + 3, line.find(' ', n + 3) - n - 3);
        bench.feed("%\n");
      } else if (line.starts_with("PFBKPROG")) {
        bench.feed("%" + at[std::size_t(line[10] - '0')] + "\n");
      } else if (line.starts_with("PSOARRAY")) {
        pulses = line.substr(line.rfind(',') + 1);
        bench.feed("%\n");
      } else if (line.starts_with("PSOCOUNT")) {
        bench.feed("%" + pulses + "\n");
      } else if (line.starts_with("AXISSTATUS")) {
        bench.feed("%7\n");
      } else if (line.starts_with("GETPARM")) {
        const auto asks = [&](const char* number) { return line.find(number) != std::string::npos; };
        bench.feed(asks(", 37)") ? "%-100\n" : asks(", 38)") ? "%200\n" : "%10000\n");
      } else if (line.find('(') != std::string::npos && line.find('=') == std::string::npos) {
        bench.feed("%0\n");
      } else {
        bench.feed("%\n");
      }
    }
  }
};

}  // namespace firn::drivers::test
