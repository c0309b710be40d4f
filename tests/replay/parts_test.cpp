// The parts of replay, each against the written records: comparison of messages, files of nodes, messages of
// a run, words and JSON of verdicts.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "core/grid/random.h"
#include "files/json.h"
#include "files/record/event_log.h"
#include "firn/height_map_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "replay/audit.h"
#include "replay/ice_error.h"
#include "replay/message_compare.h"
#include "replay/print_verdict.h"
#include "runs/folder/recorded_steps.h"
#include "runs/read/bytes.h"
#include "runs/read/channel_index.h"
#include "runs/read/describe.h"
#include "runs/read/run_reader.h"
#include "tests/replay/damage.h"
#include "tests/replay/tiny_run.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using namespace replay;
using namespace runs;
using Json = nlohmann::json;

template <class Message>
std::vector<std::byte> encoded(const Message& m) {
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  REQUIRE(m.encode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
  return bytes;
}

layer_plan_t plan(int cells) {
  layer_plan_t p{};
  p.header = {77, 2, 41, 1'500'000};
  p.n = cells;
  p.layer = 3;
  p.objective_mm = 0.25;
  p.iterations = 1000;
  p.reason = "lower";
  for (int c = 0; c < cells; ++c) p.drops.push_back(std::int8_t(c % 3));
  return p;
}

const ChannelInfo& channel_of(const std::string& name) {
  const ChannelInfo* channel = find_channel(name);
  REQUIRE(channel);
  return *channel;
}

// Compares two plans by a comparer with `options`.
std::optional<FieldDifference> compared(const layer_plan_t& a, const layer_plan_t& b,
                                        ReplayOptions options = {}) {
  MessageComparer comparer(options);
  return comparer.compare(channel_of("LAYER_PLAN"), encoded(a), encoded(b));
}

TEST_CASE("Of two messages that differ in one member, the comparer names that member and both values") {
  const layer_plan_t a = plan(12);
  const std::vector<std::pair<std::string, std::function<void(layer_plan_t&)>>> changes{
      {"layer", [](layer_plan_t& p) { p.layer = 4; }},
      {"header.seq", [](layer_plan_t& p) { p.header.seq = 42; }},
      {"objective_mm", [](layer_plan_t& p) { p.objective_mm = std::nextafter(0.25, 1.0); }},
      {"reason", [](layer_plan_t& p) { p.reason = "higher"; }},
      {"drops[0]", [](layer_plan_t& p) { p.drops[0] = 7; }},
      {"drops[11]", [](layer_plan_t& p) { p.drops[11] = 7; }}};
  CHECK_FALSE(compared(a, a));
  for (const auto& [field, change] : changes) {
    layer_plan_t b = a;
    change(b);
    const auto difference = compared(a, b);
    CAPTURE(field);
    REQUIRE(difference);
    CHECK(difference->path == field);
    CHECK(difference->a != difference->b);
    const auto other = compared(b, a);
    REQUIRE(other);
    CHECK(other->a == difference->b);
    CHECK(other->b == difference->a);
  }
}

TEST_CASE("Any single flipped bit of a message is a difference") {
  const std::vector<std::byte> bytes = encoded(plan(9));
  RandomStream random(61, Purpose::kTest);
  MessageComparer comparer({});
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<std::byte> other = bytes;
    const std::size_t at = random.below(std::uint32_t(bytes.size()));
    flip(other, at, int(random.below(8)));
    CAPTURE(at);
    CHECK(comparer.compare(channel_of("LAYER_PLAN"), bytes, other));
  }
}

TEST_CASE("A message that was cut anywhere differs from the whole one, with and without a tolerance") {
  const std::vector<std::byte> bytes = encoded(plan(5));
  for (const double tolerance : {0.0, 1.0}) {
    ReplayOptions options;
    options.tolerance = tolerance;
    MessageComparer comparer(options);
    for (std::size_t keep = 0; keep < bytes.size(); ++keep)
      REQUIRE(comparer.compare(channel_of("LAYER_PLAN"), bytes, std::span(bytes).first(keep)));
  }
}

