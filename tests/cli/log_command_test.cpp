#include "cli/log_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "files/exit_codes.h"
#include "files/json.h"
#include "files/path/layer_file.h"
#include "files/path/trajectory_file.h"
#include "files/record/event_log.h"
#include "files/usage_error.h"
#include "firn/run_start_t.hpp"
#include "runs/folder/log_repair.h"
#include "runtime/wal_file.h"
#include "runtime/write_ahead.h"
#include "tests/files/record/scratch.h"
#include "tests/lcmtypes/samples.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

// A run of ten layers: one write-ahead file of the controller, a log that may lack some plans.
struct RunFiles {
  Scratch scratch{"log-command"};
  std::filesystem::path log = scratch / "log.lcm";
  std::filesystem::path wal = scratch / "nodes" / "controller.wal";

  explicit RunFiles(const std::vector<int>& lost = {}) {
    std::filesystem::create_directories(wal.parent_path());
    record::RecordWriter records(wal, record::RecordWriter::Mode::kCreate);
    record::EventLogWriter events(log);
    std::vector<std::byte> bytes;
    WalHead head;
    head.node = "controller";
    head.run_id = 7;
    head.config_toml = "scheme = \"mpc\"\n";
    encode_head(head, bytes);
    records.append(std::uint16_t(WalKind::kHead), bytes);
    events.append(0, "CONFIG_CONTROLLER", config_message(head));
    Outbox outbox(NodeId::kController, 7);
    for (int layer = 0; layer < 10; ++layer) {
      const std::int64_t now_us = 1'000'000 * (layer + 1);
      const auto map = encode(stamped(some_height_map(6, 5), layer, now_us));
      Event event;
      event.kind = EventKind::kMessage;
      event.now = {now_us};
      event.channel = "HEIGHT_MAP";
      event.bytes = map;
      bytes.clear();
      encode_event(std::uint64_t(layer), event, bytes);
      records.append(std::uint16_t(WalKind::kEvent), bytes);
      outbox.begin({now_us}, 0);
      outbox.send(channels::kLayerPlan, stamped(some_layer_plan(6, 5), layer, now_us));
      outbox.wake_at(TimerId{3}, {now_us + 50});
      bytes.clear();
      encode_outputs(std::uint64_t(layer), 1234, outbox, bytes);
      records.append(std::uint16_t(WalKind::kOutputs), bytes);
      events.append(now_us, "HEIGHT_MAP", map);
      if (std::find(lost.begin(), lost.end(), layer) == lost.end())
        events.append(now_us + 500, "LAYER_PLAN", outbox.at(0).bytes);
    }
    records.close();
    events.close();
  }

  template <class M>
  static M stamped(M m, int layer, std::int64_t now_us) {
    m.header.run_id = 7;
    m.header.incarnation = 0;
    m.header.seq = layer + 1;
    m.header.utime_us = now_us;
    m.layer = layer;
    return m;
  }
  LogOptions options(const std::filesystem::path& file) const {
    LogOptions o;
    o.file = file.string();
    return o;
  }
};

std::vector<Json> cat(const LogOptions& o, int code = kOk) {
  std::ostringstream out, err;
  CHECK(log_cat(o, out, err) == code);
  std::vector<Json> lines;
  std::istringstream in(out.str());
  for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
  return lines;
}

Json verify(LogOptions o, int code) {
  o.json = true;
  std::ostringstream out;
  CHECK(log_verify(o, out) == code);
  return Json::parse(out.str());
}

}  // namespace

TEST_CASE("firn log verify says ok of a whole log and of a whole write-ahead file") {
  const RunFiles run;
  const Json log = verify(run.options(run.log), kOk);
  CHECK(log["ok"] == true);
  CHECK(log["read"] == 21);
  CHECK(log["checked"] == 21);
  CHECK(log["channels"]["LAYER_PLAN"]["messages"] == 10);
  const Json wal = verify(run.options(run.wal), kOk);
  CHECK(wal["kind"] == "write-ahead file");
  CHECK(wal["read"] == 21);
  std::ostringstream text;
  CHECK(log_verify(run.options(run.log), text) == kOk);
  CHECK_THAT(text.str(), Contains("log.lcm: event log") && Contains("21 read, 21 with checksum, 0 lost") &&
                             Contains("ok\n"));
}

