// Every kind of event in the texts that people read of a write-ahead file.
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "cli/log_lines.h"
#include "core/options/enumerators.h"
#include "runs/read/describe.h"
#include "runtime/write_ahead.h"

using namespace firn;

TEST_CASE("firn log and the trace of a replay have words for every kind of event") {
  std::set<std::string> lines, traces;
  for (std::size_t kind = 1; kind < kTableSize<EventKind>; ++kind) {
    Event e;
    e.kind = EventKind(kind);
    e.channel = "SAFE_STOP";
    std::vector<std::byte> payload;
    encode_event(1, e, payload);
    record::Record record;
    record.kind = std::uint16_t(WalKind::kEvent);
    record.payload = payload;
    const RecordLine line = record_line(record, true, {});
    CHECK(line.error.empty());
    CHECK(line.json.find("\"?\"") == std::string::npos);
    lines.insert(line.json);
    CHECK_FALSE(runs::place_of(e, {"line"}).empty());
    traces.insert(runs::as_json(1, e, {"line"}));
  }
  CHECK(lines.size() == kTableSize<EventKind> - 1);
  CHECK(traces.size() == kTableSize<EventKind> - 1);
}