TEST_CASE("A tolerance lets numbers pass up to it and no further, and keeps the largest that passed") {
  const layer_plan_t a = plan(4);
  for (const double by : {1e-9, 0.05, 0.0999, 0.1001, 3.0}) {
    layer_plan_t b = a;
    b.objective_mm += by;
    ReplayOptions options;
    options.tolerance = 0.1;
    MessageComparer comparer(options);
    const auto difference = comparer.compare(channel_of("LAYER_PLAN"), encoded(a), encoded(b));
    CAPTURE(by);
    CHECK(difference.has_value() == (by > 0.1));
    CHECK(comparer.largest_difference() == Approx(by <= 0.1 ? by : 0.0).margin(1e-15));
    if (by <= 0.1) CHECK(comparer.largest_difference_field() == "LAYER_PLAN.objective_mm");
  }
}

TEST_CASE("A tolerance lets no text, no length and no value that is no number pass") {
  ReplayOptions options;
  options.tolerance = 1e9;
  const layer_plan_t a = plan(4);
  layer_plan_t text = a, longer = plan(5), nan = a;
  text.reason = "lowes";
  nan.objective_mm = std::nan("");
  CHECK(compared(a, text, options));
  CHECK(compared(a, longer, options));
  CHECK(compared(a, nan, options));
  CHECK_FALSE(compared(nan, nan, options));
}

TEST_CASE("An ignored field passes on the channel that is named, or on all, and is counted") {
  layer_plan_t a = plan(4), b = a;
  b.iterations = 7;
  b.drops = {1, 1, 1, 1};
  for (const char* field : {"iterations", "LAYER_PLAN.iterations"}) {
    ReplayOptions options;
    options.ignores = {{field, "counts"}, {"drops", "test"}};
    MessageComparer comparer(options);
    CHECK_FALSE(comparer.compare(channel_of("LAYER_PLAN"), encoded(a), encoded(b)));
    REQUIRE(comparer.ignored().size() == 2);
    CHECK(comparer.ignored()[0].times == 1);
    CHECK(comparer.ignored()[1].times == 3);  // of four droplet counts one is the same
  }
  for (const char* field : {"HEIGHT_MAP.iterations", "iteration", "LAYER_PLAN", "PLAN.iterations"}) {
    ReplayOptions options;
    options.ignores = {{field, "counts"}, {"drops", "test"}};
    CAPTURE(field);
    CHECK(compared(a, b, options)->path == "iterations");
  }
}

TEST_CASE("An ignore without a field or without a reason is refused, a reason may hold an equals sign") {
  for (const char* text : {"", "=", "iterations", "iterations=", "=why"})
    CHECK_THROWS_WITH(parse_ignore(text), Catch::Contains("FIELD=reason"));
  CHECK(parse_ignore("a.b=x = y").field == "a.b");
  CHECK(parse_ignore("a.b=x = y").reason == "x = y");
}

TEST_CASE("The first byte that differs is found by its place, also behind the shorter one's end") {
  const auto bytes = [](const std::string& s) {
    const auto view = std::as_bytes(std::span(s));
    return std::vector<std::byte>(view.begin(), view.end());
  };
  const FieldDifference inside = byte_difference(bytes("abcd"), bytes("abxd"));
  CHECK(inside.path == "byte 2");
  CHECK(inside.a == "0x63");
  CHECK(inside.b == "0x78");
  const FieldDifference behind = byte_difference(bytes("ab"), bytes("abc"));
  CHECK(behind.path == "byte 2");
  CHECK(behind.a == "end");
  CHECK(behind.b == "0x63");
  CHECK(same_bytes(bytes(""), bytes("")));
  CHECK_FALSE(same_bytes(bytes("a"), bytes("")));
  CHECK_FALSE(same_bytes(bytes("ab"), bytes("ac")));
}

