// run_key prints the admission of one of the lab's own programs to a running print.
#include <fmt/core.h>

#include <string>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/own_order.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "runs/folder/address.h"

namespace firn {
namespace {

struct KeyOptions {
  std::string run;  ///< folder or number
  std::string as;   ///< name of the program; empty: the user's
  bool json = false;
};

/// @returns 0 @throws UsageError: a run that is not running, a name that is none
int run_key(const KeyOptions& o) {
  OperatorClient client(runs::folder_of(o.run));
  const auto told = nlohmann::ordered_json::parse(own_order(client, o.run, "key " + own_speaker(o.as)));
  if (o.json) {
    fmt::print("{}\n", told.dump(2));
    return kOk;
  }
  const std::string key = told["key"].get<std::string>();
  fmt::print("bus       {}\n", told["bus"].get<std::string>());
  fmt::print("program   {}\n", told["program"].get<std::string>());
  for (const auto& channel : told["channels"]) fmt::print("channel   {}\n", channel.get<std::string>());
  fmt::print("key       {}\n", key.empty() ? "none: this bus takes messages without one" : key);
  fmt::print(stderr, "The key holds until the print ends or is resumed. Keep it to yourself.\n");
  return kOk;
}

}  // namespace

void declare_key(OptionSet& options) {
  auto& o = options.calls(run_key);
  options.option("RUN", o.run, "folder or number of a running print").required();
  options.option("--as", o.as, "name of the program: 1 to 24 of a-z, 0-9, '_', '-'; default: your account's");
  options.json_flag(o.json);
}

}  // namespace firn
