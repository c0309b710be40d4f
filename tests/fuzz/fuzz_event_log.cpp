// Any bytes as an event log and as its index. Input: u32 bytes of the log, the log, the index.
#include <cstring>

#include "files/record/event_log.h"
#include "files/record/log_statistics.h"
#include "tests/fuzz/require.h"

using namespace firn::fuzz;
using namespace firn::record;

namespace {

void read_all(std::span<const std::byte> log, const firn::record::EventIndex* index) {
  firn::record::EventLogReader reader(log, index);
  firn::record::LogStatistics statistics;
  std::uint64_t end = 0, events = 0;
  while (const auto e = reader.next()) {
    require(lies_in(e->data, log), "data lies in the log");
    require(e->offset >= end, "events do not overlap");
    end = e->offset + firn::record::kEventHeaderBytes;
    require(!e->channel.empty(), "an event has a channel");
    require(!(e->checked && e->damaged), "a checked event is not damaged");
    statistics.add(*e);
    ++events;
  }
  std::uint64_t counted = statistics.more_channels();
  for (const auto& [name, channel] : statistics.channels()) {
    counted += channel.messages;
    require(channel.intervals.gaps().count <= channel.intervals.count(), "gaps are intervals");
    require(channel.rate_hz() >= 0, "a rate is not negative");
  }
  require(counted == events, "every event is counted once");
  require(reader.valid_end() <= log.size(), "valid end lies in the log");
  for (const firn::record::Damage& d : reader.damage().list())
    require(d.offset + d.bytes <= log.size(), "damage lies in the log");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return 0;
  std::uint32_t split;
  std::memcpy(&split, data, 4);
  const auto rest = as_bytes(data + 4, size - 4);
  const auto log = rest.first(std::min<std::size_t>(split, rest.size()));
  const firn::record::EventIndex index(rest.subspan(log.size()));
  read_all(log, nullptr);
  read_all(log, &index);
  return 0;
}
