// The door of the lab's own programs on a real bus: who is let in, and how the rest is counted.
#include <poll.h>

#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "files/usage_error.h"
#include "print/own/own_door.h"
#include "print/process/bus_port.h"
#include "procs/bus/message_mac.h"
#include "tests/procs/foreigner.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

const std::vector<std::byte>& no_message() {
  static const std::vector<std::byte> none;
  return none;
}

std::vector<std::byte> pressure(double hpa) {
  own_values_t m{};
  m.name = "air pressure";
  m.unit = "hPa";
  m.values = {hpa};
  m.n = 1;
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

/// A door on a bus of its own, and a program of this host that sends anything.
struct OpenDoor {
  explicit OpenDoor(bool keyed = true)
      : port(free_bus_port(77)),
        key(keyed ? std::optional(BusKey::random()) : std::nullopt),
        outside(port),
        door(
            default_bus_url(port) + (keyed ? "" : "&key=none"), key,
            [this](OwnMessage&& m) { taken.push_back(std::get<own_values_t>(m)); },
            [this](const std::string& w) { warnings.push_back(w); }) {}

  void send(const std::string& channel, std::vector<std::byte> message, MessageMac* mac) {
    if (mac) {
      const std::vector<std::byte> plain = message;
      message.resize(plain.size() + kMacTrailerBytes);
      mac->write(channel, plain, std::span(message).last<kMacTrailerBytes>());
    }
    outside.to_group(short_message(channel, {reinterpret_cast<const char*>(message.data()), message.size()}));
  }
  void settle() {
    pollfd ready{door.fd(), POLLIN, 0};
    while (::poll(&ready, 1, 100) > 0) door.service();
  }
  const OwnCount& count() const { return door.counts().at("room"); }

  int port;
  std::optional<BusKey> key;
  Foreigner outside;
  std::vector<own_values_t> taken;
  std::vector<std::string> warnings;
  OwnDoor door;
};

}  // namespace

TEST_CASE("a program with its key is heard under its name", "[own]") {
  OpenDoor open;
  MessageMac mac(own_key(*open.key, "room"));
  open.send("own/room/OWN_VALUES", pressure(1013.0), &mac);
  open.settle();
  REQUIRE(open.taken.size() == 1);
  CHECK(open.taken[0].program == "room");
  CHECK(open.taken[0].values == std::vector<double>{1013.0});
  CHECK(open.door.summary() == std::vector<std::string>{"room: 1 message taken"});
}

TEST_CASE("a program's key speaks for no other program, and for no process of the run", "[own]") {
  OpenDoor open;
  MessageMac mac(own_key(*open.key, "room"));
  for (const char* channel : {"own/other/OWN_VALUES", "own/roo/OWN_VALUES", "own//OWN_VALUES", "own/room",
                              "own/room/", "OWN_VALUES"})
    open.send(channel, pressure(1.0), &mac);
  MacVerifier node(*open.key);  // as every process of the run has one
  std::vector<std::byte> sealed(kMacTrailerBytes);
  mac.write("JET_COMMAND", no_message(), std::span(sealed).last<kMacTrailerBytes>());
  std::span<const std::byte> view = sealed;
  CHECK(node.open("JET_COMMAND", view) == MacFault::kForged);
  open.settle();
  CHECK(open.taken.empty());
  CHECK(open.door.counts().empty());
}

TEST_CASE("the run's own key does not open the door, nor does none", "[own]") {
  OpenDoor open;
  MessageMac run(*open.key);
  open.send("own/room/OWN_VALUES", pressure(1.0), &run);
  open.send("own/room/OWN_VALUES", pressure(1.0), nullptr);
  open.settle();
  CHECK(open.taken.empty());
}

TEST_CASE("a message of a program is taken once", "[own]") {
  OpenDoor open;
  MessageMac mac(own_key(*open.key, "room"));
  std::vector<std::byte> sealed = pressure(1.0);
  const std::vector<std::byte> plain = sealed;
  sealed.resize(plain.size() + kMacTrailerBytes);
  mac.write("own/room/OWN_VALUES", plain, std::span(sealed).last<kMacTrailerBytes>());
  for (int n = 0; n < 3; ++n) open.send("own/room/OWN_VALUES", sealed, nullptr);
  open.settle();
  CHECK(open.taken.size() == 1);
}

