#include "plant/twins/link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/options/enumerators.h"

namespace firn::plant {
namespace {

constexpr std::array<std::string_view, 13> kFaultNames{"drop",   "delay", "split",    "flip", "hang",
                                                       "resume", "close", "reboot",   "trip", "echo",
                                                       "stray",  "power", "half_open"};
static_assert(kFaultNames.size() == kTableSize<FaultKind>);

}  // namespace

FaultKind fault_kind(std::string_view name) {
  std::string known;
  for (std::size_t n = 0; n < kFaultNames.size(); ++n) {
    if (kFaultNames[n] == name) return FaultKind(n);
    known.append(" ").append(kFaultNames[n]);
  }
  throw std::invalid_argument("world: unknown fault \"" + std::string(name) + "\"; known:" + known);
}

std::string_view fault_name(FaultKind kind) { return kFaultNames.at(std::size_t(kind)); }

void TwinLink::connect(std::int64_t now_us) {
  disconnect();
  connected_ = true;
  rx_free_us_ = tx_free_us_ = double(now_us);
}

void TwinLink::disconnect() {
  connected_ = half_open_ = false;
  rx_.clear();
  tx_.clear();
}

void TwinLink::close(std::int64_t now_us) {
  if (!connected_) return;
  disconnect();
  tx_.push_back({now_us, {}, 1});
}

void TwinLink::arrive(std::span<const std::byte> bytes, std::int64_t now_us) {
  if (half_open_) return;
  rx_free_us_ = std::max(rx_free_us_, double(now_us));
  for (const std::byte b : bytes) {
    rx_free_us_ += byte_us_;
    rx_.push_back({std::int64_t(std::ceil(rx_free_us_)), b, {}});
  }
}

std::byte TwinLink::pop_arrival() {
  const std::byte b = rx_.front().byte;
  rx_.pop_front();
  return b;
}

void TwinLink::reply(std::string_view bytes, std::int64_t now_us) {
  if (!connected_ || hung_ || half_open_) return;
  Chunk chunk{0, std::string(bytes), 0};
  std::int64_t extra_us = 0;
  const std::string before =
      std::exchange(last_reply_, chunk.bytes.size() <= 256 ? chunk.bytes : std::string());
  if (!faults_.empty()) {
    const Pending fault = faults_.front();
    if (--faults_.front().count <= 0 || fault.kind == FaultKind::kFlipBit) faults_.erase(faults_.begin());
    if (fault.kind == FaultKind::kDropReply) return;
    if (fault.kind == FaultKind::kDelayReply) extra_us = fault.delay_us;
    if (fault.kind == FaultKind::kFlipBit && !chunk.bytes.empty()) {
      const std::size_t bit = std::size_t(fault.count) % (chunk.bytes.size() * 8);
      chunk.bytes[bit / 8] = char(chunk.bytes[bit / 8] ^ (1 << bit % 8));
    }
    if (fault.kind == FaultKind::kStray && !before.empty()) send(before, now_us, 0);
    if (fault.kind == FaultKind::kSplitReply) {
      for (std::size_t n = 0; n < chunk.bytes.size(); ++n) {
        tx_free_us_ =
            std::max(tx_free_us_, double(now_us + latency_us_)) + std::max(byte_us_, double(fault.delay_us));
        tx_.push_back({std::int64_t(std::ceil(tx_free_us_)), chunk.bytes.substr(n, 1), 0});
      }
      return;
    }
  }
  send(std::move(chunk.bytes), now_us, extra_us);
}

void TwinLink::send(std::string bytes, std::int64_t now_us, std::int64_t extra_us) {
  tx_free_us_ =
      std::max(tx_free_us_, double(now_us + latency_us_ + extra_us)) + byte_us_ * double(bytes.size());
  tx_.push_back({std::int64_t(std::ceil(tx_free_us_)), std::move(bytes), 0});
}

void TwinLink::hear(std::span<const std::byte> bytes, std::int64_t now_us) {
  if (echoes_ == 0 || !connected_ || hung_ || half_open_) return;
  --echoes_;
  send({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, now_us, 0);
}

TwinLink::Chunk TwinLink::pop_send() {
  Chunk chunk = std::move(tx_.front());
  tx_.pop_front();
  return chunk;
}

bool TwinLink::inject(const SimFault& fault, std::int64_t now_us) {
  switch (fault.kind) {
    case FaultKind::kHang:
      hung_ = true;
      return true;
    case FaultKind::kResume:
      hung_ = false;
      return true;
    case FaultKind::kClose:
      close(now_us);
      return true;
    case FaultKind::kHalfOpen:
      if (!connected_) return true;
      half_open_ = true;
      rx_.clear();
      tx_.clear();
      return true;
    case FaultKind::kEcho:
      echoes_ = std::max<std::int64_t>(fault.count, 0);
      return true;
    case FaultKind::kReboot:
    case FaultKind::kTrip:
    case FaultKind::kPower:
      return false;
    default:
      faults_.push_back({fault.kind,
                         {},
                         std::max<std::int64_t>(fault.count, 0),
                         std::max<std::int64_t>(fault.delay_us, 0)});
      return true;
  }
}

void TwinLink::io(Archive& a) {
  a.all(connected_, hung_, half_open_, rx_free_us_, tx_free_us_, rx_, tx_, faults_, echoes_, last_reply_);
}

}  // namespace firn::plant
