// run_say publishes messages from standard input in a running print, for a program of the lab's own.
#include <fmt/core.h>

#include <cstdint>
#include <iostream>
#include <string>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/own_order.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "runs/folder/address.h"

namespace firn {
namespace {

struct SayOptions {
  std::string run;      ///< folder or number
  std::string channel;  ///< "OWN_VALUES"
  std::string as;       ///< name of the program; empty: the user's
  bool json = false;
};

/// @returns 0 if every line was taken @throws UsageError naming the line that was refused
int run_say(const SayOptions& o) {
  OperatorClient client(runs::folder_of(o.run));
  const std::string order = "say " + own_speaker(o.as) + " " + o.channel + " ";
  std::uint64_t number = 0, taken = 0;
  for (std::string line; std::getline(std::cin, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      own_order(client, o.run, order + line);
    } catch (const UsageError& e) {
      throw UsageError(fmt::format("standard input, line {}: {} ({} taken before)", number, e.what(), taken));
    }
    ++taken;
  }
  if (o.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"channel", o.channel}, {"taken", taken}}.dump(2));
  else
    fmt::print("{} {} taken\n", taken, taken == 1 ? "message" : "messages");
  return kOk;
}

}  // namespace

void declare_say(OptionSet& options) {
  auto& o = options.calls(run_say);
  options.option("RUN", o.run, "folder or number of a running print").required();
  options.option("CHANNEL", o.channel, "OWN_VALUES, OWN_HEIGHT_MODEL or OWN_FLOW_MODEL").required();
  options.option("--as", o.as, "name under which it is recorded; default: your account's");
  options.json_flag(o.json);
}

}  // namespace firn
