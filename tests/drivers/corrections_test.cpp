// The project's list of corrected protocols, each row with a test in which what the driver did before fails
// on the corrected twin and today's driver passes; and the rows of the instruments other than the stage.
#include <algorithm>
#include <catch2/catch.hpp>
#include <charconv>
#include <filesystem>
#include <set>
#include <string>

#include "config/devices.h"
#include "drivers/jet/jet.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_point/lkg.h"
#include "files/text_file.h"
#include "tests/drivers/vplus_programs.h"
#include "tests/plant/bench_lines.h"
#include "tests/plant/ice_bench.h"

using namespace firn;
using namespace firn::drivers;
using Catch::Contains;
using firn::drivers::test::calibrate_by;
using firn::drivers::test::ClientEvent;
using firn::drivers::test::serve_network;
using firn::drivers::test::ServedNetwork;

namespace {

struct Correction {
  std::string_view id, what;  ///< its tests are tagged with the id
};
constexpr Correction kCorrections[] = {
    {"stage-absolute", "LINEAR is incremental until ABS"},
    {"stage-home", "HOME keeps some firmware busy: the homing program does not, and is stopped as a program"},
    {"stage-integers", "a controller has 50 global integers as delivered"},
    {"stage-parameters", "counts per unit and soft limits are read and compared"},
    {"stage-ramps", "ramps may be S-shaped until SCURVE 0"},
    {"stage-terminal", "pulses leave by a terminal after PSOOUTPUT CONTROL 1"},
    {"stage-counter", "PSOCOUNT is in no public source: another question, or none"},
    {"lkg-count", "AN answers a flag and a count for each output"},
    {"lkg-dump", "AO answers values without the output's number"},
    {"ljv-frame", "x counts from the head's centre, in the head's sense; z has a sign and a zero"},
    {"ljv-memory", "profiles are read by number from the memory, several in one reply"},
    {"lamp-status", "GUS: nothing is exposed with a lamp that is out, cold or has an alarm"},
    {"lamp-shutter", "GUS: the shutter is seen to open and to close"},
    {"lamp-on", "TON lights a lamp that is out"},
    {"jet-wait", "a JetDrive is deaf for a while after its line is opened"},
    {"jet-verbs", "CONTMODE and SOFTTRIGGER: what a person began is ended"},
    {"jet-cap", "the cap of the amplitude is the head's, a key of the lab"},
    {"robot-open", "FOPEN takes one string, and IOSTAT tells"},
    {"robot-client", "FCMND 600 frees the place of a client that is gone"},
    {"robot-lines", "READ gives what has come, at most 128 characters"},
    {"robot-arm", "SELECT ROBOT and ATTACH before the first motion"},
};

std::set<std::string> tagged_corrections() {
  std::set<std::string> found;
  for (const auto& file : std::filesystem::directory_iterator(FIRN_SOURCE_DIR "/tests/drivers")) {
    if (file.path().extension() != ".cpp") continue;
    const std::string text = read_file(file.path().string());
    constexpr std::string_view kTag = "[corrected:";
    for (std::size_t at = text.find(kTag); at != std::string::npos; at = text.find(kTag, at + 1)) {
      const std::size_t from = at + kTag.size(), end = text.find_first_of("]\"", from);
      if (text[end] == ']') found.insert(text.substr(from, end - from));
    }
  }
  return found;
}

// Readings of the LK-G's lines as they were: one output's count, the output's number before its values.
std::optional<int> old_count(std::string_view rest) {
  int values = -1;
  if (rest.size() < 3 || rest[1] != ',') return std::nullopt;
  const auto [end, error] = std::from_chars(rest.data() + 2, rest.data() + rest.size(), values);
  if (error != std::errc() || end != rest.data() + rest.size()) return std::nullopt;
  return values;
}
std::optional<int> old_dump(std::string_view rest) {
  if (!rest.starts_with("1")) return std::nullopt;
  rest.remove_prefix(1);
  for (int n = 0;; ++n, rest.remove_prefix(9)) {
    if (rest.empty()) return n;
    if (rest.size() < 9 || rest[0] != ',') return std::nullopt;
  }
}

/// A laser of the ice lab that has stored for a second. @returns its replies to AN and AO, without name and
/// CR
std::pair<std::string, std::string> stored_by_laser() {
  plant::IceBench bench{plant::small()};
  bench.robot("HELLO FIRN 1");
  CHECK(bench.laser("AS") == "AS\r");
  CHECK(bench.robot("SIG 4") == "ACK 4");
  bench.run(1'000'000);
  bench.robot("SIG 0");
  const std::string count = bench.laser("AN");
  bench.laser("AP");
  const std::string dump = bench.laser("AO,1");
  REQUIRE(count.starts_with("AN,"));
  REQUIRE(dump.starts_with("AO,"));
  return {count.substr(3, count.size() - 4), dump.substr(3, dump.size() - 4)};
}

/// The old driver of the lamp, which exposes for half a second and asks for no status.
struct OldLamp {
  plant::Bench bench{plant::WorldConfig{}};
  std::string not_received;

