#include "files/record/log_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace firn::record {
namespace {

// No time stamp overflows a difference, nor its negative.
std::int64_t difference(std::int64_t a, std::int64_t b) {
  std::int64_t d = 0;
  if (__builtin_sub_overflow(a, b, &d)) return a > b ? INT64_MAX : -INT64_MAX;
  return std::max(d, -INT64_MAX);
}

void add_step(TimeSteps& steps, std::int64_t us, const Event& e) {
  if (us >= 0) return;
  ++steps.back;
  if (-us <= steps.largest_us) return;
  steps.largest_us = -us;
  steps.largest_event = e.eventnum;
  steps.largest_offset = e.offset;
}

}  // namespace

// Each octave has kPerOctave buckets of equal width.
std::size_t Intervals::bucket(std::int64_t us) {
  const auto v = std::uint64_t(us);
  if (v < kPerOctave) return std::size_t(v);
  const int octave = int(std::bit_width(v)) - std::bit_width(unsigned(kPerOctave));
  return std::size_t(octave + 1) * kPerOctave + std::size_t((v >> octave) - kPerOctave);
}

double Intervals::lower_us(std::size_t bucket) {
  if (bucket < kPerOctave) return double(bucket);
  const std::size_t octave = bucket / kPerOctave - 1;
  return std::ldexp(double(kPerOctave + bucket % kPerOctave), int(octave));
}

void Intervals::add(std::int64_t us, std::int64_t begin_us) {
  ++count_;
  ++histogram_[bucket(us)];
  if (us <= longest_us_) return;
  longest_us_ = us;
  longest_begin_us_ = begin_us;
}

std::uint64_t Intervals::count_from(double limit_us) const {
  std::uint64_t n = 0;
  for (std::size_t b = histogram_.size(); b-- > 0 && lower_us(b) >= limit_us;) n += histogram_[b];
  return n;
}

double Intervals::median_from(double limit_us) const {
  const std::uint64_t all = count_from(limit_us);
  std::uint64_t below = 0;
  for (std::size_t b = 0; b < histogram_.size(); ++b) {
    if (lower_us(b) < limit_us) continue;
    below += histogram_[b];
    if (2 * below >= all && all > 0) return b < kPerOctave ? double(b) : (lower_us(b) + lower_us(b + 1)) / 2;
  }
  return 0;
}

double Intervals::time_from_us(double limit_us) const {
  double sum = 0.0;
  for (std::size_t b = 0; b < histogram_.size(); ++b)
    if (histogram_[b] > 0 && lower_us(b) >= limit_us) sum += double(histogram_[b]) * lower_us(b);
  return sum;
}

double Intervals::usual_us() const {
  double usual = median_us();
  for (;;) {
    const double pause = kGapFactor * std::max(usual, 1.0);
    if (count_from(pause) < kFewestPauses || time_from_us(pause) < 0.5 * time_from_us(0.0)) return usual;
    usual = median_from(pause);
  }
}

Intervals::Gaps Intervals::gaps() const {
  const double limit = kGapFactor * std::max(usual_us(), 1.0);
  Gaps found{count_from(limit), limit};
  for (std::size_t b = 0; b < histogram_.size(); ++b)
    if (lower_us(b) >= limit) {
      found.at_least_us = lower_us(b);
      break;
    }
  return found;
}

double ChannelStatistics::rate_hz() const {
  const double span_s = (double(last_us) - double(first_us)) * 1e-6;
  return messages > 1 && span_s > 0 ? double(messages - 1) / span_s : 0;
}

void LogStatistics::add(const Event& e) {
  if (events_ == 0) first_us_ = last_us_ = before_us_ = e.utime_us;
  ++events_;
  data_bytes_ += e.data.size();
  first_us_ = std::min(first_us_, e.utime_us);
  last_us_ = std::max(last_us_, e.utime_us);
  add_step(steps_, difference(e.utime_us, before_us_), e);
  before_us_ = e.utime_us;

  auto it = channels_.find(e.channel);
  if (it == channels_.end()) {
    if (channels_.size() >= kMaxChannels) {
      ++more_channels_;
      return;
    }
    it = channels_.emplace(e.channel, ChannelStatistics{}).first;
  }
  ChannelStatistics& c = it->second;
  const std::uint64_t size = e.data.size();
  if (c.messages == 0) {
    c.first_us = c.last_us = e.utime_us;
    c.smallest = c.largest = size;
  } else {
    const std::int64_t us = difference(e.utime_us, c.before_us_);
    add_step(c.steps, us, e);
    if (us >= 0) c.intervals.add(us, c.before_us_);
  }
  c.before_us_ = e.utime_us;
  ++c.messages;
  c.damaged += e.damaged;
  c.bytes += size;
  c.smallest = std::min(c.smallest, size);
  c.largest = std::max(c.largest, size);
  c.first_us = std::min(c.first_us, e.utime_us);
  c.last_us = std::max(c.last_us, e.utime_us);
  if (size < 8) {
    if (c.too_short++ == 0) c.first_short = e.data;
    return;
  }
  const std::int64_t fingerprint = std::int64_t(big64(e.data.data()));
  auto found = c.fingerprints.find(fingerprint);
  if (found == c.fingerprints.end()) {
    if (c.fingerprints.size() >= ChannelStatistics::kMaxFingerprints) {
      ++c.more_fingerprints;
      return;
    }
    found = c.fingerprints.emplace(fingerprint, FingerprintCount{0, e.data}).first;
  }
  ++found->second.messages;
}

}  // namespace firn::record