TEST_CASE("The stamp of an encoded message is its header, and too few bytes have none") {
  RandomStream random(62, Purpose::kTest);
  for (int trial = 0; trial < 100; ++trial) {
    layer_plan_t p = plan(3);
    p.header = {std::int64_t(random.bits()), std::int32_t(random.bits()), std::int64_t(random.bits()),
                std::int64_t(random.bits())};
    const std::vector<std::byte> bytes = encoded(p);
    const auto stamp = stamp_of(bytes);
    REQUIRE(stamp);
    CHECK(stamp->run_id == p.header.run_id);
    CHECK(stamp->incarnation == p.header.incarnation);
    CHECK(stamp->seq == p.header.seq);
    CHECK(stamp->utime_us == p.header.utime_us);
  }
  const std::vector<std::byte> bytes = encoded(plan(3));
  for (std::size_t keep = 0; keep < 36; ++keep) CHECK_FALSE(stamp_of(std::span(bytes).first(keep)));
}

TEST_CASE("Every channel of the table is found at its own place, and no other name is") {
  const ChannelIndex index;
  for (std::size_t n = 0; n < ChannelIndex::size(); ++n) CHECK(index.find(channel_table()[n].name) == int(n));
  for (const char* name : {"", "LAYER_PLA", "LAYER_PLAN ", "layer_plan"}) CHECK(index.find(name) == -1);
}

TEST_CASE("Replay expects no message of the runner's own channels from a node") {
  int runner = 0, nodes_own = 0;
  for (const ChannelInfo& c : channel_table()) {
    const std::string name(c.name);
    const bool own = name.rfind("HEARTBEAT_", 0) == 0 || name.rfind("CONFIG_", 0) == 0 ||
                     name.rfind("RESEND_", 0) == 0 || name.rfind("JOURNAL_", 0) == 0;
    runner += own;
    nodes_own += sent_by_node(c);
    CHECK_FALSE((own && sent_by_node(c)));
  }
  CHECK(runner > 0);
  CHECK(nodes_own > 10);
}

TEST_CASE("Escaped bytes are printable ASCII that reads back to the bytes") {
  RandomStream random(63, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<std::byte> bytes;
    for (std::uint32_t n = random.below(40); n > 0; --n) bytes.push_back(std::byte(random.below(256)));
    const std::string text = escaped(bytes, 1000);
    std::vector<std::byte> back;
    for (std::size_t n = 0; n < text.size(); ++n) {
      REQUIRE((text[n] >= 0x20 && text[n] < 0x7f));
      if (text[n] != '\\') {
        back.push_back(std::byte(text[n]));
        continue;
      }
      ++n;
      if (text[n] == 'r') back.push_back(std::byte('\r'));
      if (text[n] == 'n') back.push_back(std::byte('\n'));
      if (text[n] == 'x') {
        back.push_back(std::byte(std::stoi(text.substr(n + 1, 2), nullptr, 16)));
        n += 2;
      }
    }
    REQUIRE(back == bytes);
  }
  CHECK(escaped(std::as_bytes(std::span("abcdef", 6)), 3) == "abc...");
}

TEST_CASE("Every kind of event is one JSON object that names its step, time and place") {
  const std::vector<std::byte> message = encoded(plan(40));
  const std::string io = "OK \"1\"\r\n\x01";
  const std::vector<std::string> ports{"stage", "jet"};
  for (const EventKind kind : {EventKind::kStart, EventKind::kMessage, EventKind::kWake, EventKind::kIo,
                               EventKind::kLink, EventKind::kLocalStop}) {
    Event e;
    e.kind = kind;
    e.now = Time{1'234'567};
    e.channel = "LAYER_PLAN";
    e.id = 1;
    e.due = Time{5};
    e.bytes =
        kind == EventKind::kMessage ? std::span<const std::byte>(message) : std::as_bytes(std::span(io));
    const std::string line = as_json(17, e, ports);
    CAPTURE(line);
    const Json j = Json::parse(line);
    CHECK(j.at("step") == 17);
    CHECK(j.at("now_us") == 1'234'567);
    CHECK(j.at("from") == place_of(e, ports));
    CHECK(line.find('\n') == line.npos);
    if (kind == EventKind::kMessage) CHECK(j.at("message").at("layer") == 3);
    if (kind == EventKind::kIo) CHECK(j.at("size") == io.size());
  }
}

TEST_CASE("A port without a name is told by its number") {
  Event e;
  e.kind = EventKind::kIo;
  e.id = 5;
  CHECK(place_of(e, {"stage"}) == "port 5");
  e.id = 0;
  CHECK(place_of(e, {"stage"}) == "port stage");
}

