// Cassettes: their text, and the deck that plays them.
#include <poll.h>

#include <catch2/catch.hpp>
#include <string>

#include "files/text_file.h"
#include "runtime/cassette_deck.h"
#include "runtime/ports.h"
#include "runtime/run_clock.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using Catch::Contains;
using Kind = Cassette::Kind;

namespace {

std::span<const std::byte> span_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}
std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string a_tape() {
  return cassette_head("lamp", "REAL tcp:h:1", "[lamp]\nx = 1\n") + cassette_line(Kind::kOpened, 0.5, {}) +
         cassette_line(Kind::kSent, 1.0, span_of("GUS")) +
         cassette_line(Kind::kReceived, 3.0, span_of("18")) +
         cassette_line(Kind::kReceived, 3.5, span_of("95\r")) +
         cassette_order("LAMP_COMMAND", 4.0, span_of("x"), "expose 1 | 2") +
         cassette_line(Kind::kSent, 4.0, span_of("OPN")) +
         cassette_line(Kind::kReceived, 5.25, span_of("ok")) +
         cassette_line(Kind::kSent, 6.0, span_of("GUS")) +
         cassette_line(Kind::kReceived, 7.0, span_of("22")) + cassette_order("stop", 8.0, {}, "") +
         cassette_line(Kind::kClosed, 9.0, {});
}

std::string taken(CassetteDeck& deck, std::int64_t now_us) {
  std::vector<std::byte> bytes;
  std::string all;
  bool closed = false;
  while (!closed && deck.take(now_us, bytes, closed)) all += closed ? "<closed>" : text_of(bytes);
  return all;
}

}  // namespace

TEST_CASE("a cassette is read back as it was written", "[cassette]") {
  const Cassette c = parse_cassette(a_tape(), "a.cassette");
  CHECK(c.node == "lamp");
  CHECK(c.remarks.front() == "REAL tcp:h:1");
  CHECK(config_of(c) == "[lamp]\nx = 1\n");
  REQUIRE(c.pieces.size() == 11);
  CHECK(c.pieces[1].kind == Kind::kSent);
  CHECK(text_of(c.pieces[1].bytes) == "GUS");
  CHECK(c.pieces[3].ms == 3.5);
  CHECK(c.pieces[4].kind == Kind::kOrder);
  CHECK(c.pieces[4].channel == "LAMP_COMMAND");
  CHECK(text_of(c.pieces[4].bytes) == "x");
  CHECK(c.pieces[9].channel == "stop");
  CHECK(c.pieces[10].kind == Kind::kClosed);
}

TEST_CASE("a damaged cassette is refused by file, line and what it must hold", "[cassette]") {
  const std::string head = "firn cassette 1 lamp\n";
  const std::pair<std::string, const char*> wrong[] = {
      {"", "a.cassette:1: is empty"},
      {"firn cassette 2 lamp\n", "a.cassette:1: is no cassette"},
      {"firn cassette 1 \n", "a.cassette:1: is no cassette"},
      {"firn cassette 1 la mp\n", "'la mp' is no instrument's name"},
      {head + "x > 41\n", "a.cassette:2: 'x' is no time"},
      {head + "nan > 41\n", "'nan' is no time"},
      {head + "1e300 > 41\n", "is no time"},
      {head + "-1 > 41\n", "is no time"},
      {head + "1 ? 41\n", "after the time stands"},
      {head + "1 > 4\n", "'4' is no byte"},
      {head + "1 > 4g\n", "'4g' is no byte"},
      {head + "1 >\n", "has no bytes"},
      {head + "1 = X |y|\n", "has no bytes"},
      {head + "2 > 41\n1 < 42\n", "a.cassette:3: is earlier than the line before"},
  };
  for (const auto& [text, why] : wrong) {
    INFO(text);
    CHECK_THROWS_WITH(parse_cassette(text, "a.cassette"), Contains(why));
  }
}

TEST_CASE("a deck answers what was asked as it was answered, after the same time", "[cassette]") {
  CassetteDeck deck(parse_cassette(a_tape(), "a"));
  deck.open(1000);
  CHECK(deck.due_us() == INT64_MAX);
  REQUIRE(deck.send(span_of("GUS"), 10'000));
  CHECK(deck.due_us() == 12'000);
  CHECK(taken(deck, 11'999).empty());
  CHECK(taken(deck, 12'000) == "18");
  CHECK(taken(deck, 12'500) == "95\r");
  REQUIRE(deck.send(span_of("OPN"), 20'000));
  CHECK(taken(deck, 30'000) == "ok");
  CHECK_FALSE(deck.send(span_of("SIL50"), 30'000));
  CHECK(deck.due_us() == INT64_MAX);
  REQUIRE(deck.send(span_of("GUS"), 40'000));  // the later answer: the shutter is open now
  CHECK(taken(deck, 60'000) == "22<closed>");
  deck.open(70'000);
  REQUIRE(deck.send(span_of("GUS"), 80'000));  // from the beginning
  CHECK(taken(deck, 90'000) == "1895\r");
}

TEST_CASE("questions asked oftener than on the tape are answered again", "[cassette]") {
  CassetteDeck deck(parse_cassette(a_tape(), "a"));
  deck.open(0);
  for (int n = 0; n < 20; ++n) {
    REQUIRE(deck.send(span_of("OPN"), n * 10'000));
    CHECK(taken(deck, n * 10'000 + 5'000) == "ok");
  }
}

TEST_CASE("a port on a cassette opens, answers and closes as a line does, and says what it does not know",
          "[cassette]") {
  const test::Scratch scratch("cassette");
  write_file_atomically(scratch / "a.cassette", a_tape());
  Ports ports({parse_port_address("cassette:" + (scratch / "a.cassette").string())});
  std::string recorded;
  ports.record([&](PortId, Kind kind, std::span<const std::byte> bytes) {
    recorded += kind == Kind::kOpened ? "[" : kind == Kind::kClosed ? "]" : text_of(bytes);
  });
  ports.open_all(monotonic_us());
  std::string heard;
  int opened = 0, closed = 0;
  const auto turn = [&] {
    std::vector<pollfd> fds;
    ports.add_to(fds);
    ::poll(fds.data(), fds.size(), 20);
    ports.service(
        monotonic_us(), [&](PortId, LinkState link) { (link == LinkState::kOpen ? opened : closed)++; },
        [&](PortId, std::span<const std::byte> bytes) { heard += text_of(bytes); });
  };
  turn();
  REQUIRE(opened == 1);
  ports.write(PortId{0}, span_of("GUS"), false);
  for (int n = 0; n < 200 && heard.size() < 5; ++n) turn();
  CHECK(heard == "1895\r");
  ports.write(PortId{0}, span_of("SIL50"), false);
  CHECK_THAT(ports.take_notices().at(0), Contains("stands nowhere on the cassette: 53 49 4c 35 30 |SIL50|"));
  ports.write(PortId{0}, span_of("GUS"), false);
  for (int n = 0; n < 200 && closed == 0; ++n) turn();
  CHECK(heard == "1895\r22");
  CHECK(closed == 1);
  CHECK(recorded == "[GUS1895\rSIL50GUS22]");
}
