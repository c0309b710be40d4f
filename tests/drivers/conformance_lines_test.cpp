// The remaining lines that independent code bases give for the instruments, each with its source; see
// conformance_test.cpp. Further sources: [I] ISIS keylkg, [L] LaserMetaData, [D] DESY cmstkmodlab, [Q]
// keyence-lk-g5000, [V] adept_experimental's V+ program of a real Cobra s600, [G] the AdeptNet guide.
#include <catch2/catch.hpp>
#include <cctype>

#include "drivers/jet/jetdrive.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/stage/ensemble.h"
#include "files/text_file.h"
#include "tests/drivers/ice_rig.h"
#include "tests/plant/bench_lines.h"
#include "tests/plant/ice_bench.h"

using namespace firn;
using namespace firn::drivers;
using Catch::Contains;
using firn::drivers::test::IceRig;

namespace {

// A V+ program without its comments.
std::string program(const char* file) {
  std::string code, text = read_file(std::string(FIRN_SOURCE_DIR) + "/drivers/robot/vplus/" + file);
  std::size_t from = 0;
  while (from < text.size()) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const std::string line = text.substr(from, end - from);
    code += line.substr(0, line.find(';')) + "\n";
    from = end + 1;
  }
  return code;
}

std::string lamp_says(plant::Bench& b, const std::string& command) {
  const std::string reply = b.ask(plant::kLampPort, omnicure::frame(command));
  REQUIRE(reply.size() > 3);
  const std::string body = reply.substr(0, reply.size() - 3);
  CHECK(omnicure::frame(body) == reply);
  return body;
}

}  // namespace

TEST_CASE("every bit of AXISFAULT that a driver in use names has that name", "[conformance]") {
  const std::pair<int, const char*> rest[] = {{2, "CW end of travel"},   {3, "CCW end of travel"},
                                              {4, "CW soft limit"},      {5, "CCW soft limit"},
                                              {6, "amplifier"},          {7, "position feedback"},
                                              {15, "external"},          {18, "amplifier temperature"},
                                              {20, "communication lost"}};  // [B]
  for (const auto& [bit, name] : rest) CHECK(ensemble::fault_names(1u << bit) == name);
  CHECK(ensemble::kEnabled == 1u << 0);  // [B], [klauer]
  CHECK(ensemble::kHomed == 1u << 1);
  CHECK(ensemble::kInPosition == 1u << 2);
  CHECK(ensemble::kMoving == 1u << 3);
  CHECK(ensemble::kHoming == 1u << 14);
  CHECK(ensemble::kEstopInput == 1u << 31);
}

TEST_CASE("the stage's twin takes the pulse window and the wait mode of other code bases", "[conformance]") {
  plant::Bench b{plant::WorldConfig{}};
  CHECK(b.stage("PSOWINDOW X 1 RANGE -5,11840163") == "%\n");  // [A]: counts, relative to ARM
  CHECK(b.stage("ENABLE @0") == "%\n");                        // [X M]
  CHECK(b.stage("WAIT MODE INPOS") == "%\n");                  // [R]
  const std::string version = b.stage("VERSION");              // [B X]
  CHECK_THAT(version, Catch::StartsWith("%4.") && Catch::EndsWith("\n"));
}

TEST_CASE("an Ensemble's answers of text and of numbers are told apart", "[conformance]") {
  const ensemble::EnsembleDialect dialect;
  const ensemble::Table table;
  const auto kind = [&](std::string_view reply, ensemble::Format format) {
    const Request asked = ensemble::Line(table, Repeat::kRead, 0, format).text("VERSION").done();
    return dialect.frame(std::as_bytes(std::span(reply.data(), reply.size())), &asked).kind;
  };
  CHECK(kind("%4.07.001\n", ensemble::kText) == Frame::Kind::kReply);  // [B X]
  CHECK(kind("%4.07.001\n", ensemble::kValue) == Frame::Kind::kCorrupt);
  CHECK(kind("%\n", ensemble::kText) == Frame::Kind::kIgnore);  // the value is still to come
  CHECK(kind("!\n", ensemble::kText) == Frame::Kind::kReply);
}