TEST_CASE(
    "firn log verify exits 1 and names byte, reason and loss of damage, in log and write-ahead file alike") {
  const RunFiles run;
  for (const auto& path : {run.log, run.wal}) {
    auto bytes = read_bytes(path);
    bytes[bytes.size() / 2] ^= std::byte{4};
    write_file(path, bytes);
    const Json found = verify(run.options(path), kFailed);
    CHECK(found["ok"] == false);
    REQUIRE(found["damage"].size() == 1);
    CHECK(found["damage"][0]["offset"] <= bytes.size() / 2);
    CHECK(found["damage"][0]["reason"].get<std::string>().size() > 5);
  }
}

TEST_CASE("firn log verify names recording gaps and values outside their limits") {
  const RunFiles run({3, 4, 7});
  const Json found = verify(run.options(run.log), kFailed);
  CHECK(found["channels"]["LAYER_PLAN"]["missing"] == 3);
  CHECK_THAT(found["problems"][0].get<std::string>(), Contains("recording gap: 3 messages of LAYER_PLAN"));
  record::EventLogWriter events(run.scratch / "bad.lcm");
  auto bad = some_height_map(6, 5);
  bad.header.seq = 1;
  bad.grid.pitch_x_mm = -1;
  events.append(1, "HEIGHT_MAP", encode(bad));
  events.close();
  CHECK_THAT(verify(run.options(run.scratch / "bad.lcm"), kFailed)["problems"][0].get<std::string>(),
             Contains("event 0: HEIGHT_MAP: byte ") && Contains("grid.pitch_x_mm = -1"));
}

TEST_CASE("firn log verify advises a repair only where the write-ahead files hold what is missing") {
  const RunFiles run({3, 4, 7});
  const auto problem = [&] {
    return verify(run.options(run.log), kFailed)["problems"][0].get<std::string>();
  };
  CHECK_THAT(problem(), Contains("`firn log repair` fills it"));
  const std::vector<std::byte> whole = read_bytes(run.wal);
  record::RecordReader reader(whole);
  std::uint64_t cut = 0;  // behind the outputs of layer 3
  while (const auto r = reader.next())
    if (r->index == 9) cut = r->offset;
  write_file(run.wal, {whole.begin(), whole.begin() + std::ptrdiff_t(cut)});
  CHECK_THAT(problem(), Contains("the write-ahead files hold 1 of them"));
  std::filesystem::remove(run.wal);
  CHECK_THAT(problem(), Contains("no write-ahead file") && !Contains("repair"));
  std::filesystem::remove(run.wal.parent_path());
  CHECK_THAT(problem(), Contains("no write-ahead file") && !Contains("repair"));
}

TEST_CASE("firn log verify rejects a trajectory file without totals, and one with NaN") {
  const RunFiles run;
  const std::filesystem::path file = run.scratch / "x.traj";
  const TrajectoryHead head{"cobra600", "thesis", "test", 0.016, {1, 2}, {"J1"}, {"rad"}};
  PlannedPath path{1, 0, PathKind::kFill, 10.0, {}};
  path.trajectory = {1, 0.016, 1, {"rad"}, {0.1, 0.2, 0.3}, {{{"total speed", 0.9, 0.1}}, 0.048, 0.0, 0.4}};
  const auto write = [&](bool totals, double position) {
    std::filesystem::remove(file);
    path.trajectory.positions[1] = position;
    TrajectoryTotals sums;
    sums.paths = 1;
    sums.samples = 3;
    sums.duration_s = 0.048;
    record::RecordWriter out(file, record::RecordWriter::Mode::kCreate);
    out.append(std::uint16_t(TrajectoryRecord::kHead), encode(head));
    out.append(std::uint16_t(TrajectoryRecord::kPath), encode(path));
    if (totals) out.append(std::uint16_t(TrajectoryRecord::kTotals), encode(sums));
  };
  write(true, 0.2);
  CHECK(verify(run.options(file), kOk)["kind"] == "trajectory file");
  write(false, 0.2);
  CHECK_THAT(verify(run.options(file), kFailed)["problems"][0].get<std::string>(), Contains("no totals"));
  write(true, std::nan(""));
  CHECK_THAT(verify(run.options(file), kFailed)["problems"][0].get<std::string>(),
             Contains("byte ") && Contains("position"));
  std::filesystem::rename(file, run.scratch / "x.trajectories");
  CHECK(verify(run.options(run.scratch / "x.trajectories"), kFailed)["kind"] == "trajectory file");
}

