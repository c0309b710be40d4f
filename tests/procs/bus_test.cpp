// The bus under attack: datagrams that are none of ours, sent to the group and to this host.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "core/grid/random.h"
#include "print/process/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "procs/bus/message_mac.h"
#include "runtime/control_line.h"
#include "runtime/run_clock.h"
#include "tests/procs/foreigner.h"

using namespace firn;
using namespace firn::test;

namespace {

std::string text(std::span<const std::byte> b) { return {reinterpret_cast<const char*>(b.data()), b.size()}; }

struct Bench {
  int port = free_bus_port(monotonic_ns());
  LcmBus bus;
  Foreigner foreigner{port};
  std::vector<std::pair<std::string, std::string>> heard;

  explicit Bench(const std::optional<BusKey>& key = {})
      : bus(default_bus_url(port) + (key ? "" : "&key=none"), key) {
    bus.subscribe("MAP");
  }
  /// Publishes a mark and receives until it comes back.
  void drain() {
    bus.subscribe("MARK");
    const std::byte mark{1};
    bus.publish("MARK", {&mark, 1});
    bool back = false;
    for (int n = 0; n < 200 && !back; ++n) {
      pollfd p{bus.fd(), POLLIN, 0};
      ::poll(&p, 1, 50);
      bus.receive([&](std::string_view channel, std::span<const std::byte> b) {
        if (channel == "MARK")
          back = true;
        else
          heard.emplace_back(channel, text(b));
      });
    }
    REQUIRE(back);
  }
};

}  // namespace

TEST_CASE(
    "a message of LCM's protocol arrives whole, an unsubscribed one does not, and an empty payload is one") {
  Bench b;
  b.foreigner.to_group(short_message("MAP", "bytes"));
  b.foreigner.to_group(short_message("OTHER", "bytes"));
  b.foreigner.to_group(short_message("MAP", ""));
  b.drain();
  CHECK(b.heard == std::vector<std::pair<std::string, std::string>>{{"MAP", "bytes"}, {"MAP", ""}});
  CHECK(b.bus.dropped_text().empty());
}

TEST_CASE("fragments whose offset wraps or whose channel has no end are dropped and counted") {
  Bench b;
  b.foreigner.to_group(fragment(100, 0, 0, 2, std::string("MAP\0abc", 7)));
  b.foreigner.to_group(fragment(100, 0xfffffff0u, 1, 2, std::string(64, 'x')));
  b.foreigner.to_group(fragment(4, 0, 0, 1, "no end here"));
  b.foreigner.to_group(fragment(0xffffffffu, 0xffffffffu, 65535, 65535, ""));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kFragment) == 4);
}

TEST_CASE("short packets without an end of their channel, with too long a channel or none are dropped") {
  Bench b;
  Bytes no_end = short_message("MAP", "");
  no_end.pop_back();
  b.foreigner.to_group(no_end);
  b.foreigner.to_group(short_message(std::string(64, 'M'), "x"));
  b.foreigner.to_group(short_message("", "x"));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kChannel) == 3);
}

TEST_CASE("whatever is no LCM is dropped, whatever its length") {
  Bench b;
  for (std::size_t n = 0; n < 10; ++n) b.foreigner.to_group(Bytes(n, std::byte{0x4c}));
  b.foreigner.to_group(Bytes(500, std::byte{0xff}));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kShort) == 10);
  CHECK(b.bus.dropped(PacketFault::kForeign) == 1);
  CHECK(b.bus.dropped_text() == "11 foreign datagrams dropped (10 too short, 1 not LCM)");
}

TEST_CASE(
    "a datagram to an address of this host is not heard, and one to the group by another interface neither") {
  Bench b;
  b.foreigner.to_this_host(short_message("MAP", "to the host"));
  b.foreigner.to_this_host(fragment(100, 0xfffffff0u, 1, 2, "x"));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kFragment) == 0);
}

TEST_CASE("random datagrams are read within their bounds, and what is a message is read as it was written") {
  RandomStream random(11, Purpose::kTest);
  int whole = 0;
  for (int n = 0; n < 20000; ++n) {
    const std::string channel(random.below(70), char('A' + random.below(26)));
    const std::string payload(random.below(40), 'p');
    Bytes b = short_message(channel, payload);
    if (random.below(2))
      for (std::uint32_t k = 1 + random.below(3); k > 0; --k)
        b[random.below(std::uint32_t(b.size()))] = std::byte(random.below(256));
    if (random.below(3) == 0) b.resize(random.below(std::uint32_t(b.size() + 1)));
    const Bytes exact(b.begin(), b.end());  // so that a sanitizer sees a read beyond it
    const LcmPacket p = read_packet(exact);
    if (p.fault != PacketFault::kNone) continue;
    ++whole;
    REQUIRE(p.channel.size() >= 1);
    REQUIRE(p.channel.size() <= 63);
    REQUIRE(8 + p.channel.size() + 1 + p.payload.size() == exact.size());
  }
  CHECK(whole > 4000);
}