TEST_CASE("A node's file is read to the steps that were recorded, in order, with their outputs") {
  const fs::path run = scratch_folder("parts-wal");
  record_tiny_run(run, {.resumes = 2});
  for (const char* node : {"scheduler", "surface_mapper", "controller", "laser_profiler"}) {
    const fs::path path = run / "nodes" / (std::string(node) + ".wal");
    std::size_t heads = 0, events = 0, outputs = 0;
    for (const RawRecord& r : read_records(path)) {
      heads += r.kind == std::uint16_t(WalKind::kHead);
      events += r.kind == std::uint16_t(WalKind::kEvent);
      outputs += r.kind == std::uint16_t(WalKind::kOutputs);
    }
    WalFile file(path);
    std::size_t steps = 0, with_outputs = 0, incarnations = 0, lasts = 0;
    std::uint64_t before = 0;
    for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
      if (item == WalFile::Item::kHead) {
        CHECK(file.head().node == node);
        CHECK(file.head().incarnation == std::int32_t(incarnations));
        ++incarnations;
        continue;
      }
      REQUIRE(item == WalFile::Item::kStep);
      if (steps > 0) CHECK(file.step().step > before);
      before = file.step().step;
      ++steps;
      with_outputs += file.step().has_outputs;
      lasts += file.step().last;
      CHECK_FALSE(file.step().damaged_at);
    }
    CAPTURE(node);
    CHECK(incarnations == 3);
    CHECK(heads == 3);
    CHECK(lasts == 3);
    CHECK(steps == events);
    CHECK(with_outputs == outputs);
    CHECK(file.damage().list().empty());
    CHECK(file.size() == fs::file_size(path));
  }
}

TEST_CASE(
    "Records of an unknown kind and records that do not decode are named by their byte and passed over") {
  const fs::path run = scratch_folder("parts-unknown");
  record_tiny_run(run);
  const fs::path path = run / "nodes" / "controller.wal";
  std::size_t whole = 0;
  for (const RawRecord& r : read_records(path)) whole += r.kind == std::uint16_t(WalKind::kEvent);
  edit_records(path, [](Records& records) {
    records.insert(records.begin() + 3, {99, {std::byte{1}}});
    records.insert(records.begin() + 1, {std::uint16_t(WalKind::kEvent), {std::byte{1}, std::byte{2}}});
  });
  WalFile file(path);
  std::size_t steps = 0;
  std::vector<std::string> troubles;
  for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
    steps += item == WalFile::Item::kStep;
    if (item == WalFile::Item::kUnknown) troubles.push_back(file.trouble());
  }
  CHECK(steps == whole);
  REQUIRE(troubles.size() == 2);
  CHECK(troubles[1] == "record kind 99 is not known");
}

TEST_CASE("An incarnation that never started takes no start time from those after it") {
  const fs::path run = scratch_folder("parts-starts");
  record_tiny_run(run, {.resumes = 2});
  const std::vector<std::int64_t> whole = RunReader(run).starts();
  REQUIRE(whole.size() == 3);
  for (const auto& file : fs::directory_iterator(run / "nodes"))
    if (file.path().extension() == ".wal")
      edit_records(file.path(), [](Records& records) {
        std::erase_if(records, [](const RawRecord& r) {
          if (r.kind != std::uint16_t(WalKind::kEvent)) return false;
          const WalEvent w = decode_event(r.payload);
          return w.event.kind == EventKind::kStart && w.event.incarnation == 1;
        });
      });
  const std::vector<std::int64_t> cut = RunReader(run).starts();
  REQUIRE(cut.size() == 3);
  CHECK(cut[0] == whole[0]);
  CHECK(cut[1] == whole[2]);
  CHECK(cut[2] == whole[2]);
}

