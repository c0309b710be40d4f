#include "print/operator/operator_order.h"

#include <algorithm>
#include <iterator>
#include <random>
#include <string_view>

#include "core/options/enumerators.h"
#include "files/usage_error.h"

namespace firn {
namespace {

struct Verb {
  std::string_view word;
  OperatorVerb verb;
};
constexpr Verb kVerbs[] = {
    {"pause", OperatorVerb::kPause},
    {"continue", OperatorVerb::kContinue},
    {"finish-layer", OperatorVerb::kFinishLayer},
    {"stop", OperatorVerb::kStop},
    {"accept-doubt", OperatorVerb::kAcceptDoubt},
    {"set", OperatorVerb::kSet},
};
static_assert(std::size(kVerbs) + 1 == kTableSize<OperatorVerb>);

}  // namespace

std::int64_t new_order_id() {
  std::random_device device;
  const std::uint64_t bits = std::uint64_t(device()) << 32 | device();
  return std::int64_t(bits >> 11) + 1;
}

OperatorOrder parse_order(std::span<const std::string> words) {
  const std::string word = words.empty() ? "" : words.front();
  const auto known = std::ranges::find(kVerbs, std::string_view(word), &Verb::word);
  if (known == std::end(kVerbs)) {
    std::string all;
    for (const Verb& v : kVerbs) all += (all.empty() ? "" : ", ") + std::string(v.word);
    throw UsageError("'" + word.substr(0, 100) + "' is no command of the operator; known are " + all);
  }
  OperatorOrder order{new_order_id(), known->verb, {}, {}};
  const bool sets = order.verb == OperatorVerb::kSet;
  if (words.size() != (sets ? 2 : 1))
    throw UsageError(sets ? "set: one KEY=VALUE is wanted" : word + ": takes no further word");
  if (!sets) return order;
  const std::size_t equals = words[1].find('=');
  if (equals == std::string::npos || equals == 0)
    throw UsageError("set '" + words[1].substr(0, 100) + "': must read KEY=VALUE");
  order.key = words[1].substr(0, equals);
  order.value = words[1].substr(equals + 1);
  return order;
}

std::string to_text(const OperatorOrder& order) {
  const auto known = std::ranges::find(kVerbs, order.verb, &Verb::verb);
  return std::string(known->word) +
         (order.verb == OperatorVerb::kSet ? " " + order.key + "=" + order.value : "");
}

operator_command_t to_message(const OperatorOrder& order, const std::string& from) {
  operator_command_t m{};
  m.command_id = order.id;
  m.verb = std::int8_t(order.verb);
  m.key = order.key;
  m.value = order.value;
  m.text = from;
  return m;
}

OperatorOrder to_order(const operator_command_t& m) {
  return {m.command_id, OperatorVerb(m.verb), m.key, m.value};
}

}  // namespace firn