TEST_CASE("firn log cat prints JSON lines, by channel, time and count") {
  const RunFiles run;
  LogOptions o = run.options(run.log);
  auto lines = cat(o);
  REQUIRE(lines.size() == 21);
  CHECK(lines[0]["channel"] == "CONFIG_CONTROLLER");
  CHECK(lines[1]["channel"] == "HEIGHT_MAP");
  CHECK(lines[1]["type"] == "height_map_t");
  CHECK(lines[1]["message"]["grid"]["nx"] == 6);
  CHECK(lines[1]["message"]["height_mm"]["count"] == 30);
  o.channels = {"LAYER_PLAN"};
  o.from_s = 2.5;
  o.to_s = 7.5;
  lines = cat(o);
  CHECK(lines.size() == 5);
  CHECK(lines[0]["message"]["header"]["seq"] == 3);
  o.count = 2;
  o.full = true;
  lines = cat(o);
  CHECK(lines.size() == 2);
  CHECK(lines[1]["message"]["drops"].size() == 30);
}

TEST_CASE("firn log cat shows events and outputs of a write-ahead file with their messages") {
  const RunFiles run;
  auto lines = cat(run.options(run.wal));
  REQUIRE(lines.size() == 21);
  CHECK(lines[0]["kind"] == "head");
  CHECK(lines[0]["node"] == "controller");
  CHECK(lines[1]["event"] == "message");
  CHECK(lines[1]["channel"] == "HEIGHT_MAP");
  CHECK(lines[1]["now_us"] == 1000000);
  CHECK(lines[2]["outputs"][0]["output"] == "send");
  CHECK(lines[2]["outputs"][0]["message"]["objective_mm"] == 0.25);
  CHECK(lines[2]["outputs"][1]["timer"] == 3);
  LogOptions o = run.options(run.wal);
  o.channels = {"LAYER_PLAN"};
  o.to_s = 4;
  CHECK(cat(o).size() == 4);
}

TEST_CASE("firn log cat marks damage, prints what can be read, and exits 1") {
  const RunFiles run;
  auto bytes = read_bytes(run.log);
  bytes[bytes.size() - 5] ^= std::byte{4};
  write_file(run.log, bytes);
  const auto lines = cat(run.options(run.log), kFailed);
  REQUIRE(lines.size() == 21);
  CHECK(lines[20]["damaged"] == true);
}

TEST_CASE("firn log repair fills the log from the write-ahead files beside it") {
  const RunFiles run({3, 4, 7});
  std::ostringstream text;
  CHECK(log_repair(run.options(run.log), text) == kOk);
  CHECK_THAT(
      text.str(),
      Contains("recording gap, repaired: 3 messages of LAYER_PLAN between 4.000000 s and 8.000000 s") &&
          Contains("21 events, repaired"));
  const Json found = verify(run.options(run.log), kOk);
  CHECK(found["channels"]["LAYER_PLAN"]["missing"] == 0);
  LogOptions o = run.options(run.log);
  o.channels = {"LAYER_PLAN"};
  const auto lines = cat(o);
  for (int i = 0; i < 10; ++i) CHECK(lines[std::size_t(i)]["message"]["header"]["seq"] == i + 1);
  std::ostringstream again;
  CHECK(log_repair(run.options(run.log), again) == kOk);
  CHECK_THAT(again.str(), Contains("nothing to repair"));
}

