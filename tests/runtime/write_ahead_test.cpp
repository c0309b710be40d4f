#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "firn/enable_t.hpp"
#include "runtime/write_ahead.h"

namespace firn {
namespace {

std::vector<std::byte> random_bytes(RandomStream& r, std::size_t n) {
  std::vector<std::byte> b(n);
  for (auto& x : b) x = std::byte(r.below(256));
  return b;
}

TEST_CASE("an event reads back from its write-ahead record as it was") {
  RandomStream r(1, Purpose::kTest);
  for (int n = 0; n < 500; ++n) {
    const auto bytes = random_bytes(r, r.below(300));
    Event e;
    e.kind = EventKind(1 + r.below(6));
    e.now = Time{std::int64_t(r.bits())};
    if (e.kind == EventKind::kStart) e.incarnation = std::int32_t(r.below(100));
    if (e.kind == EventKind::kMessage) e.channel = "HEIGHT_MAP";
    if (e.kind == EventKind::kWake || e.kind == EventKind::kIo || e.kind == EventKind::kLink)
      e.id = r.below(1000);
    if (e.kind == EventKind::kWake) e.due = Time{std::int64_t(r.bits())};
    if (e.kind == EventKind::kLink) e.link = LinkState(r.below(2));
    if (e.kind == EventKind::kMessage || e.kind == EventKind::kIo || e.kind == EventKind::kLocalStop)
      e.bytes = bytes;
    std::vector<std::byte> record;
    encode_event(77, e, record);
    const WalEvent back = decode_event(record);
    REQUIRE(back.step == 77);
    REQUIRE(back.event.kind == e.kind);
    REQUIRE(back.event.now == e.now);
    REQUIRE(back.event.incarnation == e.incarnation);
    REQUIRE(back.event.channel == e.channel);
    REQUIRE(back.event.id == e.id);
    REQUIRE(back.event.due == e.due);
    REQUIRE(back.event.link == e.link);
    REQUIRE(std::equal(back.event.bytes.begin(), back.event.bytes.end(), e.bytes.begin(), e.bytes.end()));
  }
}

TEST_CASE("outputs read back in the order in which the node put them out") {
  Outbox out(NodeId::kSafety, 5);
  out.begin(Time{123}, 2);
  enable_t lease{};
  lease.enable_epoch = 9;
  out.send(channels::kEnable, lease);
  out.wake_at(TimerId{3}, Time{456});
  out.cancel(TimerId{4});
  out.finish(3, "because");
  std::vector<std::byte> record;
  encode_outputs(8, 1234, out, record);
  const WalOutputs w = decode_outputs(record);
  REQUIRE(w.step == 8);
  REQUIRE(w.handler_ns == 1234);
  const auto list = decode_output_list(w.body);
  REQUIRE(list.size() == 4);
  REQUIRE(list[0].kind == OutputKind::kSend);
  REQUIRE(list[0].channel == "ENABLE");
  enable_t back{};
  REQUIRE(back.decode(list[0].bytes.data(), 0, int(list[0].bytes.size())) > 0);
  REQUIRE(back.header.run_id == 5);
  REQUIRE(back.header.incarnation == 2);
  REQUIRE(back.header.seq == 1);
  REQUIRE(back.header.utime_us == 123);
  REQUIRE(list[1].at == Time{456});
  REQUIRE(list[2].id == 4);
  REQUIRE(list[3].id == 3);
  REQUIRE(std::string(reinterpret_cast<const char*>(list[3].bytes.data()), list[3].bytes.size()) ==
          "because");
}

TEST_CASE("cut or random records are refused with the byte, never read past their end") {
  RandomStream r(2, Purpose::kTest);
  Event e;
  e.kind = EventKind::kMessage;
  e.channel = "LAYER_PLAN";
  const auto bytes = random_bytes(r, 40);
  e.bytes = bytes;
  std::vector<std::byte> record;
  encode_event(1, e, record);
  for (std::size_t cut = 0; cut < record.size(); ++cut) {
    const std::vector<std::byte> part(record.begin(), record.begin() + std::ptrdiff_t(cut));
    REQUIRE_THROWS_WITH(decode_event(part), Catch::Contains("byte"));
  }
  for (int n = 0; n < 3000; ++n) {
    const auto noise = random_bytes(r, r.below(80));
    try {
      decode_event(noise);
      decode_output_list(noise);
    } catch (const std::runtime_error&) {
    }
    try {
      decode_head(noise);
    } catch (const std::runtime_error&) {
    }
  }
}

TEST_CASE("a link state that is neither open nor closed is refused with its byte") {
  Event e;
  e.kind = EventKind::kLink;
  e.link = LinkState::kOpen;
  std::vector<std::byte> record;
  encode_event(1, e, record);
  REQUIRE(decode_event(record).event.link == LinkState::kOpen);
  record.back() = std::byte{2};
  REQUIRE_THROWS_WITH(decode_event(record), Catch::Contains("byte " + std::to_string(record.size() - 1)));
}

TEST_CASE("an incarnation that no header can hold is refused with its byte, in a head and in a start") {
  for (const std::int32_t wrong : {-1, kLastIncarnation + 1, std::numeric_limits<std::int32_t>::max(),
                                   std::numeric_limits<std::int32_t>::min()}) {
    WalHead head;
    head.node = "jet";
    head.incarnation = wrong;
    std::vector<std::byte> record;
    encode_head(head, record);
    REQUIRE_THROWS_WITH(decode_head(record),
                        Catch::Contains("byte 15: incarnation " + std::to_string(wrong) + " "));
    Event start;
    start.incarnation = wrong;
    record.clear();
    encode_event(1, start, record);
    REQUIRE_THROWS_WITH(decode_event(record),
                        Catch::Contains("byte 17: incarnation " + std::to_string(wrong) + " "));
  }
  WalHead head;
  head.incarnation = kLastIncarnation;
  std::vector<std::byte> record;
  encode_head(head, record);
  REQUIRE(decode_head(record).incarnation == kLastIncarnation);
}

TEST_CASE("a head reads back whole: configuration, commit, types and inputs") {
  WalHead h;
  h.node = "controller";
  h.run_id = 99;
  h.incarnation = 3;
  h.commit = "abc";
  h.platform = "glibc";
  h.config_toml = "[grid]\nnx = 4\n";
  h.type_texts = "package firn;";
  h.blobs = {{"target", "00ff"}, {"mask", "11ee"}};
  std::vector<std::byte> bytes;
  encode_head(h, bytes);
  const WalHead b = decode_head(bytes);
  REQUIRE(b.node == h.node);
  REQUIRE(b.run_id == h.run_id);
  REQUIRE(b.incarnation == h.incarnation);
  REQUIRE(b.commit == h.commit);
  REQUIRE(b.platform == h.platform);
  REQUIRE(b.config_toml == h.config_toml);
  REQUIRE(b.type_texts == h.type_texts);
  REQUIRE(b.blobs == h.blobs);
}

}  // namespace
}  // namespace firn
