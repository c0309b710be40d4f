// The journal of a process that runs.
#include "runtime/heartbeat.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "core/options/enumerators.h"
#include "firn/journal_t.hpp"
#include "tests/runtime/process_nodes.h"

using namespace firn;
using namespace firn::test;

TEST_CASE("the journal has a word of its own for every kind of event") {
  Hub hub;
  Hub::Member watcher(hub), bus(hub);
  watcher.subscribe("JOURNAL_JET");
  Heartbeat heartbeat(NodeId::kJet, 5, 0, RunClock(0, 0, 1.0), bus);
  std::set<std::string> words;
  for (std::size_t kind = 1; kind < kTableSize<EventKind>; ++kind) {
    heartbeat.note({kind, EventKind(kind), {}, 0, 0});
    journal_t last{};
    for (int n = 0; n < 500 && last.step != std::int64_t(kind); ++n) {
      ::usleep(10'000);
      watcher.receive(
          [&](std::string_view, std::span<const std::byte> b) { last.decode(b.data(), 0, int(b.size())); });
    }
    CHECK_FALSE(last.event.empty());
    words.insert(last.event);
  }
  CHECK(words.size() == kTableSize<EventKind> - 1);
}
