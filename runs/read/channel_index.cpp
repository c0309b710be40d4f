#include "runs/read/channel_index.h"

namespace firn::runs {
namespace {

std::uint64_t big_endian(std::span<const std::byte> bytes) {
  std::uint64_t v = 0;
  for (std::byte b : bytes) v = v << 8 | std::uint64_t(b);
  return v;
}

}  // namespace

ChannelIndex::ChannelIndex() {
  const auto table = channel_table();
  for (std::size_t n = 0; n < table.size(); ++n) numbers_.emplace(table[n].name, int(n));
}

int ChannelIndex::find(std::string_view name) const {
  const auto it = numbers_.find(name);
  return it == numbers_.end() ? -1 : it->second;
}

bool of_the_runner(const ChannelInfo& channel) {
  for (std::string_view prefix : {"CONFIG_", "HEARTBEAT_", "RESEND_", "JOURNAL_"})
    if (channel.name.starts_with(prefix)) return true;
  return false;
}

bool sent_by_node(const ChannelInfo& channel) {
  return !of_the_runner(channel) && int(channel.publisher) < kReplayedNodeCount;
}

std::optional<Stamp> stamp_of(std::span<const std::byte> m) {
  // 8 bytes of fingerprint, then header_t without one of its own
  if (m.size() < 36) return {};
  return Stamp{std::int64_t(big_endian(m.subspan(8, 8))),
               std::int32_t(std::uint32_t(big_endian(m.subspan(16, 4)))),
               std::int64_t(big_endian(m.subspan(20, 8))), std::int64_t(big_endian(m.subspan(28, 8)))};
}

}  // namespace firn::runs
