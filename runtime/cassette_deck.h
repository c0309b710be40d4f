// CassetteDeck plays a cassette as the instrument: bytes of the host are looked for on the tape, and the
// instrument's answer comes again, after the same time. The tape is searched from where it stands
// onwards, then from its beginning, so that questions may come oftener or in another order than they did.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "files/cassette.h"

namespace firn {

class CassetteDeck {
 public:
  /// @throws std::invalid_argument: parse_cassette; UsageError: no such file
  explicit CassetteDeck(const std::string& file);
  /// A cassette in memory.
  explicit CassetteDeck(const Cassette& cassette);

  /// The host opens the port: bytes that came unasked after an opening on the tape come again.
  void open(std::int64_t now_us);
  /// The host sends. @returns false: these bytes stand nowhere on the tape, and nothing will answer
  bool send(std::span<const std::byte> bytes, std::int64_t now_us);
  /// When the next bytes come, or the instrument closes the port; INT64_MAX: never.
  std::int64_t due_us() const { return due_.empty() ? INT64_MAX : due_.front().at_us; }
  /// Takes the bytes that are due. @returns false when nothing is; `closed`: the instrument closed the port
  /// instead
  bool take(std::int64_t now_us, std::vector<std::byte>& bytes, bool& closed);

 private:
  struct Answer {
    std::int64_t after_us = 0;
    bool closes = false;
    std::vector<std::byte> bytes;
  };
  struct Exchange {
    bool opening = false;
    std::vector<std::byte> sent;
    std::vector<Answer> answers;
  };
  struct Due {
    std::int64_t at_us = 0;
    const Answer* answer = nullptr;
  };
  void answer(const Exchange& exchange, std::int64_t now_us);

  std::vector<Exchange> tape_;
  std::size_t at_ = 0;  ///< exchange that is looked at first
  std::deque<Due> due_;
};

}  // namespace firn
