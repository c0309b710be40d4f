// channel_filter() makes a program for the kernel that keeps the datagrams of other channels from a socket.
// On one multicast group every process would otherwise wake up for every message of every other one.
#pragma once

#include <linux/filter.h>

#include <set>
#include <string>
#include <vector>

namespace firn {

/// Returns a classic BPF program for SO_ATTACH_FILTER on a UDP socket. It drops a datagram exactly if that is
/// a short message of LCM whose channel is none of `channels`, and has at least kShortestFiltered bytes. All
/// else passes, also damaged datagrams, which LcmBus counts. Returns an empty program if the kernel would
/// take none so long.
/// @param channels of 1 to kMaxChannelBytes bytes each, without NUL
/// @param prefix not empty: channels that begin with it pass too
std::vector<sock_filter> channel_filter(const std::set<std::string, std::less<>>& channels,
                                        const std::string& prefix = {});

/// Bytes of a head and the longest channel: within them the program may look without asking for the length.
inline constexpr unsigned kShortestFiltered = 72;

}  // namespace firn