TEST_CASE("the lamp's twin gives each command the answer that another driver expects", "[conformance]") {
  plant::Bench b{plant::WorldConfig{}};
  CHECK(lamp_says(b, "CONN") == "READY");
  for (const char* command :
       {"LOC", "ULOC", "CLR", "STM10", "RUN", "OPN", "CLS", "TON", "SIL50", "SPW5", "SIR1.00", "TOF"}) {
    INFO("[W] " << command);
    CHECK(lamp_says(b, command) == "Received");
  }
  CHECK(lamp_says(b, "CLC") == "Done");  // [W]
  for (const char* command : {"GUS", "GLH", "CLH", "GIL", "GTM", "VEB", "VIO", "GSN", "GLG", "GPW", "GIR",
                              "GIM", "GMP", "GPM", "SPM"}) {
    INFO("[W] " << command << ": an integer");
    const std::string body = lamp_says(b, command);
    CHECK(!body.empty());
    CHECK(std::ranges::all_of(body, [](unsigned char c) { return std::isdigit(c) != 0; }));
  }
  CHECK(lamp_says(b, "XYZ") == "Err");
  CHECK(lamp_says(b, "DCON").starts_with("CLOSE"));  // [W] CLOSED, [P] CLOSE
  const omnicure::Table table;
  for (const std::string& command :
       {table.connect, table.open, table.close, table.iris + "50", table.set_time + "100", table.run,
        table.get_time, table.status, table.version, table.lamp_on, table.lamp_off, table.serial,
        table.hours}) {
    INFO("of the driver's own table: " << command);
    const std::string known = " CONN OPN CLS SIL50 STM100 RUN GTM GUS VEB TON TOF GSN GLH ";
    CHECK_THAT(known, Contains(" " + command + " "));
  }
}

TEST_CASE("storage and value commands of the LK-G family are answered by their names", "[conformance]") {
  using Kind = lkg::Reply::Kind;
  const auto parse = [](std::string_view line, std::string_view command) {
    return lkg::parse(line, command);
  };
  for (const char* command : {"AQ", "AS", "AP"})  // [L], [D]: without arguments, echoed
    CHECK(parse(command, command).kind == Kind::kDone);
  CHECK(parse("SW,CF", "SW,CF,0060000,1").kind == Kind::kDone);  // [L]
  // [L], [Q]: an LK-G5000 is asked for a value by MS,0n, and the value is the last eight characters.
  const lkg::Reply value = parse("MS,+00.1234", "MS,01");
  REQUIRE(value.kind == Kind::kDone);
  CHECK(lkg::parse_value(value.rest.substr(value.rest.size() - lkg::kValueChars)).mm == 0.1234);
  // The codes of sampling [S] are those of an LK-G3001P: 0 to 5 are 20 to 1000 us.
  CHECK(std::size(lkg::kSampling_us) == 6);
  CHECK(lkg::kSampling_us[0] == 20);
  CHECK(lkg::kSampling_us[5] == 1000);
}

TEST_CASE("averaging is sent as asked for, not as one", "[conformance]") {  // the bug of [D]'s driver
  plant::IceBench b{plant::small()};
  CHECK(b.laser("Q0") == "Q0\r");
  for (int k = 0; k <= 9; ++k) CHECK(b.laser(lkg::Table{}.averaging + std::to_string(k)) == "SW,OC\r");
  CHECK(b.laser(lkg::Table{}.averaging + "10") == "ER,OC,22\r");
  IceRig rig;
  rig.start();
  rig.act("laser_point", [&](std::int64_t t, Effects& fx) { rig.laser.arm(0, 10, 0.01, t, fx); });
  REQUIRE(rig.run([&] { return !rig.laser.busy(); }, 30.0));
  CHECK_THAT(rig.written["laser_point"], Contains(lkg::Table{}.averaging + "2\r"));  // laser_point.averaging
}

TEST_CASE("the V+ program speaks to its network as one that has run on a real Cobra", "[conformance]") {
  const std::string firn = program("firn.v2"), lines = program("lines.v2"), motion = program("motion.v2");
  CHECK_THAT(firn, Contains("ATTACH (fv.lun, 4) \"TCP\""));  // [V]
  CHECK_THAT(
      firn,
      Contains("FOPEN (fv.lun, 16) \"/LOCAL_PORT 4096 /CLIENTS 1 /BUFFER_SIZE 1024\""));  // one string [V]
  CHECK_THAT(firn, Contains("got == 100") && Contains("(got == 101) OR (got < 0)"));      // [G]; -562 [V]
  CHECK_THAT(firn, Contains("FCMND (fv.lun, 600) $INTB(fv.client)"));  // frees the client [G]
  const std::size_t select = firn.find("SELECT ROBOT = 1"), attach = firn.find("ATTACH ()");
  CHECK(select < attach);  // [V], before the first motion
  CHECK(attach != std::string::npos);
  CHECK(attach < std::min(firn.find("MOVE"), firn.find("CALIBRATE")));
  CHECK_THAT(firn, Contains("SWITCH(POWER)"));  // [V]
  CHECK_THAT(motion, Contains("STATE(2)") && Contains("ERROR(0)"));
  CHECK_THAT(lines, Contains("WRITE (fv.lun, fv.client)"));  // [V]: the handle is allowed with one client too
}
