#include "runtime/station.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "files/run_paths.h"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

std::filesystem::path sent_path(const ProcessOptions& o) {
  return RunPaths(o.run_dir).sent_path(info(o.node).name);
}

}  // namespace

Station::Station(const ProcessOptions& options, Bus& bus, Transport::Deliver deliver)
    : options_(options),
      bus_(bus),
      clock_(options.epoch_ns, options.offset_us, options.time_scale),
      sent_(sent_path(options), options.incarnation > 0),
      outbox_(options.node, options.run_id),
      transport_({.self = options.node,
                  .run_id = options.run_id,
                  .incarnation = options.incarnation,
                  .burst_bytes = TransportOptions::burst_into(bus.receive_buffer_bytes())},
                 std::move(deliver),
                 [this](std::string_view c, std::int64_t s, std::vector<std::byte>& to) {
                   return find_sent(sent_.path(), c, s, to);
                 }),
      lossy_(options.faults) {
  const record::MappedFile mapped(sent_.path());
  record::RecordReader reader(mapped.bytes());
  while (const auto record = reader.next()) {
    if (record->damaged) continue;
    for (const Output& o : decode_output_list(decode_outputs(record->payload).body)) {
      const auto header = wire::read_header(o.bytes);
      if (!header) continue;
      outbox_.resume_after(o.channel, header->seq);
      transport_.restore_sent(o.channel, o.bytes);
    }
    ++steps_;
  }
}

void Station::join() {
  for (const std::string& channel : transport_.wire_channels()) bus_.subscribe(channel);
  heartbeat_ =
      std::make_unique<Heartbeat>(options_.node, options_.run_id, options_.incarnation, clock_, bus_);
  heartbeat_->update(steps_, transport_.stats(), transport_.last_sent());
}

void Station::send_outbox() {
  std::vector<std::byte> payload;
  encode_outputs(steps_++, 0, outbox_, payload);
  try {
    sent_.append(WalKind::kOutputs, payload);
  } catch (const record::FileError& e) {  // a full disk must not keep a fault from being told
    std::fprintf(stderr, "%s: %s\n", info(options_.node).name.data(), e.what());
  }
  const Output o = outbox_.at(0);
  transport_.send(o.channel, o.bytes, monotonic_us());
  if (heartbeat_) heartbeat_->update(steps_, transport_.stats(), transport_.last_sent());
}

void Station::service() {
  const std::int64_t now = monotonic_us();
  const Lossy::Sink into = [&](std::string_view c, std::span<const std::byte> b) {
    transport_.receive(c, b, now);
  };
  if (options_.faults.any()) {
    bus_.receive([&](std::string_view c, std::span<const std::byte> b) { lossy_.receive(c, b, now, into); });
    lossy_.release(now, into);
  } else {
    bus_.receive(into);
  }
  transport_.tick(now);
  Transport::Datagram d;
  while (transport_.next_datagram(monotonic_us(), d)) bus_.publish(d.channel, d.bytes);
}

std::int64_t Station::due_us() const { return std::min(transport_.due_us(monotonic_us()), lossy_.due_us()); }

}  // namespace firn
