#include "cli/ctl_command.h"

#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "cli/option_set.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"
#include "print/operator/operator_client.h"

namespace firn {
namespace {

constexpr double kPatience_s = 10.0;

}  // namespace

int run_ctl(const CtlOptions& options) {
  using Clock = std::chrono::steady_clock;
  OperatorOrder order = parse_order(options.words);
  if (options.id != 0) order.id = options.id;
  const auto began = Clock::now();
  OperatorClient client(options.run);
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
  if (options.json)
    fmt::print("{}\n",
               nlohmann::ordered_json{
                   {"ok", ok}, {"id", order.id}, {"order", to_text(order)}, {"text", text}, {"ms", ms}}
                   .dump(2));
  else
    fmt::print("{}\n", text);
  return ok ? kOk : kUsage;
}

void declare_ctl(OptionSet& options) {
  auto& o = options.calls(run_ctl);
  options.option("RUN", o.run, "folder of a running print").required();
  options
      .option("ORDER", o.words,
              "pause | continue | finish-layer | stop | accept-doubt | set KEY=VALUE; docs/commands/ctl.md")
      .required();
  options.option("--id", o.id, "number of the order, to send it again: it is obeyed once")
      .within(1.0, 9007199254740992.0);
  options.json_flag(o.json);
}

}  // namespace firn
