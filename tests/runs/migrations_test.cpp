// Messages of earlier versions as today's types, and the requirements for a change of a message.
#include <catch2/catch.hpp>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "firn/answer_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/validate.h"
#include "runs/folder/recorded_steps.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/companions.h"
#include "runs/read/run_reader.h"

namespace firn::replay {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

const fs::path kTwoInks = FIRN_SOURCE_DIR "/tests/replay/golden/v2-two-inks";
const fs::path kOneInk = FIRN_SOURCE_DIR "/tests/replay/golden/v1-mpc";

// Returns the messages that a node of a run sent, as recorded.
std::map<std::string, std::vector<Bytes>> recorded_by(const fs::path& run, const std::string& node) {
  std::map<std::string, std::vector<Bytes>> sent;
  runs::WalFile file(run / "nodes" / (node + ".wal"));
  for (runs::WalFile::Item item = file.next(); item != runs::WalFile::Item::kEnd; item = file.next()) {
    if (item != runs::WalFile::Item::kStep || !file.step().has_outputs) continue;
    for (const Output& o : decode_output_list(file.step().outputs))
      if (o.kind == OutputKind::kSend)
        sent[std::string(o.channel)].emplace_back(o.bytes.begin(), o.bytes.end());
  }
  return sent;
}

template <class M>
M decoded(std::span<const std::byte> bytes) {
  M m{};
  REQUIRE(m.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
  return m;
}

template <class M>
std::vector<M> all(const runs::RunReader& messages, std::string_view channel) {
  std::vector<M> found;
  messages.each<M>(channel, [&](const M& m) { found.push_back(m); });
  return found;
}

Event delivery(std::string_view channel, const Bytes& bytes) {
  Event e;
  e.kind = EventKind::kMessage;
  e.channel = channel;
  e.bytes = bytes;
  return e;
}

}  // namespace

TEST_CASE("Every recorded type has a way to a type of today") {
  for (const auto& [fingerprint, first] : runs::MigrationTable::builtin().steps()) {
    const schema::Type* type = &*first.from;
    for (const runs::MigrationStep* step = &first; step;) {
      REQUIRE(step->to);
      type = step->to;
      const auto next = runs::MigrationTable::builtin().steps().find(type->fingerprint);
      step = next == runs::MigrationTable::builtin().steps().end() ? nullptr : &next->second;
    }
    INFO(type->name);
    CHECK(Schema::builtin().find(type->name) == type);
  }
}

TEST_CASE("Every message that a golden run recorded is one of today, within its limits") {
  for (const auto& run : fs::directory_iterator(FIRN_SOURCE_DIR "/tests/replay/golden")) {
    if (!run.is_directory()) continue;
    const runs::RunReader messages(run.path());
    std::size_t count = 0;
    for (const ChannelInfo& channel : channel_table())
      for (const auto bytes : messages.on(channel.name)) {
        INFO(run.path().string());
        CHECK(validate(channel, bytes).value_or("") == "");
        ++count;
      }
    CHECK(count > 100);
  }
}

TEST_CASE(
    "Plans and passes recorded before droplets had places have all of them in the centres, and all else") {
  std::size_t plans = 0, passes = 0;
  for (const fs::path& run : {kTwoInks, kOneInk}) {
    for (const layer_plan_t& p : all<layer_plan_t>(runs::RunReader(run), "LAYER_PLAN")) {
      CHECK(p.n_offset == 0);
      CHECK(p.offset.empty());
      CHECK((run == kOneInk || p.n == 0 || p.n_material == p.n || p.passes == 0));
      ++plans;
    }
    for (const stage_command_t& c : all<stage_command_t>(runs::RunReader(run), "STAGE_COMMAND")) {
      CHECK(c.n_offset == 0);
      CHECK(c.apart_mm == 0.0);
      passes += c.n > 0;
    }
  }
  CHECK(plans > 4);
  CHECK(passes > 4);
}

TEST_CASE("A fault and an answer recorded before they had figures have none, and all else") {
  const auto recorded = recorded_by(kTwoInks, "jet").at("ANSWER_JET");
  const auto answers = all<answer_t>(runs::RunReader(kTwoInks), "ANSWER_JET");
  REQUIRE(answers.size() == recorded.size());
  for (std::size_t n = 0; n < answers.size(); ++n) {
    const runs::MessageFields old(*runs::MigrationTable::builtin().type_of(recorded[n]), recorded[n]);
    CHECK(answers[n].counted == old.integer("counted"));
    CHECK(answers[n].figure.known == 0);
  }
  std::size_t faults = 0;
  for (const auto& run : fs::directory_iterator(FIRN_SOURCE_DIR "/tests/replay/golden")) {
    if (!run.is_directory()) continue;
    for (const NodeInfo& node : nodes())
      for (const fault_t& f : all<fault_t>(runs::RunReader(run.path()), channels::fault(node.id).name)) {
        ++faults;
        CHECK_FALSE(f.text.empty());
        CHECK(f.node == node.name);
        CHECK(f.figure.known == 0);
        CHECK((f.figure.value == 0.0 && f.figure.limit == 0.0 && f.figure.unit.empty() &&
               f.figure.key.empty()));
      }
  }
  CHECK(faults > 0);
}

TEST_CASE("PASS_DETAIL of a recorded pass is part of its report") {
  const auto recorded = recorded_by(kTwoInks, "scheduler");
  const auto reports = all<deposition_report_t>(runs::RunReader(kTwoInks), "DEPOSITION_REPORT");
  const std::vector<Bytes>& details = recorded.at("PASS_DETAIL");
  REQUIRE(reports.size() == details.size());
  for (std::size_t n = 0; n < reports.size(); ++n) {
    const runs::MessageFields detail(*runs::MigrationTable::builtin().type_of(details[n]), details[n]);
    CHECK(reports[n].pass_index == detail.integer("pass"));
    CHECK(reports[n].material == detail.integer("material"));
    CHECK(reports[n].round == detail.integer("round"));
    CHECK(reports[n].sub_pattern == detail.integer("sub_pattern"));
    CHECK(reports[n].sub_patterns == detail.integer("sub_patterns"));
    CHECK(reports[n].cured == detail.integer("cured"));
  }
  for (const deposition_report_t& r :
       all<deposition_report_t>(runs::RunReader(kOneInk), "DEPOSITION_REPORT")) {
    CHECK(r.material == 1);
    CHECK(r.round == r.pass_index);
    CHECK(r.sub_patterns == 1);
    CHECK(r.cured == 1);
  }
}

TEST_CASE("MATERIAL_MAP of a recorded plan is part of the plan") {
  const auto recorded = recorded_by(kTwoInks, "controller");
  std::size_t with_inks = 0;
  for (const layer_plan_t& plan : all<layer_plan_t>(runs::RunReader(kTwoInks), "LAYER_PLAN")) {
    if (plan.material.empty()) continue;
    const Bytes& bytes = recorded.at("MATERIAL_MAP").at(with_inks++);
    const runs::MessageFields map(*runs::MigrationTable::builtin().type_of(bytes), bytes);
    CHECK(plan.map_id == map.integer("map_id"));
    CHECK(plan.material == map.small_integers("material"));
  }
  CHECK(with_inks == recorded.at("MATERIAL_MAP").size());
  for (const layer_plan_t& plan : all<layer_plan_t>(runs::RunReader(kOneInk), "LAYER_PLAN"))
    CHECK(plan.material.empty());
}

TEST_CASE("The counts of a recorded pass become the cells that it fires") {
  const auto recorded = recorded_by(kTwoInks, "scheduler").at("STAGE_COMMAND");
  const auto commands = all<stage_command_t>(runs::RunReader(kTwoInks), "STAGE_COMMAND");
  REQUIRE(commands.size() == recorded.size());
  std::int64_t fired = 0;
  for (std::size_t n = 0; n < commands.size(); ++n) {
    const runs::MessageFields old(*runs::MigrationTable::builtin().type_of(recorded[n]), recorded[n]);
    const std::vector<std::int8_t> counts = old.small_integers("drops");
    REQUIRE(commands[n].fires.size() == counts.size());
    for (std::size_t c = 0; c < counts.size(); ++c) {
      CHECK(commands[n].fires[c] == (counts[c] > commands[n].pass_index));
      fired += commands[n].fires[c];
    }
  }
  CHECK(fired > 0);
}

TEST_CASE("A node that waited for two messages is given the one when the second came, in either order") {
  const auto recorded = recorded_by(kTwoInks, "controller");
  const Bytes &map = recorded.at("MATERIAL_MAP").front(), &plan = recorded.at("LAYER_PLAN").front();
  const runs::RunMigration run = runs::migration_of(kTwoInks);
  for (const bool plan_first : {false, true}) {
    std::deque<Bytes> kept;
    runs::NodeMigration node(run, "scheduler", kept);
    const Event first = node.event(plan_first ? delivery("LAYER_PLAN", plan) : delivery("MATERIAL_MAP", map));
    const Event second =
        node.event(plan_first ? delivery("MATERIAL_MAP", map) : delivery("LAYER_PLAN", plan));
    CHECK(first.channel == runs::NodeMigration::kNotGiven);
    REQUIRE(second.channel == "LAYER_PLAN");
    CHECK_FALSE(decoded<layer_plan_t>(second.bytes).material.empty());
    CHECK(node.event(delivery("LAYER_PLAN", plan)).channel == "LAYER_PLAN");  // sent again after a resume
  }
  std::deque<Bytes> kept;
  runs::NodeMigration other(run, "droplet_estimator", kept);
  CHECK(other.event(delivery("LAYER_PLAN", plan)).channel == "LAYER_PLAN");
}

TEST_CASE("Recorded outputs lose the messages of retired channels and keep their order") {
  const auto recorded = recorded_by(kTwoInks, "controller");
  Output map, plan, timer;
  map.channel = "MATERIAL_MAP";
  map.bytes = recorded.at("MATERIAL_MAP").front();
  plan.channel = "LAYER_PLAN";
  plan.bytes = recorded.at("LAYER_PLAN").front();
  timer.kind = OutputKind::kArm;
  std::vector<Output> outputs{timer, map, plan};
  const runs::RunMigration run = runs::migration_of(kTwoInks);
  std::deque<Bytes> kept;
  runs::NodeMigration(run, "controller", kept).outputs(outputs);
  REQUIRE(outputs.size() == 2);
  CHECK(outputs[0].kind == OutputKind::kArm);
  CHECK(outputs[1].channel == "LAYER_PLAN");
  CHECK_FALSE(decoded<layer_plan_t>(outputs[1].bytes).material.empty());
}

TEST_CASE("A member is added with the .lcm and one row: messages of every version become today's") {
  const Schema today = Schema::parse(
      "package firn; struct oven_t { int64_t seq; double degC; int8_t mode; int32_t zones; int8_t on[zones]; "
      "}");
  const runs::Migration rows[] = {
      {"struct oven_t { int64_t seq; double degC; }",
       [](const runs::MessageFields&, const runs::MessageFields*, runs::NewFields& now) {
         now.set("mode", 2);
       }},
      {"struct oven_t { int64_t seq; double degC; int8_t mode; }",
       [](const runs::MessageFields& old, const runs::MessageFields*, runs::NewFields& now) {
         const std::vector<std::int8_t> on{std::int8_t(old.integer("mode") > 0), 0};
         now.set("zones", std::int64_t(on.size()));
         now.set("on", on);
       }},
  };
  const runs::MigrationTable table(rows, {}, today);
  REQUIRE(table.steps().size() == 2);
  const runs::RunMigration run(table);
  const auto message = [](const schema::Type& type, std::initializer_list<int> body) {
    Bytes bytes;
    for (int shift = 56; shift >= 0; shift -= 8)
      bytes.push_back(std::byte(std::uint64_t(type.fingerprint) >> shift));
    for (const int b : body) bytes.push_back(std::byte(b));
    return bytes;
  };
  for (const auto& [fingerprint, step] : table.steps()) {
    const bool first = step.row == &rows[0];
    const Bytes old = first ? message(*step.from, {0, 0, 0, 0, 0, 0, 0, 7, 0x40, 0x45, 0, 0, 0, 0, 0, 0})
                            : message(*step.from, {0, 0, 0, 0, 0, 0, 0, 7, 0x40, 0x45, 0, 0, 0, 0, 0, 0, 0});
    Bytes into;
    const auto now = run.today(old, into);
    REQUIRE(table.type_of(now) == today.find("oven_t"));
    CHECK(firn::to_json(*today.find("oven_t"), now) ==
          (first ? R"({"seq":7,"degC":42,"mode":2,"zones":2,"on":[1,0]})"
                 : R"({"seq":7,"degC":42,"mode":0,"zones":2,"on":[0,0]})"));
    const auto cut = std::span(old).first(old.size() - 1);  // damaged: as it is
    CHECK(run.today(cut, into).data() == cut.data());
  }
  const runs::Migration forgotten[] = {
      {"struct oven_t { int64_t seq; }",
       [](const runs::MessageFields&, const runs::MessageFields*, runs::NewFields&) {}}};
  const runs::MigrationTable incomplete(forgotten, {}, today);
  const runs::MigrationStep& step = incomplete.steps().begin()->second;
  const Bytes old = message(*step.from, {0, 0, 0, 0, 0, 0, 0, 7});
  CHECK_THROWS_WITH(runs::NewFields(*step.to).encode(runs::MessageFields(*step.from, old)),
                    Catch::Matchers::Contains("oven_t.degC is new, and its migration does not give it"));
}

}  // namespace firn::replay