TEST_CASE("the address of a bus is checked, and a datagram that would leave the host is refused") {
  for (const char* bad :
       {"udp://239.255.76.67:7667", "udpm://239.255.76.67", "udpm://10.0.0.1:7667", "udpm://239.255.76.67:0",
        "udpm://239.255.76.67:7667?ttl=1", "udpm://239.255.76.67:7667?fifo=3"})
    CHECK_THROWS_WITH(LcmBus(bad), Catch::Contains(bad) && Catch::Contains("firn doctor"));
}

TEST_CASE("a message longer than a datagram of LCM is not sent as fragments but refused") {
  Bench b;
  CHECK_THROWS_AS(b.bus.publish("MAP", Bytes(65499 - 3)), std::logic_error);
  b.bus.publish("MAP", Bytes(65499 - 4));
  b.drain();
  REQUIRE(b.heard.size() == 1);
  CHECK(b.heard[0].second.size() == 65495);
}

namespace {

using Heard = std::vector<std::pair<std::string, std::string>>;

/// A bus with a key, and a program that reads all its datagrams as they are.
struct KeyedBench : Bench {
  LcmBus listener{default_bus_url(port) + "&key=none"};

  KeyedBench() : Bench(BusKey::random()) {
    listener.subscribe("MAP");
    listener.subscribe("SAFE_STOP");
    bus.subscribe("SAFE_STOP");
  }
  /// Publishes by the bus; the payload as it travelled.
  std::string publish(const char* channel, std::string_view message) {
    bus.publish(channel, std::as_bytes(std::span(message)));
    std::string seen;
    for (int n = 0; n < 200 && seen.empty(); ++n) {
      pollfd p{listener.fd(), POLLIN, 0};
      ::poll(&p, 1, 50);
      listener.receive([&](std::string_view, std::span<const std::byte> b) { seen = text(b); });
    }
    return seen;
  }
};

}  // namespace

TEST_CASE(
    "an authenticated message arrives as it was sent, and travels with a trailer of 32 bytes behind it") {
  KeyedBench b;
  const std::string travelled = b.publish("MAP", "bytes");
  CHECK(travelled.size() == 5 + kMacTrailerBytes);
  CHECK(travelled.starts_with("bytes"));
  b.drain();
  CHECK(b.heard == Heard{{"MAP", "bytes"}});
  CHECK(b.bus.dropped_text().empty());
}

TEST_CASE("what a program without the key sends is dropped and counted, with a trailer or without") {
  KeyedBench b;
  b.foreigner.to_group(short_message("MAP", "bytes"));
  b.foreigner.to_group(short_message("MAP", ""));
  b.foreigner.to_group(short_message("MAP", std::string(500, 'x')));
  b.foreigner.to_group(short_message("SAFE_STOP", std::string(kMacTrailerBytes, '\0')));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped_text() == "4 foreign datagrams dropped (4 without the key of the run)");
}

TEST_CASE("a datagram that is sent again, at once or after others, is taken once") {
  KeyedBench b;
  const std::string first = b.publish("MAP", "1");
  b.foreigner.to_group(short_message("MAP", first));
  for (int n = 0; n < 200; ++n) b.publish("MAP", "2");
  b.foreigner.to_group(short_message("MAP", first));
  b.drain();
  CHECK(std::ranges::count(b.heard, std::pair<std::string, std::string>{"MAP", "1"}) == 1);
  CHECK(b.bus.dropped(PacketFault::kRepeated) == 2);
}

TEST_CASE("a datagram that is sent again by another channel is dropped") {
  KeyedBench b;
  const std::string authenticated = b.publish("MAP", "bytes");
  b.foreigner.to_group(short_message("SAFE_STOP", authenticated));
  b.drain();
  CHECK(b.heard == Heard{{"MAP", "bytes"}});
  CHECK(b.bus.dropped(PacketFault::kForged) == 1);
}

TEST_CASE("a datagram of an earlier start of the run, which had another key, is dropped") {
  KeyedBench b;
  const std::string authenticated = b.publish("MAP", "bytes");
  LcmBus resumed(default_bus_url(b.port), BusKey::random());
  resumed.subscribe("MAP");
  b.foreigner.to_group(short_message("MAP", authenticated));
  pollfd p{resumed.fd(), POLLIN, 0};
  REQUIRE(::poll(&p, 1, 5000) == 1);
  int taken = 0;
  resumed.receive([&](std::string_view, std::span<const std::byte>) { ++taken; });
  CHECK(taken == 0);
  CHECK(resumed.dropped(PacketFault::kForged) == 1);
}

