#include "print/own/own_door.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "config/own_programs.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "lcmtypes/utf8.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

void require_name(std::string_view program) {
  if (!is_own_name(program))
    throw UsageError("'" + valid_utf8(program) + "' is no name for a program: it must be " + kOwnNameForm);
}

}  // namespace

OwnDoor::OwnDoor(const std::string& bus_url, const std::optional<BusKey>& key, Take take, Warn warn)
    : bus_(bus_url, key), bus_url_(bus_url), key_(key), take_(std::move(take)), warn_(std::move(warn)) {
  bus_.subscribe_own();
}

std::string OwnDoor::admission(std::string_view program, std::int64_t run_id) const {
  require_name(program);
  const std::string prefix = std::string(kOwnPrefix) + std::string(program) + "/";
  nlohmann::ordered_json channels = nlohmann::ordered_json::array();
  for (const std::string_view name : own_channels()) channels.push_back(prefix + std::string(name));
  return nlohmann::ordered_json{{"bus", bus_url_},
                                {"run_id", run_id},
                                {"program", program},
                                {"key", key_ ? own_key(*key_, program).hex() : ""},
                                {"channels", channels}}
      .dump();
}

void OwnDoor::say(std::string_view program, std::string_view channel, std::string_view json) {
  require_name(program);
  if (too_many(program))
    throw UsageError("more than " + std::to_string(kMostPerSecond) + " messages in a second: not taken");
  try {
    take(program, own_message_from_json(program, channel, json));
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

void OwnDoor::take(std::string_view program, OwnMessage&& message) {
  take_(std::move(message));
  OwnCount& count = counts_[std::string(program)];
  ++count.taken;
  count.last_s = double(monotonic_us()) * 1e-6;
}

void OwnDoor::service() {
  const auto take = [this](std::string_view channel, std::span<const std::byte> bytes) {
    take_sealed(channel, bytes);
  };
  if (key_)
    bus_.receive_sealed(take);
  else
    bus_.receive(take);
}

void OwnDoor::take_sealed(std::string_view channel, std::span<const std::byte> sealed) {
  const std::string_view program = own_program_of(channel);
  if (!is_own_name(program)) return;  // whoever holds the key of such a name did not get it here
  std::span<const std::byte> message = sealed;
  if (key_) {
    message = sealed.first(sealed.size() - kMacTrailerBytes);
    count_number(program, mac_numbers(sealed.last<kMacTrailerBytes>()));
  }
  try {
    if (too_many(program))
      throw std::invalid_argument("more than " + std::to_string(kMostPerSecond) + " messages in a second");
    take(program, own_message(program, channel.substr(kOwnPrefix.size() + program.size() + 1), message));
  } catch (const std::invalid_argument& e) {
    return refuse(program, e.what());
  }
}

// Of messages that overtake each other none is lost: the count is made up at the end.
void OwnDoor::count_number(std::string_view program, const MacNumbers& of) {
  Sender& s = senders_[std::string(program)][of.sender];
  const std::uint64_t number = of.number;
  if (s.came++ == 0) s.first = number;
  s.first = std::min(s.first, number);
  s.newest = std::max(s.newest, number);
}

bool OwnDoor::too_many(std::string_view program) {
  Second& s = seconds_[std::string(program)];
  const std::int64_t now = monotonic_us() / 1'000'000;
  if (s.number != now) s = {now, 0};
  return ++s.messages > kMostPerSecond;
}

void OwnDoor::refuse(std::string_view program, const std::string& why) {
  OwnCount& count = counts_[std::string(program)];
  count.last_refusal = why;
  if (++count.refused > kWarnings) return;
  warn_(std::string(program) + ": a message was refused: " + why +
        (count.refused == kWarnings ? "; further ones are counted" : ""));
}

std::vector<std::string> OwnDoor::summary() const {
  std::vector<std::string> lines;
  for (const auto& [program, count] : counts_) {
    std::uint64_t lost = 0;
    if (const auto senders = senders_.find(program); senders != senders_.end())
      for (const auto& [_, s] : senders->second) lost += s.newest - s.first + 1 - s.came;
    lines.push_back(program + ": " + std::to_string(count.taken) +
                    (count.taken == 1 ? " message taken" : " messages taken") +
                    (count.refused > 0 ? ", " + std::to_string(count.refused) +
                                             " refused (the last: " + count.last_refusal + ")"
                                       : "") +
                    (lost > 0 ? ", " + std::to_string(lost) + " lost on the way" : ""));
  }
  return lines;
}

}  // namespace firn