TEST_CASE(
    "firn log repair makes the whole log, configuration and the launcher's messages too, where there is none "
    "or an empty one") {
  for (const bool empty : {false, true}) {
    const RunFiles run;
    {
      record::RecordWriter sent(run.scratch / "nodes" / "launcher.sent", record::RecordWriter::Mode::kCreate);
      Outbox launcher(NodeId::kLauncher, 7);
      launcher.begin({5}, 0);
      launcher.send(channels::kRunStart, run_start_t{});
      std::vector<std::byte> bytes;
      encode_outputs(0, 0, launcher, bytes);
      sent.append(std::uint16_t(WalKind::kOutputs), bytes);
      sent.close();
    }
    std::filesystem::remove(run.log);
    std::filesystem::remove(run.log.string() + ".idx");
    if (empty) write_file(run.log, std::vector<std::byte>{});
    std::ostringstream text;
    CHECK(log_repair(run.options(run.log), text) == kOk);
    CHECK_THAT(text.str(), Contains("12 events, repaired"));  // 10 plans; the maps are another node's
    LogOptions o = run.options(run.log);
    o.full = true;
    const auto lines = cat(o);
    REQUIRE(lines.size() == 12);
    CHECK(lines[0]["channel"] == "CONFIG_CONTROLLER");
    CHECK(lines[0]["message"]["config_toml"] == "scheme = \"mpc\"\n");
    CHECK(lines[1]["channel"] == "RUN_START");
    for (std::size_t i = 2; i < 12; ++i) CHECK(lines[i]["utime_us"] == 1'000'000 * (i - 1));
    CHECK(verify(run.options(run.log), kOk)["checked"] == 12);
  }
  const RunFiles run;
  CHECK_THROWS_WITH(run_log([&] {
                      LogOptions o = run.options(run.scratch / "lgo.lcm");
                      o.action = LogAction::kRepair;
                      return o;
                    }()),
                    Contains("lgo.lcm"));
  CHECK_FALSE(std::filesystem::exists(run.scratch / "lgo.lcm"));
}

TEST_CASE("A log that somebody is writing is not repaired under his hands") {
  const RunFiles run({3});
  const auto before = read_bytes(run.log);
  record::EventLogWriter::Options appending;
  appending.mode = record::File::Mode::kAppend;
  const record::EventLogWriter recorder(run.log, appending);
  CHECK_THROWS_WITH(runs::repair_from_write_ahead(run.log, run.wal.parent_path()),
                    Contains("is being written by another process"));
  CHECK(read_bytes(run.log) == before);
}

TEST_CASE("A file that is not there, or a folder without write-ahead files, is a usage error that names it") {
  const RunFiles run;
  CHECK_THROWS_WITH(run_log(run.options(run.scratch / "none.lcm")),
                    Contains("none.lcm") && Contains("No such file"));
  CHECK_THROWS_AS(run_log(run.options(run.scratch / "none.lcm")), UsageError);
  LogOptions o = run.options(run.log);
  o.sources = (run.scratch / "elsewhere").string();
  std::ostringstream out;
  CHECK_THROWS_AS(log_repair(run.options(run.scratch / "none.lcm"), out), UsageError);
  CHECK_THROWS_WITH(log_repair(o, out), Contains("elsewhere: no folder of write-ahead files"));
  CHECK_THROWS_AS(log_repair(run.options(run.wal), out), UsageError);
}

TEST_CASE("firn log verify tells a whole path file from one that is empty or ends between two layers") {
  const RunFiles run;
  const std::filesystem::path file = run.scratch / "x.paths";
  slice::LayerPaths layer;
  layer.layer = 1;
  layer.z = layer.height = 2500;
  {
    LayerWriter writer(file, {});
    writer.add(slice::encode(layer), layer, {});
    writer.finish();
  }
  std::ostringstream whole;
  CHECK(log_verify(run.options(file), whole) == kOk);
  CHECK_THAT(whole.str(), Contains("path file"));
  const std::vector<std::byte> bytes = read_bytes(file);
  std::size_t ends = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    write_file(file, {bytes.begin(), bytes.begin() + std::ptrdiff_t(size)});
    std::ostringstream out;
    CHECK(log_verify(run.options(file), out) == kFailed);
    ends += out.str().find("it has no totals") != std::string::npos;
  }
  CHECK(ends >= 1);
}
