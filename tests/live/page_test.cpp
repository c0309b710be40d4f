// The page beside live prints: watched, commanded, attacked, killed.
#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "files/exit_codes.h"
#include "files/json.h"
#include "firn/operator_command_t.hpp"
#include "runs/read/run_reader.h"
#include "tests/live/live_checks.h"
#include "tests/page/page_attack.h"
#include "tests/page/web_client.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using nlohmann::json;

namespace {

void start_with_page(LiveRun& run) {
  run.page_token = "secret";
  run.start(false);
  REQUIRE(run.wait_started());
}

std::string command(int id, const std::string& name, const std::string& key = "",
                    const std::string& value = "") {
  json j{{"type", "command"}, {"id", id}, {"token", "secret"}, {"command", name}};
  if (!key.empty()) j.update({{"key", key}, {"value", value}});
  return j.dump();
}

/// The line that a browser keeps for commands; it needs no token in its frames.
void open_line(WebClient& line) {
  REQUIRE(line.open("/command?run=live", {"Sec-WebSocket-Protocol: firn, secret"}) == 101);
}

json answer_to(WebClient& tab, const std::string& text) {
  tab.send(text);
  return json::parse(tab.next_of("answer", 30.0).value_or("{}"));
}

}  // namespace

TEST_CASE("a live print is watched, paused, changed and continued from the page, and replays identical") {
  if (skipped()) return;
  LiveRun run(tiny_part(71));
  start_with_page(run);
  WebClient tab(run.page_address());
  REQUIRE(tab.open("/ws?run=live") == 101);
  const json hello = json::parse(tab.next_of("hello", 30.0).value_or("{}"));
  CHECK(hello["run"]["live"] == true);
  CHECK(hello["commands"]["allowed"].size() == 6);
  tab.send(R"({"type":"follow","surface":"measured"})");
  CHECK(tab.next_map(30.0));
  CHECK(answer_to(tab, command(1, "pause"))["ok"] == true);
  json state = json::object();
  for (int n = 0; n < 100 && state.value("state", "") != "paused"; ++n)
    state = json::parse(tab.next_of("state", 30.0).value_or("{}"));
  CHECK(state["state"] == "paused");
  CHECK(state["ages"]["link_s"].get<double>() < 10.0);
  CHECK(answer_to(tab, command(2, "set", "control.max_layers", "150"))["ok"] == true);
  CHECK(answer_to(tab, command(6, "set", "control.target_offset_mm", "0.004"))["ok"] == true);
  const json refused = answer_to(tab, command(3, "set", "grid.nx", "5"));
  CHECK(refused["ok"] == false);
  CHECK_THAT(refused["error"].get<std::string>(), Contains("grid.nx"));
  WebClient line(run.page_address());
  open_line(line);
  CHECK(answer_to(line, command(4, "accept_doubt"))["ok"] == true);
  CHECK(answer_to(line, command(5, "continue"))["ok"] == true);
  CHECK(tab.next_of("layer", 30.0));
  CHECK(run.wait_finished() == kOk);
  INFO(run.said());
  std::vector<std::string> from;
  const runs::RunReader messages(run.path());
  messages.each<operator_command_t>(channels::kOperatorCommand.name,
                                    [&](const operator_command_t& m) { from.push_back(m.text); });
  CHECK(from == std::vector<std::string>(5, "page"));
  check_finished_run(run);
}

TEST_CASE("the page's safe stop makes the lab safe, and is answered when it is") {
  if (skipped()) return;
  LiveRun run(tiny_part(72));
  start_with_page(run);
  WebClient line(run.page_address());
  open_line(line);
  ::usleep(500'000);
  const std::int64_t at = monotonic_ns();
  const json answer = answer_to(line, command(1, "safe_stop"));
  CHECK(answer["ok"] == true);
  CHECK(run.wait() == kSafetyStop);
  run.wait_all_gone();
  CHECK_THAT(run.said(), Contains("stopped by the operator"));
  check_safe_after(run, at);
}

TEST_CASE("a print whose page is attacked, stopped and killed finishes and replays identical") {
  if (skipped()) return;
  LiveRun attacked(tiny_part(73));
  start_with_page(attacked);
  const std::string address = attacked.page_address();
  const PageAttack attack(address, {300, 2'000, 20}, 9);
  ::usleep(500'000);
  ::kill(attacked.pid_of("page"), SIGSTOP);
  ::usleep(300'000);
  attacked.kill("page");
  CHECK(attacked.wait_finished() == kOk);
  INFO(attacked.said());
  CHECK_THAT(attacked.said(), Contains("the page was killed by signal 9; the print goes on"));
  check_finished_run(attacked);
}