TEST_CASE("Messages of a run are those of its log, each once, in the order of their numbers") {
  const fs::path run = scratch_folder("parts-messages");
  record_tiny_run(run, {.resumes = 1});
  const RunReader messages(run);
  CHECK(messages.damage().empty());
  REQUIRE(messages.starts().size() == 2);
  CHECK(messages.starts()[0] < messages.starts()[1]);
  std::map<std::string, std::vector<std::vector<std::byte>>> logged;
  const record::EventLogFile log(run / "log.lcm");
  record::EventLogReader reader = log.reader();
  while (const auto e = reader.next())
    logged[std::string(e->channel)].emplace_back(e->data.begin(), e->data.end());
  for (const char* channel : {"LAYER_PLAN", "HEIGHT_MAP", "HEIGHT_PROFILE", "PROFILER_COMMAND"}) {
    CAPTURE(channel);
    const auto& found = messages.on(channel);
    REQUIRE(found.size() == logged[channel].size());
    REQUIRE(!found.empty());
    std::int64_t before = 0;
    for (std::size_t n = 0; n < found.size(); ++n) {
      CHECK(same_bytes(found[n], logged[channel][n]));
      CHECK(stamp_of(found[n])->seq > before);
      before = stamp_of(found[n])->seq;
    }
  }
  CHECK(messages.on("NO_CHANNEL").empty());
}

TEST_CASE("A message that its publisher's file lost is taken from a receiver's") {
  const fs::path run = scratch_folder("parts-receiver");
  record_tiny_run(run);
  const std::size_t whole = RunReader(run).on("HEIGHT_MAP").size();
  REQUIRE(whole > 2);
  fs::remove(run / "nodes" / "surface_mapper.wal");
  CHECK(RunReader(run).on("HEIGHT_MAP").size() == whole);
  fs::remove(run / "nodes" / "controller.wal");
  CHECK(RunReader(run).on("HEIGHT_MAP").empty());
  fs::remove_all(run / "nodes");
  CHECK_THROWS_WITH(RunReader(run), Catch::Contains("parts-receiver"));
}

TEST_CASE("However a node's file is cut or damaged, reading it ends, and what is lost is named") {
  const fs::path run = scratch_folder("parts-damage");
  record_tiny_run(run);
  const fs::path path = run / "nodes" / "surface_mapper.wal";
  const std::vector<std::byte> whole = read_bytes(path);
  RandomStream random(64, Purpose::kTest);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::byte> bytes = whole;
    if (trial % 3 == 0)
      bytes.resize(random.below(std::uint32_t(bytes.size())));
    else
      for (std::uint32_t n = trial % 3 == 1 ? 1 : 40; n > 0; --n)
        flip(bytes, random.below(std::uint32_t(bytes.size())), int(random.below(8)));
    write_bytes(path, bytes);
    CAPTURE(trial, bytes.size());
    try {
      WalFile file(path);
      std::size_t items = 0;
      while (file.next() != WalFile::Item::kEnd) REQUIRE(++items < 10000);
      if (trial % 3 == 1) CHECK(RunReader(run).damage().size() + items > 0);
    } catch (const std::exception& e) {
      CHECK(std::string(e.what()).find("surface_mapper.wal") != std::string::npos);
    }
  }
}

TEST_CASE("Means of a field over cells keep its volume, and cells without any of it have no height") {
  RandomStream random(65, Purpose::kTest);
  HeightMap field({40, 30, 0.1, 0.1, 0.05, 0.05});
  double sum = 0.0;
  for (double& h : field.cells) sum += h = random.uniform(-1.0, 2.0);
  const HeightMap means = cell_means(field, {5, 4, 1.0, 1.0, 0.5, 0.5});
  double kept = 0.0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 5; ++i) {
      const bool covered = i < 4 && j < 3;
      REQUIRE(std::isfinite(means.at(i, j)) == covered);
      if (covered) kept += 100.0 * means.at(i, j);
    }
  CHECK(kept == Approx(sum));
}