  OldLamp() {
    CHECK(say("CONN") == "READY");
    received("CLS");
    say("VEB");
  }
  std::string say(const std::string& text) {
    const std::string answer = bench.ask(plant::kLampPort, omnicure::frame(text));
    return answer.substr(0, answer.size() - 3);
  }
  void received(const std::string& text) {
    if (say(text) != "Received") not_received += text + " ";
  }
  /// @returns the dose as the world has it
  double expose() {
    for (const char* text : {"SIL80", "STM5"}) received(text);
    CHECK(say("GTM") == "5");
    received("RUN");
    bench.run(700'000);
    received("CLS");
    const auto& events = bench.record.history.lamp;
    return events.empty() ? 0.0 : events.back().dose_s;
  }
  void trip(std::int64_t code) {
    bench.world.inject({"lamp", plant::FaultKind::kTrip, code, 0}, bench.now_us);
  }
};

std::string_view request_text(const Request& r) { return r.text(); }

bool jet_fires_on(plant::Bench& bench) {
  const std::string poll = bench.ask(plant::kJetPort, plant::hex("53 02 02 04"));
  return poll.size() == 4 && (poll[2] & 1) != 0;
}

// The link of the V+ program as it was: a READ is a line.
constexpr std::string_view kOldLink = R"(
.PROGRAM fv.link()
	AUTO $line, $body, star, ahead, got
	ATTACH (fv.lun, 4) "TCP"
	FOPEN (fv.lun, 16) "FIRN", "/LOCAL_PORT 4096 /CLIENTS 1 /BUFFER_SIZE 4096"
	WHILE TRUE DO
		READ (fv.lun, fv.client, 1) $line
		got = IOSTAT(fv.lun)
		IF got == -526 THEN
			CALL fv.events()
			WAIT
			NEXT
		END
		IF got == 100 THEN
			NEXT
		END
		IF (got == 101) OR (got < 0) THEN
			CALL fv.halted(40)
			WAIT
			NEXT
		END
		star = POS($line,"*",1)
		IF (star < 4) OR (ASC($line,1) <> ASC("@",1)) THEN
			NEXT
		END
		$body = $MID($line,2,star-2)
		CALL fv.match($body, $MID($line,star+1,4), ahead)
		IF NOT ahead THEN
			NEXT
		END
	END
.END
)";
constexpr std::string_view kOldMain = R"(
.PROGRAM a.firn()
	SIGNAL -1, -2, -3, -4
	EXECUTE 1 fv.link()
	EXECUTE 2 fv.watch()
	WHILE TRUE DO
		CASE fv.req OF
		  VALUE 4:
			CALIBRATE
			fv.req = 0
		  ANY
			WAIT
		END
	END
.END
)";

