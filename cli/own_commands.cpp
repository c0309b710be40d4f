// run_key prints the admission of one of the lab's own programs to a running print; run_say
// publishes messages from standard input for it.
#include <fmt/core.h>
#include <pwd.h>
#include <unistd.h>

#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "config/own_programs.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/operator/operator_client.h"
#include "runs/folder/address.h"

namespace firn {
namespace {

struct KeyOptions {
  std::string run;  ///< folder or number
  std::string as;   ///< name of the program; empty: the user's
  bool json = false;
};

struct SayOptions {
  std::string run, as;
  std::string channel;  ///< "OWN_VALUES"
  bool json = false;
};

constexpr double kAnswerWithin_s = 10.0;

// The name of the account, in the letters that a program's name may have.
std::string user_name() {
  const passwd* const account = ::getpwuid(::geteuid());
  std::string name;
  for (const char* c = account ? account->pw_name : "user"; *c; ++c)
    name += *c >= 'A' && *c <= 'Z' ? char(*c - 'A' + 'a') : *c;
  return is_own_name(name) ? name : "user";
}

/// @returns the words behind "ok" @throws UsageError if the print refuses
std::string ask(OperatorClient& client, const std::string& run, const std::string& order) {
  client.say("own " + order);
  const auto answer = client.next(kAnswerWithin_s);
  if (!answer)
    throw std::runtime_error(
        run + (client.closed() ? ": the print ended before it answered" : ": no answer within 10 s"));
  const std::string words = answer->substr(std::min(answer->size(), answer->find(' ') + 1));
  if (!answer->starts_with("ok ")) throw UsageError(run + ": " + words);
  return words;
}

/// @returns 0 @throws UsageError: a run that is not running, a name that is none
int run_key(const KeyOptions& o) {
  OperatorClient client(runs::folder_of(o.run));
  const auto told =
      nlohmann::ordered_json::parse(ask(client, o.run, "key " + (o.as.empty() ? user_name() : o.as)));
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

/// @returns 0 if every line was taken @throws UsageError naming the line that was refused
int run_say(const SayOptions& o) {
  OperatorClient client(runs::folder_of(o.run));
  const std::string order = "say " + (o.as.empty() ? user_name() : o.as) + " " + o.channel + " ";
  std::uint64_t number = 0, taken = 0;
  for (std::string line; std::getline(std::cin, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      ask(client, o.run, order + line);
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

void declare_key(OptionSet& options) {
  auto& o = options.calls(run_key);
  options.option("RUN", o.run, "folder or number of a running print").required();
  options.option("--as", o.as, "name of the program: 1 to 24 of a-z, 0-9, '_', '-'; default: your account's");
  options.json_flag(o.json);
}

void declare_say(OptionSet& options) {
  auto& o = options.calls(run_say);
  options.option("RUN", o.run, "folder or number of a running print").required();
  options.option("CHANNEL", o.channel, "OWN_VALUES, OWN_HEIGHT_MODEL or OWN_FLOW_MODEL").required();
  options.option("--as", o.as, "name under which it is recorded; default: your account's");
  options.json_flag(o.json);
}

}  // namespace firn
