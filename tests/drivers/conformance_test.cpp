// Dialogues and values that independent code bases give for the instruments, each with its source, against
// codec and twin. Sources: [B] ESRF bliss aerotech.py, [X] XNIG aerotech.py, [A] APS 2-BM PSO script, [M]
// EPICS motorAerotech, [R] MSSL/RAL Ensemble emulator, [W] SweepMe! driver of the OmniCure S2000.
#include <catch2/catch.hpp>

#include "drivers/lamp/omnicure.h"
#include "drivers/stage/ensemble.h"
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::drivers;

namespace {

Frame::Kind kind_of(std::string_view reply, ensemble::Format format) {
  const ensemble::EnsembleDialect dialect;
  const ensemble::Table table;
  const Request asked = ensemble::Line(table, Repeat::kRead, 0, format).text("X").done();
  return dialect.frame(std::as_bytes(std::span(reply.data(), reply.size())), &asked).kind;
}

std::uint32_t bits_of(std::string_view reply) {
  const ensemble::EnsembleDialect dialect;
  return dialect.parse(std::as_bytes(std::span(reply.data(), reply.size()))).bits().value_or(0);
}

}  // namespace

TEST_CASE("the Ensemble codec reads the replies that other code bases give", "[conformance]") {
  struct Case {
    const char* source;
    std::string_view reply;
    ensemble::Format format;
    Frame::Kind kind;
  };
  using Kind = Frame::Kind;
  for (const Case& c : std::initializer_list<Case>{
           {"[B] a command ends with one % and a line end", "%\n", ensemble::kAcknowledge, Kind::kReply},
           {"[M] a word that is no command is answered", "!\n", ensemble::kAcknowledge, Kind::kReply},
           {"[M] a fault", "#\n", ensemble::kAcknowledge, Kind::kReply},
           {"[M] the controller's timeout", "$\n", ensemble::kValue, Kind::kReply},
           {"[B] CMDPOS", "%10.000\n", ensemble::kValue, Kind::kReply},
           {"[M] % alone, then the value", "%\n", ensemble::kValue, Kind::kIgnore},
           {"[R] a carriage return before the line end", "%10.000\r\n", ensemble::kValue, Kind::kReply},
           {"[X] AXISSTATUS of an emergency stop", "%-2147483641\n", ensemble::kValue, Kind::kReply},
           {"a value that nobody asked for", "%6\n", ensemble::kAcknowledge, Kind::kCorrupt},
           {"a line of another instrument", "READY0A\n", ensemble::kValue, Kind::kCorrupt}}) {
    INFO(c.source);
    CHECK(kind_of(c.reply, c.format) == c.kind);
  }
}

TEST_CASE("the bits of AXISSTATUS and AXISFAULT are those of other code bases", "[conformance]") {
  CHECK((bits_of("%6\n") & ensemble::kHomed) != 0);  // [R]: homed and in position, not enabled
  CHECK((bits_of("%6\n") & ensemble::kInPosition) != 0);
  CHECK((bits_of("%6\n") & ensemble::kEnabled) == 0);
  const std::uint32_t stopped = bits_of("%-2147483641\n");  // [X]: bit 31 with 0, 1, 2
  CHECK(stopped == (ensemble::kEstopInput | ensemble::kEnabled | ensemble::kHomed | ensemble::kInPosition));
  const std::pair<int, const char*> faults[] = {
      {0, "position error"},    {1, "over-current"},      {8, "velocity feedback"}, {9, "hall sensor"},
      {10, "maximum velocity"}, {11, "emergency stop"},   {12, "velocity error"},   {17, "motor temperature"},
      {19, "encoder"},          {23, "feedback scaling"}, {24, "marker search"},    {27, "voltage clamp"},
      {28, "power supply"},     {30, "internal"}};  // [B]
  for (const auto& [bit, name] : faults) CHECK(ensemble::fault_names(1u << bit) == name);
}