TEST_CASE("rubbish of a program is refused by member, told three times and counted on", "[own]") {
  OpenDoor open;
  MessageMac mac(own_key(*open.key, "room"));
  open.send("own/room/OWN_VALUES", pressure(1.0), &mac);
  for (int n = 0; n < 5; ++n) open.send("own/room/OWN_VALUES", {std::byte{7}, std::byte{8}}, &mac);
  open.send("own/room/JET_COMMAND", pressure(1.0), &mac);
  open.settle();
  CHECK(open.taken.size() == 1);
  CHECK(open.count().refused == 6);
  REQUIRE(open.warnings.size() == OwnDoor::kWarnings);
  CHECK_THAT(open.warnings[0], Catch::StartsWith("room: a message was refused: OWN_VALUES: byte 0"));
  CHECK_THAT(open.warnings[2], Contains("further ones are counted"));
  CHECK_THAT(open.door.summary().at(0), Contains("1 message taken, 6 refused (the last: JET_COMMAND"));
}

TEST_CASE("messages of a program that never came are counted by their numbers", "[own]") {
  OpenDoor open;
  MessageMac mac(own_key(*open.key, "room"));
  for (int n = 0; n < 6; ++n) {
    std::vector<std::byte> gone(kMacTrailerBytes);
    if (n == 2 || n == 3)
      mac.write("own/room/OWN_VALUES", no_message(), std::span(gone).last<kMacTrailerBytes>());
    open.send("own/room/OWN_VALUES", pressure(n), &mac);
  }
  open.settle();
  CHECK_THAT(open.door.summary().at(0), Catch::Equals("room: 6 messages taken, 2 lost on the way"));
}

TEST_CASE("a program that floods the bus is cut off, and another one is still heard", "[own]") {
  OpenDoor open;
  MessageMac room(own_key(*open.key, "room")), other(own_key(*open.key, "other"));
  for (int n = 0; n < 5 * OwnDoor::kMostPerSecond; ++n) {
    open.send("own/room/OWN_VALUES", pressure(n), &room);
    if (n % 100 == 0) open.door.service();
  }
  open.send("own/other/OWN_VALUES", pressure(1.0), &other);
  open.settle();
  CHECK(open.count().refused > 0);
  CHECK_THAT(open.warnings.at(0), Contains("more than 200 messages in a second"));
  CHECK(open.taken.back().program == "other");
}

TEST_CASE("on a bus without a key a program is heard without one", "[own]") {
  OpenDoor open(false);
  open.send("own/room/OWN_VALUES", pressure(1.0), nullptr);
  open.settle();
  CHECK(open.taken.size() == 1);
  CHECK_THAT(open.door.admission("room", 5), Contains("\"key\":\"\""));
}

TEST_CASE("the admission of a program has its key, its channels and the bus, and a bad name gets none",
          "[own]") {
  OpenDoor open;
  const std::string text = open.door.admission("room", 42);
  CHECK_THAT(text, Contains("\"run_id\":42") && Contains("\"program\":\"room\"") &&
                       Contains(own_key(*open.key, "room").hex()) && Contains("own/room/OWN_HEIGHT_MODEL"));
  CHECK(text.find(open.key->hex()) == std::string::npos);
  CHECK_THROWS_AS(open.door.admission("jet", 42), UsageError);
  CHECK_THROWS_AS(open.door.admission("A B", 42), UsageError);
}

TEST_CASE("keys of programs differ from each other and from the run's", "[own]") {
  const BusKey run = BusKey::random();
  CHECK(own_key(run, "a").bytes != own_key(run, "b").bytes);
  CHECK(own_key(run, "a").bytes != run.bytes);
  CHECK(own_key(run, "a").bytes == own_key(run, "a").bytes);
  CHECK(own_key(BusKey::random(), "a").bytes != own_key(run, "a").bytes);
}
