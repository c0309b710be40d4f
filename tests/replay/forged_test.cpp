// A message that a node received and its publisher did not send is named by the audit.
#include <catch2/catch.hpp>

#include <algorithm>

#include "replay/audit_run.h"
#include "runs/read/channel_index.h"
#include "runtime/write_ahead.h"
#include "tests/replay/damage.h"
#include "tests/replay/tiny_run.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;

struct Forgery {
  const char* channel;
  const char* receiver;
  const char* publisher;
};

constexpr Forgery kForgeries[] = {{"LAYER_PLAN", "scheduler", "controller"},
                                  {"STAGE_COMMAND", "stage", "scheduler"},
                                  {"ENABLE", "jet", "safety"},
                                  {"HEIGHT_MAP", "controller", "surface_mapper"}};

fs::path forged_recording(const std::string& name) {
  const fs::path run = scratch_folder(name) / "run";
  fs::copy(fs::path(FIRN_SOURCE_DIR) / "tests/replay/golden/v3-kalman", run, fs::copy_options::recursive);
  return run;
}

// Changes the n-th received message of the channel, checksums mended, and returns its number.
template <class Change>
std::int64_t forge(const fs::path& run, const Forgery& f, Change change) {
  std::int64_t seq = 0;
  edit_records(run / "nodes" / (std::string(f.receiver) + ".wal"), [&](Records& records) {
    const std::size_t at = find_record(records, std::uint16_t(WalKind::kEvent), f.channel, 1);
    std::vector<std::byte>& payload = records[at].payload;
    const Event event = decode_event(payload).event;
    REQUIRE(event.channel == f.channel);
    const std::size_t begin = std::size_t(event.bytes.data() - payload.data());
    change(std::span(payload).subspan(begin, event.bytes.size()));
    seq = runs::stamp_of(std::span(payload).subspan(begin))->seq;
  });
  return seq;
}

bool forged(const fs::path& run, const std::string& what) {
  const replay::AuditVerdict v = replay::audit_run(run);
  INFO(to_text(v));
  CAPTURE(what);
  CHECK_FALSE(v.clean());
  return std::ranges::any_of(v.violations, [&](const replay::Violation& x) {
    return x.kind == replay::ViolationKind::kForged && x.what == what;
  });
}

TEST_CASE("A received message with other bytes than its publisher sent is named with channel and number") {
  for (const Forgery& f : kForgeries) {
    const fs::path run = forged_recording("forged-bytes");
    const std::int64_t seq =
        forge(run, f, [](std::span<std::byte> m) { m.back() = m.back() ^ std::byte{1}; });
    CHECK(forged(run, std::string(f.channel) + " " + std::to_string(seq) + " of incarnation 0, received by " +
                          f.receiver + ": " + f.publisher + " sent other bytes"));
  }
}

TEST_CASE("A received message that its publisher never sent is named with channel and number") {
  for (const Forgery& f : kForgeries) {
    const fs::path run = forged_recording("forged-number");
    const std::int64_t seq = forge(run, f, [](std::span<std::byte> m) { m[25] = std::byte{7}; });
    CHECK(seq > 7 << 16);
    CHECK(forged(run, std::string(f.channel) + " " + std::to_string(seq) + " of incarnation 0, received by " +
                          f.receiver + ": " + f.publisher + " did not send it"));
  }
}

TEST_CASE("A damaged record of a message is damage and no forgery") {
  const fs::path run = forged_recording("forged-damage");
  const fs::path file = run / "nodes" / "scheduler.wal";
  const Records records = read_records(file);
  const std::size_t at = find_record(records, std::uint16_t(WalKind::kEvent), "LAYER_PLAN", 1);
  std::vector<std::byte> bytes = read_bytes(file);
  flip(bytes, find_bytes(bytes, records[at].payload) + records[at].payload.size() - 1);
  write_bytes(file, bytes);
  const replay::AuditVerdict v = replay::audit_run(run);
  CHECK_FALSE(v.clean());
  CHECK(std::ranges::none_of(
      v.violations, [](const replay::Violation& x) { return x.kind == replay::ViolationKind::kForged; }));
}

}  // namespace
}  // namespace firn::test