TEST_CASE("the stage's twin answers as the Ensembles of other code bases do", "[conformance]") {
  plant::Bench b{plant::WorldConfig{}};
  struct Exchange {
    const char* source;
    const char* sent;
    std::string_view reply;
  };
  for (const Exchange& e :
       std::initializer_list<Exchange>{{"[M] a probe that is no command", "NONE", "!\n"},
                                       {"[B X M]", "WAIT MODE NOWAIT", "%\n"},
                                       {"[R] not homed, not enabled", "AXISSTATUS X", "%0\n"},
                                       {"[B R] names of axes", "ENABLE X", "%\n"},
                                       {"[X M] numbers of axes", "ENABLE @1", "%\n"},
                                       {"[B]", "ENABLE Z", "%\n"},
                                       {"[B]", "RAMP MODE RATE", "%\n"},
                                       {"[M] CountsPerUnit", "GETPARM(@0, 2)", "%10000.000000\n"},
                                       {"[X] homes by ASCII", "HOME @0", "%\n"}}) {
    INFO(e.source << ": " << e.sent);
    CHECK(b.stage(e.sent) == e.reply);
  }
  while (b.stage("PLANESTATUS(0)") != "%0\n") b.run(2000);
  CHECK(b.stage("AXISSTATUS X") == "%7\n");
  for (const char* move : {"MOVEABS X 10.000000 XF 5.000000", "MOVEABS X 10 XF10.0", "MOVEABS @0 10 @0F 5"}) {
    INFO("[B], [R], [X]: " << move);
    CHECK(b.stage(move) == "%\n");
    while (b.stage("PLANESTATUS(0)") != "%0\n") b.run(2000);
    for (const char* question : {"CMDPOS(X)", "PFBK(X)", "PFBK X", "PFBKCAL(@0)", "PFBKPROG(@0)"})
      CHECK(b.stage(question) == "%10.000000\n");
    b.stage("MOVEABS X 0 F50");
    while (b.stage("PLANESTATUS(0)") != "%0\n") b.run(2000);
  }
  CHECK(b.stage("PSOOUTPUT X CONTROL 1") == "%\n");   // [A]
  CHECK(b.stage("PSODISTANCE X FIXED 33") == "%\n");  // [A]: counts when UNITS is absent
  CHECK(b.stage("LINEAR @0 999 F10") == "%\n");
  CHECK(b.stage("AXISFAULT @0") == "%16\n");  // [M] with and without brackets
  CHECK(b.stage("ACKNOWLEDGEALL") == "%\n");  // [B X R]
  CHECK(b.stage("AXISFAULT(@0)") == "%0\n");
  CHECK(b.stage("FREERUN X 0") == "%\n");  // [B]
}

TEST_CASE("OmniCure lines and status bits are those of another driver", "[conformance]") {
  for (const std::string_view line :  // [W], checksums computed by the published polynomial
       {"CONN18", "READY0A",  "OPN40", "CLS3A", "DCONE1", "ReceivedBF", "CLOSED42",
        "Err67",  "STM10066", "RUNE5", "GTMBC", "100E6",  "GUSFA",      "1895",
        "22BE",   "SIL504E",  "TON3F", "TOFFD", "VEB34",  "CLR64",      "DoneC8"}) {
    const std::string_view text = line.substr(0, line.size() - 2);
    CHECK(omnicure::frame(text) == std::string(line) + "\r");
  }
  CHECK(omnicure::trouble(18).empty());  // burns and is warm
  CHECK(omnicure::trouble(18 | 4).empty());
  CHECK(omnicure::trouble(16) == "it does not burn");
  CHECK(omnicure::trouble(18 | 1) == "it has an alarm");
  CHECK(omnicure::trouble(18 | 8) == "its shutter has a fault");
  CHECK(omnicure::trouble(18 | 128) == "it has an exposure fault");
  CHECK(omnicure::trouble(18 | 32 | 64).empty());  // panel locked, calibrated
}
