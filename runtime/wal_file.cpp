#include "runtime/wal_file.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "firn/config_t.hpp"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

std::string where(std::uint64_t step, const Event& event) {
  return "step " + std::to_string(step) + " (" + describe(event) + ")";
}

void each_send(std::span<const std::byte> body,
               const std::function<void(std::string_view, std::span<const std::byte>)>& sink) {
  for (const Output& o : decode_output_list(body))
    if (o.kind == OutputKind::kSend) sink(o.channel, o.bytes);
}

/// The step that was replayed last and waits for its recorded outputs.
struct Replayed {
  WalEvent event;
  std::vector<std::byte> body;
  bool put_out = false;
};

}  // namespace

WalFile::WalFile(const std::filesystem::path& path, bool resume, std::size_t buffer_bytes)
    : writer_(path, resume ? record::RecordWriter::Mode::kAppend : record::RecordWriter::Mode::kCreate,
              buffer_bytes),
      buffered_(buffer_bytes > 0) {}

void WalFile::sync() { buffered_ ? writer_.flush() : writer_.sync(); }

void WalFile::append(WalKind kind, std::span<const std::byte> payload) {
  writer_.append(std::uint16_t(kind), payload);
}

std::string describe(const Event& e) {
  switch (e.kind) {
    case EventKind::kStart:
      return "start of incarnation " + std::to_string(e.incarnation);
    case EventKind::kMessage: {
      const auto header = wire::read_header(e.bytes);
      return std::string(e.channel) + (header ? " seq " + std::to_string(header->seq) : "");
    }
    case EventKind::kWake:
      return "wake-up " + std::to_string(e.id);
    case EventKind::kIo:
      return std::to_string(e.bytes.size()) + " bytes from port " + std::to_string(e.id);
    case EventKind::kLink:
      return "port " + std::to_string(e.id) + (e.link == LinkState::kOpen ? " opened" : " closed");
    case EventKind::kLocalStop:
      return "local stop";
    case EventKind::kRefused:
      return "bytes kept from port " + std::to_string(e.id);
  }
  return "event";
}

std::vector<std::byte> config_message(const WalHead& head) {
  config_t m{};
  m.header.run_id = head.run_id;
  m.header.incarnation = head.incarnation;
  m.header.seq = head.incarnation + 1;
  m.header.utime_us = 0;
  m.node = head.node;
  m.commit = head.commit;
  m.config_toml = head.config_toml;
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

Time restore(NodeHost& host, std::int64_t run_id, WalFile& file, const RestoreSinks& sinks) {
  const record::MappedFile mapped(file.path());
  record::RecordReader reader(mapped.bytes());
  Time last{0};
  std::optional<Replayed> pending;
  const auto settle = [&](bool at_end) {
    if (pending && pending->put_out) {
      if (!at_end)
        fail(file.path(), where(pending->event.step, pending->event.event) +
                              ": the node puts something out, the record has nothing");
      std::vector<std::byte> payload(16);
      for (int k = 0; k < 8; ++k) payload[std::size_t(k)] = std::byte(pending->event.step >> (8 * k));
      payload.insert(payload.end(), pending->body.begin(), pending->body.end());
      file.append(WalKind::kOutputs, payload);
      file.sync();
      each_send(pending->body, sinks.unsent);
    }
    pending.reset();
  };

  const auto known = [&](std::uint64_t step, std::string_view channel) {
    if (!find_channel(channel))
      fail(file.path(), "step " + std::to_string(step) + ": channel '" + std::string(channel.substr(0, 100)) +
                            "' is not in the channel table");
  };

  while (const auto record = reader.next()) {
    if (record->damaged || reader.damage().count() != 0)
      fail(file.path(),
           "byte " + std::to_string(record->offset) + ": damaged, the node cannot be brought back from it");
    switch (WalKind(record->kind)) {
      case WalKind::kHead: {
        const WalHead head = decode_head(record->payload);
        if (head.node != host.name() || head.run_id != run_id)
          fail(file.path(), "is of node " + head.node + " in run " + std::to_string(head.run_id) + ", not " +
                                host.name() + " in run " + std::to_string(run_id));
        sinks.head(head);
        break;
      }
      case WalKind::kEvent: {
        settle(false);
        Replayed now{decode_event(record->payload), {}, false};
        const Event& e = now.event.event;
        if (now.event.step != host.steps())
          fail(file.path(), "step " + std::to_string(now.event.step) + " where step " +
                                std::to_string(host.steps()) + " belongs");
        if (e.kind == EventKind::kMessage) known(now.event.step, e.channel);
        try {
          const Outbox& out = host.replay_step(e);
          now.put_out = !out.empty();
          if (now.put_out) encode_output_list(out, now.body);
        } catch (const std::exception& error) {
          fail(file.path(), where(now.event.step, e) + " crashes the node again: " + error.what());
        }
        if (e.kind == EventKind::kMessage) sinks.received(e.channel, e.bytes);
        last = std::max(last, e.now);
        pending = std::move(now);
        break;
      }
      case WalKind::kOutputs: {
        const WalOutputs recorded = decode_outputs(record->payload);
        if (!pending || recorded.step != pending->event.step)
          fail(file.path(), "outputs of step " + std::to_string(recorded.step) + " without its event");
        if (!std::ranges::equal(recorded.body, pending->body))
          fail(file.path(),
               where(recorded.step, pending->event.event) + ": the outputs differ from the record");
        each_send(recorded.body, sinks.sent);
        pending.reset();
        break;
      }
    }
  }
  settle(true);
  return last;
}

bool find_sent(const std::filesystem::path& path, std::string_view channel, std::int64_t seq,
               std::vector<std::byte>& to) {
  const record::MappedFile mapped(path);
  record::RecordReader reader(mapped.bytes());
  bool found = false;
  while (const auto record = reader.next()) {
    if (record->damaged || record->kind != std::uint16_t(WalKind::kOutputs)) continue;
    each_send(decode_outputs(record->payload).body,
              [&](std::string_view name, std::span<const std::byte> bytes) {
                if (found || name != channel) return;
                const auto header = wire::read_header(bytes);
                if (!header || header->seq != seq) return;
                to.assign(bytes.begin(), bytes.end());
                found = true;
              });
    if (found) return true;
  }
  return false;
}

}  // namespace firn