std::string old_link_that_opens() {
  std::string link(kOldLink);
  const std::string two = "\"FIRN\", \"/LOCAL_PORT";
  return link.replace(link.find(two), two.size(), "\"/LOCAL_PORT");
}
std::string todays_program() { return read_file(FIRN_SOURCE_DIR "/drivers/robot/vplus/firn.v2"); }

const ClientEvent kComes{ClientEvent::Kind::kComes, ""}, kGoes{ClientEvent::Kind::kGoes, ""};
ClientEvent sends(const std::string& bytes) { return {ClientEvent::Kind::kSends, bytes}; }

}  // namespace

TEST_CASE("every row of the corrected protocols has its test, and every such test its row", "[corrected]") {
  std::set<std::string> listed;
  for (const Correction& c : kCorrections) {
    CHECK(!c.what.empty());
    listed.emplace(c.id);
  }
  CHECK(listed.size() == std::size(kCorrections));
  CHECK(tagged_corrections() == listed);
}

TEST_CASE("the laser's count has a number for each output, which the old reading refuses",
          "[laser_point][corrected:lkg-count]") {
  const std::string count = stored_by_laser().first;
  CHECK_FALSE(old_count(count));
  CHECK(old_count("0,500") == 500);  // as it expected
  const auto now = lkg::parse_stored(count);
  REQUIRE(now);
  CHECK(now->values > 100);
}

TEST_CASE("the laser's dump begins with its first value, and the old reading finds no number of an output",
          "[laser_point][corrected:lkg-dump]") {
  const auto [count, dump] = stored_by_laser();
  CHECK_FALSE(old_dump(dump));
  CHECK(old_dump("1,+01.2345,-00.0120") == 2);
  std::vector<float> mm;
  CHECK(lkg::parse_dump(dump, mm) == 0);
  CHECK(int(mm.size()) == lkg::parse_stored(count)->values);
}

TEST_CASE("a lamp that is out receives every word of the old driver's exposure, and cures nothing",
          "[lamp][corrected:lamp-status]") {
  OldLamp lit;
  CHECK(lit.expose() == Approx(0.4).margin(0.02));
  OldLamp out;
  out.trip(2);
  CHECK(out.expose() == 0.0);
  CHECK(out.not_received.empty());
}

TEST_CASE("a shutter that stays closed receives every word of the old driver's exposure",
          "[lamp][corrected:lamp-shutter]") {
  OldLamp stuck;
  stuck.trip(3);
  CHECK(stuck.expose() == 0.0);
  CHECK(stuck.not_received.empty());
}

TEST_CASE("the old driver never lights a lamp that is out, however often it exposes",
          "[lamp][corrected:lamp-on]") {
  OldLamp out;
  out.trip(2);
  for (int n = 0; n < 3; ++n) CHECK(out.expose() == 0.0);
  out.received("TON");
  CHECK(out.expose() > 0.0);
}

