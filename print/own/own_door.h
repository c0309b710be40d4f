// OwnDoor takes the messages of the lab's own programs off the bus, refuses bytes that are none, and hands
// the rest on to be published and recorded under the program's name.
#pragma once

#include <poll.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "print/own/own_message.h"
#include "procs/bus/lcm_bus.h"

namespace firn {

/// The messages that have come from one program.
struct OwnCount {
  std::uint64_t taken = 0;
  std::uint64_t refused = 0;
  std::string last_refusal = {};  ///< why the last of them was refused
  double last_s = 0.0;            ///< wall time of the last one taken
};

class OwnDoor {
 public:
  using Take = std::function<void(OwnMessage&&)>;
  using Warn = std::function<void(const std::string& sentence)>;

  static constexpr int kMostPerSecond = 200;     ///< messages of one program; any above are refused
  static constexpr std::uint64_t kWarnings = 3;  ///< of one program; further refusals are only counted

  /// @param key of the run; none on a bus without one
  /// @param warn gets the first refusals of each program
  OwnDoor(const std::string& bus_url, const std::optional<BusKey>& key, Take take, Warn warn);

  /// Returns all that a program needs in order to speak, as one JSON object: bus, channels, key.
  /// @throws UsageError for a name that is none
  std::string admission(std::string_view program, std::int64_t run_id) const;
  /// Takes a message as JSON. @throws UsageError naming the channel, the member and the limit
  void say(std::string_view program, std::string_view channel, std::string_view json);

  int fd() const { return bus_.fd(); }
  /// Takes messages that have arrived; does not block.
  void service();
  const std::map<std::string, OwnCount, std::less<>>& counts() const { return counts_; }
  /// "mine: 40 messages taken, 2 refused (OWN_VALUES: ...), 1 lost"
  std::vector<std::string> summary() const;

 private:
  struct Sender {
    std::uint64_t first = 0, newest = 0, came = 0;
  };
  struct Second {
    std::int64_t number = -1;
    int messages = 0;
  };
  void take(std::string_view program, OwnMessage&& message);
  void take_sealed(std::string_view channel, std::span<const std::byte> sealed);
  void count_number(std::string_view program, const MacNumbers& of);
  bool too_many(std::string_view program);
  void refuse(std::string_view program, const std::string& why);

  LcmBus bus_;
  std::string bus_url_;
  std::optional<BusKey> key_;
  Take take_;
  Warn warn_;
  std::map<std::string, OwnCount, std::less<>> counts_;
  std::map<std::string, std::map<std::uint64_t, Sender>, std::less<>> senders_;
  std::map<std::string, Second, std::less<>> seconds_;
};

}  // namespace firn
