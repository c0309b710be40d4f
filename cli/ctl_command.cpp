// run_ctl sends one order of the operator to a running print.
#include "cli/commands.h"

#include <fmt/core.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "cli/option_set.h"
#include "cli/user_config.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/interrupt.h"
#include "print/operator/operator_client.h"
#include "runs/folder/address.h"

namespace firn {
namespace {

struct CtlOptions {
  std::string run;                 ///< run folder
  std::vector<std::string> words;  ///< {"pause"}, {"set", "KEY=VALUE"}
  std::int64_t id = 0;             ///< of the order; 0 = a new one
  bool json = false;
};

constexpr double kPatience_s = 10.0;

// Until the print waits, goes on by another order, or is gone. A scan in between may take minutes.
void await_pause(const std::filesystem::path& run) {
  constexpr std::chrono::milliseconds kLook{100};
  constexpr int kLooksBeforeNote = 20;
  const InterruptGuard guard;
  for (int looks = 0; !InterruptGuard::raised() && OperatorClient::state_of(run) == "pausing"; ++looks) {
    if (looks == kLooksBeforeNote)
      fmt::print(stderr, "the pass, path or scan is finished first; Ctrl-C does not take the pause back\n");
    std::this_thread::sleep_for(kLook);
  }
}

/// @returns 0 obeyed, 1 no answer, 2 refused
/// @throws UsageError: an unknown order, a run that is not running
int run_ctl(const CtlOptions& options) {
  using Clock = std::chrono::steady_clock;
  OperatorOrder order = parse_order(options.words);
  if (options.id != 0) order.id = options.id;
  const auto began = Clock::now();
  OperatorClient client(runs::folder_of(options.run));
  client.say("from " + sender_name("firn ctl"));
  client.send(order);
  const auto answer = client.next(kPatience_s);
  const double ms = std::chrono::duration<double, std::milli>(Clock::now() - began).count();
  const std::string again = "; the same order is safe to send again with --id " + std::to_string(order.id);
  if (!answer)
    throw std::runtime_error(
        options.run + (client.closed() ? ": the print ended before it answered" : ": no answer within 10 s") +
        again);
  const bool ok = answer->starts_with("ok ");
  const std::string text = answer->substr(answer->find(' ') + 1);
  if (!ok && !options.json) throw UsageError(options.run + ": " + text);
  if (ok && order.verb == OperatorVerb::kStop) {  // print --resume works when this returns
    const InterruptGuard guard;
    client.await_end(InterruptGuard::raised,
                     [](const std::string& note) { fmt::print(stderr, "{}\n", note); });
  }
  if (ok && order.verb == OperatorVerb::kPause) await_pause(runs::folder_of(options.run));
  if (options.json)
    fmt::print("{}\n",
               nlohmann::ordered_json{
                   {"ok", ok}, {"id", order.id}, {"order", to_text(order)}, {"text", text}, {"ms", ms}}
                   .dump(2));
  else
    fmt::print("{}\n", text);
  return ok ? kOk : kUsage;
}

}  // namespace

void declare_ctl(OptionSet& options) {
  auto& o = options.calls(run_ctl);
  options.option("RUN", o.run, "folder or number of a running print").required();
  options
      .option("ORDER", o.words,
              "pause | continue | finish-layer | stop | accept-doubt | set KEY=VALUE; docs/commands/ctl.md")
      .required();
  options.option("--id", o.id, "number of the order, to send it again: it is obeyed once")
      .within(1.0, 9007199254740992.0);
  options.json_flag(o.json);
}

}  // namespace firn