TEST_CASE("a JetDrive whose line was just opened does not hear the old driver, and hears today's",
          "[jet][corrected:jet-wait]") {
  plant::WorldConfig config;
  config.jet.settle_us = 400'000;
  plant::Bench old(config);
  old.run(50'000);  // as long as it waited
  CHECK(old.ask(plant::kJetPort, "Q", 3'000'000).empty());

  const PortAddress address = parse_port_address("serial:/dev/ttyUSB0", *port_defaults("jet"));
  plant::Bench today(config);
  today.run(address.open_wait_ms * 1000);
  CHECK(today.ask(plant::kJetPort, "Q") == ">");
}

TEST_CASE("the old driver's stop leaves a jet firing that a person has set going",
          "[jet][corrected:jet-verbs]") {  // today's ends it: service_test.cpp
  plant::Bench bench{plant::WorldConfig{}};
  plant::start_jet(bench);
  bench.ask(plant::kJetPort, plant::hex("53 03 04 01 08"));  // CONTMODE 1
  bench.ask(plant::kJetPort, plant::hex("53 02 09 0B"));     // SOFTTRIGGER
  bench.ask(plant::kJetPort, plant::hex("53 03 08 00 0B"));  // SOURCE 0, all of its stop
  CHECK(jet_fires_on(bench));
}

TEST_CASE("a head that bears less than the old fixed cap is abused by it, and the cap of today is the lab's",
          "[jet][corrected:jet-cap]") {
  plant::WorldConfig config;
  config.jet.max_v = 40.0;
  jetdrive::Waveform waveform = jetdrive::waveform_of(JetConfig{});
  waveform.dwell_v = 60;
  JetDialect old_cap;
  old_cap.max_abs_v = 100;
  CHECK(jetdrive::waveform_refusal(waveform, old_cap).empty());
  plant::Bench bench(config);
  plant::start_jet(bench);
  const auto abuses = [&] {
    return std::ranges::count(bench.record.history.devices, plant::DeviceEvent::kJetAbused,
                              &plant::DeviceRecord::event);
  };
  CHECK(abuses() == 0);
  bench.ask(plant::kJetPort, request_text(jetdrive::pulse(waveform)));
  CHECK(abuses() == 1);

  JetOptions lab;
  lab.dwell_v = 60.0;
  lab.dialect.max_abs_v = 40;
  CHECK_THROWS_WITH(Jet(lab), Contains("dwell voltage 60 V is beyond +-40 V"));
}

TEST_CASE("the old V+ program opens its port with two strings, and nobody is ever heard",
          "[robot][corrected:robot-open]") {
  const std::vector<ClientEvent> coming{kComes, sends("@1 HELLO FIRN 1*0000\r\n")};
  const ServedNetwork old = serve_network(std::string(kOldLink), coming);
  CHECK(old.heard.empty());
  CHECK(old.typed.empty());  // and it says nothing
  CHECK(serve_network(todays_program(), coming).heard == std::vector<std::string>{"1 HELLO FIRN 1"});

  std::string closed = todays_program();
  const std::string one = "(fv.lun, 16) \"/LOCAL_PORT";
  closed.replace(closed.find(one), one.size(), "(fv.lun, 16) \"FIRN\", \"/LOCAL_PORT");
  CHECK(serve_network(closed, coming).typed.size() == 1);  // today's would say so
}

TEST_CASE("the old V+ program never lets a second client in", "[robot][corrected:robot-client]") {
  const std::vector<ClientEvent> coming{kComes, sends("@1 HELLO FIRN 1*0000\r\n"), kGoes, kComes,
                                        sends("@2 STAT*0000\r\n")};
  CHECK(serve_network(old_link_that_opens(), coming).heard == std::vector<std::string>{"1 HELLO FIRN 1"});
  for (const int gone : {101, -562})
    CHECK(serve_network(todays_program(), coming, gone).heard ==
          std::vector<std::string>{"1 HELLO FIRN 1", "2 STAT"});
}

TEST_CASE("the old V+ program takes a READ for a line and loses those that come together or in parts",
          "[robot][corrected:robot-lines]") {
  std::vector<std::string> said;
  std::string bytes;
  for (int n = 1; n <= 12; ++n) {
    said.push_back(std::to_string(n) + " PATH P " + std::string(std::size_t(5 * n), '7'));
    bytes += "@" + said.back() + "*0000\r\n";
  }
  for (const std::size_t piece : {1, 7, 40, 128, 1000}) {
    std::vector<ClientEvent> coming{kComes};
    for (std::size_t at = 0; at < bytes.size(); at += piece) coming.push_back(sends(bytes.substr(at, piece)));
    INFO("pieces of " << piece);
    CHECK(serve_network(todays_program(), coming).heard == said);
    CHECK(serve_network(old_link_that_opens(), coming).heard.size() < said.size());
  }
}

TEST_CASE("the old V+ program calibrates an arm that it has not attached", "[robot][corrected:robot-arm]") {
  CHECK(calibrate_by(std::string(kOldMain)).times == 0);
  CHECK_THAT(calibrate_by(std::string(kOldMain)).stopped_by, Contains("no robot is attached"));
  CHECK(calibrate_by(todays_program()).times == 1);
}
