// LogStatistics computes what is in an event log: channels, fingerprints, rates, gaps and the order of times,
// in memory that does not grow with the log. It is independent of the types of messages.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "files/record/event_log.h"

namespace firn::record {

/// Time stamps that go back from one event to the next.
struct TimeSteps {
  std::uint64_t back = 0;           ///< how often
  std::int64_t largest_us = 0;      ///< the farthest step back
  std::uint64_t largest_event = 0;  ///< where
  std::uint64_t largest_offset = 0;
};

/// Time between messages of one channel, as they follow in the log.
class Intervals {
 public:
  void add(std::int64_t us, std::int64_t begin_us);
  std::uint64_t count() const { return count_; }
  /// Returns the median to 6 %; 0 without intervals.
  double median_us() const { return median_from(0.0); }
  /// Returns the median of the intervals between bursts where messages come in bursts, else of all. Messages
  /// come in bursts where intervals of kGapFactor medians or more are kFewestPauses or more and take half of
  /// the time.
  double usual_us() const;
  std::int64_t longest_us() const { return longest_us_; }
  std::int64_t longest_begin_us() const { return longest_begin_us_; }
  /// Holds the intervals that are kGapFactor times the usual one, or longer.
  struct Gaps {
    std::uint64_t count = 0;
    double at_least_us = 0;
  };
  static constexpr double kGapFactor = 10;
  static constexpr std::uint64_t kFewestPauses = 8;
  Gaps gaps() const;

 private:
  static constexpr int kPerOctave = 8;
  static std::size_t bucket(std::int64_t us);
  static double lower_us(std::size_t bucket);
  // Of the intervals of limit_us or more.
  std::uint64_t count_from(double limit_us) const;
  double median_from(double limit_us) const;
  double time_from_us(double limit_us) const;

  std::array<std::uint64_t, 64 * kPerOctave> histogram_{};
  std::uint64_t count_ = 0;
  std::int64_t longest_us_ = -1, longest_begin_us_ = 0;
};

/// Messages of one channel that begin with the same eight bytes.
struct FingerprintCount {
  std::uint64_t messages = 0;
  std::span<const std::byte> first;  ///< the first of them, in the log
};

struct ChannelStatistics {
  std::uint64_t messages = 0, bytes = 0, damaged = 0;
  std::uint64_t smallest = 0, largest = 0;  ///< bytes of one message
  std::int64_t first_us = 0, last_us = 0;   ///< the earliest and the latest
  std::map<std::int64_t, FingerprintCount> fingerprints;
  std::uint64_t more_fingerprints = 0;  ///< messages beyond kMaxFingerprints different ones
  std::uint64_t too_short = 0;          ///< messages of fewer than eight bytes
  std::span<const std::byte> first_short;
  TimeSteps steps;
  Intervals intervals;

  static constexpr std::size_t kMaxFingerprints = 64;
  double rate_hz() const;  ///< 0: fewer than two messages, or no time between them

 private:
  friend class LogStatistics;
  std::int64_t before_us_ = 0;
};

class LogStatistics {
 public:
  static constexpr std::size_t kMaxChannels = 4096;

  /// The event's bytes must outlive the statistics.
  void add(const Event& event);

  const std::map<std::string, ChannelStatistics, std::less<>>& channels() const { return channels_; }
  std::uint64_t more_channels() const { return more_channels_; }  ///< events beyond kMaxChannels channels
  std::uint64_t events() const { return events_; }
  std::uint64_t data_bytes() const { return data_bytes_; }
  std::int64_t first_us() const { return first_us_; }
  std::int64_t last_us() const { return last_us_; }
  const TimeSteps& steps() const { return steps_; }

 private:
  std::map<std::string, ChannelStatistics, std::less<>> channels_;
  std::uint64_t more_channels_ = 0, events_ = 0, data_bytes_ = 0;
  std::int64_t first_us_ = 0, last_us_ = 0, before_us_ = 0;
  TimeSteps steps_;
};

}  // namespace firn::record