TEST_CASE("The JSON of a replay's verdict holds what the verdict holds, odd bytes included") {
  RunVerdict v;
  v.nodes = {{"controller", 2, 30, 20, 10, 4096, 1, 3, 4, 2, 17, 1'500'000'000, 0, 99, "step 9: \"no\""}};
  v.provenance = {"commit: recorded a, now b"};
  v.damage = {{"nodes/jet.wal", 12, 34, "checksum does not hold", 7}};
  Finding f;
  f.kind = FindingKind::kOutput;
  f.node = "controller";
  f.step = 5;
  f.channel = "LAYER_PLAN";
  f.seq = 6;
  f.field = "drops[17]";
  f.recorded = "1";
  f.replayed = "\xff\xfe";  // no UTF-8
  f.inputs = {R"({"step": 4})", "no JSON"};
  v.findings = {f};
  v.findings_total = 3;
  v.ignored = {{"iterations", "counts", 8}};
  const Json j = Json::parse(to_json(v));
  CHECK(j.at("identical") == false);
  CHECK(j.at("findings_total") == 3);
  CHECK(j.at("nodes").at(0).at("node") == "controller");
  CHECK(j.at("nodes").at(0).at("recorded_handler_s") == 1.5);
  CHECK(j.at("nodes").at(0).at("crash") == "step 9: \"no\"");
  CHECK(j.at("damage").at(0).at("offset") == 12);
  CHECK(j.at("damage").at(0).at("step") == 7);
  CHECK(j.at("ignored").at(0).at("times") == 8);
  const Json& finding = j.at("findings").at(0);
  CHECK(finding.at("kind") == word(FindingKind::kOutput));
  CHECK(finding.at("field") == "drops[17]");
  CHECK(finding.at("inputs").at(0).at("step") == 4);
  const std::string text = to_text(v);
  CHECK(text.find("first divergence") != text.npos);
  CHECK(text.find("drops[17]") != text.npos);
  CHECK(text.find("2 more") != text.npos);
}

TEST_CASE("Exit status tells what differs from what could not be read") {
  RunVerdict v;
  v.nodes.resize(1);
  CHECK(v.identical());
  CHECK(v.exit_status() == 0);
  v.damage = {{"nodes/jet.wal", 1, 2, "cut", {}}};
  CHECK_FALSE(v.identical());
  CHECK(v.exit_status() == 1);
  v.damage.clear();
  Finding f;
  f.kind = FindingKind::kUnreadable;
  v.findings = {f};
  v.findings_total = 1;
  CHECK(v.exit_status() == 2);
  f.kind = FindingKind::kOutput;
  v.findings.push_back(f);
  v.findings_total = 2;
  CHECK(v.exit_status() == 1);
  CHECK_FALSE(RunVerdict{}.identical());
}

TEST_CASE("Words for kinds of findings and of violations are all different") {
  std::set<std::string> findings, violations;
  for (int n = 0; n <= int(FindingKind::kLog); ++n) findings.insert(word(FindingKind(n)));
  for (int n = 0; n <= int(ViolationKind::kDamaged); ++n) violations.insert(word(ViolationKind(n)));
  CHECK(findings.size() == std::size_t(FindingKind::kLog) + 1);
  CHECK(violations.size() == std::size_t(ViolationKind::kDamaged) + 1);
  CHECK_FALSE(findings.contains(""));
  CHECK_FALSE(violations.contains(""));
}

TEST_CASE("The JSON of an audit lists every violation it kept and every doubt with what resolved it") {
  AuditVerdict v;
  v.layers = 3;
  v.commanded = 100;
  v.with_world = true;
  v.unknowns = {{1, 0, 2, 5, 9, 1000, 44}, {2, 0, 1, 0, 3, 2000, {}}};
  for (int n = 0; n < 30; ++n)
    v.violations.push_back({ViolationKind::kCellTwice, "cell " + std::to_string(n)});
  v.violations_total = 30;
  const Json j = Json::parse(to_json(v));
  CHECK(j.at("clean") == false);
  CHECK(j.at("violations").size() == 30);
  CHECK(j.at("violations").at(29).at("what") == "cell 29");
  CHECK(j.at("unknowns").at(0).at("resolved_by_map") == 44);
  CHECK(j.at("unknowns").at(1).at("resolved_by_map").is_null());
  const std::string text = to_text(v);
  CHECK(text.find("and 10 more") != text.npos);
  CHECK(text.find("not finished") != text.npos);
  CHECK(std::count(text.begin(), text.end(), '\n') >= 1 + 2 + 20);
}

}  // namespace
}  // namespace firn::test
