// The desk of a print alone: places, and lines that it refuses.
#include "print/operator/operator_desk.h"

#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "print/operator/operator_client.h"
#include "tests/print/lone_desk.h"
#include "tests/support/temp_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

struct DeskRun {
  test::TempFolder folder;
  test::LoneDesk desk{folder.path(), 77};
};

/// A connection that speaks only if it is told to.
struct Guest {
  explicit Guest(const fs::path& run) {
    fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un a{};
    a.sun_family = AF_UNIX;
    operator_socket(run).string().copy(a.sun_path, sizeof a.sun_path - 1);
    REQUIRE(::connect(fd, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
  }
  Guest(Guest&& other) noexcept : fd(std::exchange(other.fd, -1)) {}
  ~Guest() {
    if (fd >= 0) ::close(fd);
  }
  void say(const std::string& bytes) const {
    REQUIRE(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) == ssize_t(bytes.size()));
  }
  std::string line() const {
    std::string text;
    for (char c; ::recv(fd, &c, 1, 0) == 1 && c != '\n';) text += c;
    return text;
  }
  int fd = -1;
};

OperatorOrder numbered(OperatorVerb verb, std::int64_t id = 0) {
  return {id == 0 ? new_order_id() : id, verb, {}, {}};
}

TEST_CASE("a thousand guests that say nothing take no place from a stop") {
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  const rlimit more{std::min<rlim_t>(files.rlim_max, 4096), files.rlim_max};
  ::setrlimit(RLIMIT_NOFILE, &more);
  {
    DeskRun print;
    std::vector<Guest> guests;
    for (int n = 0; n < 1000; ++n) guests.emplace_back(print.folder.path());
    OperatorClient client(print.folder.path());
    client.send(numbered(OperatorVerb::kStop));
    CHECK(client.next(10.0) == "ok stop: the lab is stopped");
    CHECK(print.desk.orders() == std::vector<std::string>{"stop"});
  }
  ::setrlimit(RLIMIT_NOFILE, &files);
}

TEST_CASE("guests that say nothing are closed before one that is attached") {
  DeskRun print;
  OperatorClient attached(print.folder.path());
  attached.say("attach");
  const auto answer = [&] {
    std::optional<std::string> line;
    do line = attached.next(10.0);
    while (line && line->starts_with("note "));  // that the print waits, or goes on
    return line.value_or("");
  };
  attached.send(numbered(OperatorVerb::kPause));
  REQUIRE_THAT(answer(), Contains("ok pause"));
  std::vector<Guest> guests;
  for (int n = 0; n < 100; ++n) guests.emplace_back(print.folder.path());
  attached.send(numbered(OperatorVerb::kContinue));
  CHECK_THAT(answer(), Contains("ok continue"));
}

TEST_CASE("an order's number that comes again with another word is refused") {
  DeskRun print;
  OperatorClient client(print.folder.path());
  client.send(numbered(OperatorVerb::kPause, 9));
  CHECK_THAT(client.next(10.0).value_or(""), Contains("ok pause"));
  client.send(numbered(OperatorVerb::kPause, 9));
  CHECK_THAT(client.next(10.0).value_or(""), Contains("was taken before"));
  client.send(numbered(OperatorVerb::kContinue, 9));
  CHECK(client.next(10.0) ==
        "refused order 9 was 'pause' and is no 'continue': without --id it gets a number of its own");
  CHECK(print.desk.orders() == std::vector<std::string>{"pause"});
}

TEST_CASE("bytes that no message can carry are refused to their sender, and the next order is obeyed") {
  DeskRun print;
  const Guest guest(print.folder.path());
  using namespace std::string_literals;
  for (const std::string& line : {"1 set control.max_layers=7\0"s, "\0"s, "2 set a=\xff"s, "from \xc3"s,
                                  "3 pause\x07"s, "4 set \x80=1"s}) {
    guest.say(line + "\n");
    CHECK_THAT(guest.line(), Catch::StartsWith("refused a line must be printable UTF-8"));
  }
  guest.say("5 pause\n");
  CHECK_THAT(guest.line(), Catch::StartsWith("ok pause"));
}

TEST_CASE("an order for another run is refused by its number") {
  DeskRun print;
  const Guest guest(print.folder.path());
  guest.say("run 78\n5 stop\n");
  CHECK(guest.line() == "refused this print is run 77; the order is for run 78");
  guest.say("run 77\n6 stop\n");
  CHECK(guest.line() == "ok stop: the lab is stopped");
  CHECK(print.desk.orders() == std::vector<std::string>{"stop"});
}

TEST_CASE("A print that waits says so to who asks for its state, and to who attaches while it does") {
  DeskRun print;
  CHECK(OperatorClient::state_of(print.folder.path()) == "running");
  OperatorClient operator_there(print.folder.path());
  operator_there.send(numbered(OperatorVerb::kPause));
  REQUIRE_THAT(operator_there.next(10.0).value_or(""), Catch::StartsWith("ok pause"));
  CHECK(OperatorClient::state_of(print.folder.path()) == "paused: the print waits before layer 2, pass 1");
  const Guest late(print.folder.path());
  late.say("attach\n");
  CHECK(late.line() == "note the print waits before layer 2, pass 1");
  operator_there.send(numbered(OperatorVerb::kContinue));
  REQUIRE_THAT(operator_there.next(10.0).value_or(""), Catch::StartsWith("ok continue"));
  CHECK(OperatorClient::state_of(print.folder.path()) == "running");
}

TEST_CASE("A key that ends a print is obeyed at its second press alone, soon after the first") {
  KeyReader keys;
  for (const auto& [key, verb] : {std::pair('f', OperatorVerb::kFinishLayer), {'S', OperatorVerb::kStop}}) {
    CAPTURE(key);
    const KeyPress first = keys.press(key, 10.0);
    CHECK_FALSE(first.order);
    CHECK_THAT(first.hint, Contains(std::string("press ") + key + " again"));
    const KeyPress second = keys.press(key, 11.0);
    REQUIRE(second.order);
    CHECK(second.order->verb == verb);
    CHECK_FALSE(keys.press(key, 11.5).order);                              // a third is a first
    CHECK_FALSE(keys.press(key, 11.6 + KeyReader::kTwiceWithin_s).order);  // too late
    CHECK_FALSE(keys.press(key == 'f' ? 'S' : 'f', 11.7 + KeyReader::kTwiceWithin_s).order);
    CHECK_FALSE(keys.press(key, 11.8 + KeyReader::kTwiceWithin_s).order);  // another came between
    CHECK(keys.press('p', 20.0).order);
    CHECK_FALSE(keys.press(key, 20.1).order);
    CHECK(keys.press('c', 20.2).order);
  }
  CHECK(keys.press('x', 30.0).hint == KeyReader::kHelp);
}

TEST_CASE("a folder that took the place of another run's gets no order that was meant for that one") {
  DeskRun print;
  std::ofstream(print.folder.path() / "provenance.json") << "{\"run_id\": 5}\n";
  OperatorClient client(print.folder.path());
  client.send(numbered(OperatorVerb::kStop));
  CHECK(client.next(10.0) == "refused this print is run 77; the order is for run 5");
}

}  // namespace
}  // namespace firn
