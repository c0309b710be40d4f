#include "tests/replay/forge.h"

#include <cstring>
#include <string>

#include "runtime/write_ahead.h"
#include "tests/replay/damage.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;

template <class T>
void put(std::vector<std::byte>& to, T v) {
  const auto* p = reinterpret_cast<const std::byte*>(&v);
  to.insert(to.end(), p, p + sizeof v);
}

void put_bytes(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  put(to, std::uint32_t(bytes.size()));
  to.insert(to.end(), bytes.begin(), bytes.end());
}

void put_output(std::vector<std::byte>& to, const Output& o) {
  put(to, std::uint8_t(o.kind));
  if (o.kind == OutputKind::kSend) {
    put_bytes(to, std::as_bytes(std::span(o.channel)));
    return put_bytes(to, o.bytes);
  }
  put(to, o.id);
  if (o.kind == OutputKind::kArm) put(to, o.at.us);
  if (o.kind == OutputKind::kWrite || o.kind == OutputKind::kFinish) put_bytes(to, o.bytes);
}

// Returns false where the record vanishes.
bool edit_event(RawRecord& r, std::string_view channel, const EditBytes& edit) {
  WalEvent w = decode_event(r.payload);
  if (w.event.kind != EventKind::kMessage || w.event.channel != channel) return true;
  std::vector<std::byte> message(w.event.bytes.begin(), w.event.bytes.end());
  if (!edit(message)) return false;
  const std::string name(w.event.channel);
  w.event.channel = name;
  w.event.bytes = message;
  std::vector<std::byte> payload;
  encode_event(w.step, w.event, payload);
  r.payload = std::move(payload);
  return true;
}

bool edit_outputs(RawRecord& r, std::string_view channel, const EditBytes& edit) {
  const WalOutputs w = decode_outputs(r.payload);
  std::vector<std::byte> payload, list;
  put(payload, w.step);
  put(payload, w.handler_ns);
  std::uint32_t kept = 0;
  for (Output o : decode_output_list(w.body)) {
    std::vector<std::byte> message;
    if (o.kind == OutputKind::kSend && o.channel == channel) {
      message.assign(o.bytes.begin(), o.bytes.end());
      if (!edit(message)) continue;
      o.bytes = message;
    }
    put_output(list, o);
    ++kept;
  }
  put(payload, kept);
  payload.insert(payload.end(), list.begin(), list.end());
  r.payload = std::move(payload);
  return kept > 0;
}

}  // namespace

void edit_messages(const fs::path& run, std::string_view channel, const EditBytes& edit) {
  for (const auto& entry : fs::directory_iterator(run / "nodes")) {
    if (entry.path().extension() != ".wal") continue;
    edit_records(entry.path(), [&](Records& records) {
      std::erase_if(records, [&](RawRecord& r) {
        if (r.kind == std::uint16_t(WalKind::kEvent)) return !edit_event(r, channel, edit);
        return r.kind == std::uint16_t(WalKind::kOutputs) && !edit_outputs(r, channel, edit);
      });
    });
  }
}

void add_messages(const fs::path& run, std::string_view node, const Outbox& sent) {
  edit_records(run / "nodes" / (std::string(node) + ".wal"), [&](Records& records) {
    RawRecord r;
    r.kind = std::uint16_t(WalKind::kOutputs);
    encode_outputs(1'000'000'000, 0, sent, r.payload);
    records.push_back(std::move(r));
  });
}

void edit_world(const fs::path& run, const std::function<void(plant::WorldHistory&)>& edit) {
  plant::WorldHistory h = plant::read_history(run / "world.rec");
  edit(h);
  Records records;
  const auto all = [&](plant::RecordKind kind, const auto& list) {
    for (const auto& item : list) {
      const auto bytes = std::as_bytes(std::span(&item, 1));
      records.push_back({std::uint16_t(kind), {bytes.begin(), bytes.end()}});
    }
  };
  all(plant::RecordKind::kBegin, h.begins);
  all(plant::RecordKind::kShot, h.shots);
  all(plant::RecordKind::kScanTrigger, h.scans);
  all(plant::RecordKind::kLamp, h.lamp);
  all(plant::RecordKind::kLink, h.links);
  all(plant::RecordKind::kDevice, h.devices);
  all(plant::RecordKind::kFiring, h.firings);
  write_records(run / "world.rec", records);
}

}  // namespace firn::test