TEST_CASE("an authenticated message with any bit turned, any byte lacking or one more is forged") {
  const BusKey key = BusKey::random();
  MessageMac mac(key);
  MacVerifier check(key);
  RandomStream random(5, Purpose::kTest);
  for (int n = 0; n < 30; ++n) {
    Bytes authenticated(random.below(200));
    for (std::byte& b : authenticated) b = std::byte(random.below(256));
    std::byte trailer[kMacTrailerBytes];
    mac.write("MAP", authenticated, trailer);
    authenticated.insert(authenticated.end(), trailer, trailer + kMacTrailerBytes);
    const auto opened = [&](Bytes bytes) {
      std::span<const std::byte> view(bytes);
      return check.open("MAP", view);
    };
    for (std::size_t bit = 0; bit < 8 * authenticated.size(); ++bit) {
      Bytes turned = authenticated;
      turned[bit / 8] ^= std::byte(1 << bit % 8);
      REQUIRE(opened(turned) == MacFault::kForged);
    }
    for (std::size_t size = 0; size < authenticated.size(); ++size)
      REQUIRE(opened({authenticated.begin(), authenticated.begin() + long(size)}) == MacFault::kForged);
    Bytes longer = authenticated;
    longer.push_back(std::byte{0});
    REQUIRE(opened(longer) == MacFault::kForged);
    REQUIRE(opened(authenticated) == MacFault::kNone);
  }
}

TEST_CASE(
    "messages that overtake each other by less than 64 are all taken, each once, from several senders") {
  const BusKey key = BusKey::random();
  std::vector<MessageMac> macs;
  for (int n = 0; n < 3; ++n) macs.emplace_back(key);
  RandomStream random(6, Purpose::kTest);
  std::vector<std::pair<double, Bytes>> sent;
  for (int n = 0; n < 900; ++n) {
    Bytes authenticated(kMacTrailerBytes);
    macs[std::size_t(n % 3)].write("MAP", {}, std::span(authenticated).first<kMacTrailerBytes>());
    sent.emplace_back(n / 3 + random.uniform() * 60.0, authenticated);
    sent.emplace_back(n / 3 + random.uniform() * 60.0, authenticated);
  }
  std::ranges::sort(sent, {}, [](const auto& s) { return s.first; });
  MacVerifier check(key);
  int taken = 0, repeated = 0;
  for (const auto& [when, authenticated] : sent) {
    std::span<const std::byte> view(authenticated);
    const MacFault fault = check.open("MAP", view);
    taken += fault == MacFault::kNone;
    repeated += fault == MacFault::kRepeated;
  }
  CHECK(taken == 900);
  CHECK(repeated == 900);
}

TEST_CASE("the keyed hash is BLAKE2b of 16 bytes: of nothing, as an independent program computes it") {
  BusKey key;
  for (std::size_t n = 0; n < key.bytes.size(); ++n) key.bytes[n] = std::byte(n);
  KeyedHash hash(key);
  std::byte numbers[16];
  for (std::size_t n = 0; n < 16; ++n) numbers[n] = std::byte(n);
  std::byte got[KeyedHash::kBytes];
  hash.compute("MAP", std::as_bytes(std::span(std::string_view("bytes"))), numbers, got);
  std::string hex;
  for (const std::byte b : got) {
    hex += "0123456789abcdef"[std::size_t(b) >> 4];
    hex += "0123456789abcdef"[std::size_t(b) & 15];
  }
  // python3: hashlib.blake2b(b"MAP\0bytes" + bytes(range(16)), digest_size=16,
  // key=bytes(range(32))).hexdigest()
  CHECK(hex == "057a9bd9e7651c904c1351bdeda9f5b6");
}

TEST_CASE("a key goes through its line and back, and no other line is a key") {
  const BusKey key = BusKey::random();
  const auto back = BusKey::from_line(key.line());
  REQUIRE(back);
  CHECK(back->bytes == key.bytes);
  CHECK(BusKey::random().bytes != key.bytes);
  for (const std::string& bad :
       {std::string(), std::string("KEY "), std::string("START"), key.line() + "0", key.line().substr(0, 67),
        "KEY " + std::string(63, '0') + "g", "key " + std::string(64, '0')})
    CHECK_FALSE(BusKey::from_line(bad));
}

TEST_CASE("a bus is without a key only where its URL says so") {
  const std::string url = default_bus_url(free_bus_port(monotonic_ns()));
  CHECK_THROWS_WITH(LcmBus(url), Catch::Contains("there is no key"));
  CHECK_THROWS_WITH(LcmBus(url + "&key=none", BusKey::random()), Catch::Contains("key=none"));
}

TEST_CASE(
    "a process takes its key from the control line, leaves the next line there, and says when none comes") {
  int pair[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0);
  ControlLine launcher(pair[0]);
  ProcessArgs args;
  args.bus_url = default_bus_url(21000);
  args.options.control_fd = pair[1];
  const BusKey key = BusKey::random();
  launcher.say(key.line());
  launcher.say("START");
  launcher.say("STOP " + std::string(80, '.'));
  CHECK(take_bus_key(args)->bytes == key.bytes);
  CHECK_THROWS_WITH(take_bus_key(args), Catch::Contains("no key") && Catch::Contains("key=none"));
  ::close(pair[1]);
  args.options.control_fd = -1;
  CHECK_THROWS_WITH(take_bus_key(args), Catch::Contains("no key"));
  args.bus_url += "&key=none";
  CHECK_FALSE(take_bus_key(args));
}
