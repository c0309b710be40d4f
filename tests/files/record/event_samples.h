// Returns events for the log tests.
#pragma once

#include <algorithm>

#include "files/record/event_log.h"
#include "tests/files/record/scratch.h"

namespace firn::test {

struct Sample {
  std::int64_t utime_us;
  std::string channel;
  Bytes data;
};

inline std::vector<Sample> some_events(std::size_t n, std::size_t longest, std::uint64_t seed,
                                       std::size_t fixed = 0) {
  static const char* const kChannels[] = {"HEIGHT_MAP", "LAYER_PLAN", "STATE_JET", "JETS"};
  Random random{seed};
  std::vector<Sample> samples;
  std::int64_t utime_us = 1'000'000;
  for (std::size_t i = 0; i < n; ++i) {
    utime_us += std::int64_t(random.below(2000));
    samples.push_back({utime_us, fixed ? "JETS" : kChannels[random.below(4)],
                       random_bytes(random, fixed ? fixed : random.below(longest))});
  }
  return samples;
}

inline void write_events(const std::filesystem::path& path, const std::vector<Sample>& samples) {
  record::EventLogWriter writer(path);
  for (const Sample& s : samples) writer.append(s.utime_us, s.channel, s.data);
  writer.close();
}

inline bool same(const record::Event& e, const Sample& s) {
  return e.utime_us == s.utime_us && e.channel == s.channel && std::ranges::equal(e.data, s.data);
}

}  // namespace firn::test
