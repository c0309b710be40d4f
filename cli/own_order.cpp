#include "cli/own_order.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "config/own_programs.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr double kAnswerWithin_s = 10.0;

}  // namespace

std::string own_speaker(const std::string& as) {
  if (!as.empty()) return as;
  const passwd* const account = ::getpwuid(::geteuid());
  std::string name;
  for (const char* c = account ? account->pw_name : "user"; *c; ++c)
    name += *c >= 'A' && *c <= 'Z' ? char(*c - 'A' + 'a') : *c;
  return is_own_name(name) ? name : "user";
}

std::string own_order(OperatorClient& client, const std::string& run, const std::string& order) {
  client.say("own " + order);
  const auto answer = client.next(kAnswerWithin_s);
  if (!answer)
    throw std::runtime_error(
        run + (client.closed() ? ": the print ended before it answered" : ": no answer within 10 s"));
  const std::string words = answer->substr(std::min(answer->size(), answer->find(' ') + 1));
  if (!answer->starts_with("ok ")) throw UsageError(run + ": " + words);
  return words;
}

}  // namespace firn
