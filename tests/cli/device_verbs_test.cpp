// firn device: the orders of a person to each instrument, as a user types them.
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/png.h"
#include "files/json.h"
#include "files/text_file.h"
#include "print/bringup/raw_line.h"
#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "runtime/run_clock.h"
#include "tests/cli/run_firn.h"
#include "tests/live/port_bridge.h"

extern char** environ;

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

namespace fs = std::filesystem;

Said device_verb(std::vector<std::string> words) {
  words.insert(words.begin(), "device");
  return firn_says(words);
}

Json asked(std::vector<std::string> words) {
  words.push_back("--json");
  const Said said = device_verb(words);
  CAPTURE(words, said.err);
  REQUIRE(said.code == 0);
  return Json::parse(said.out);
}

std::string port_option(const std::string& node, const std::string& address) {
  return "devices." + node + ".port=\"" + address + "\"";
}

// The three that a trigger line couples, behind the sockets of `world`.
std::vector<std::string> coupled(const SimulatedInstruments& world) {
  std::vector<std::string> words;
  for (const char* node : {"stage", "jet", "laser_profiler"})
    words.insert(words.end(), {"--set", port_option(node, to_text(world.address(node)))});
  return words;
}

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace

TEST_CASE("every verb of every instrument is carried out in the simulated labs", "[device]") {
  const std::pair<std::string, std::vector<std::vector<std::string>>> all[] = {
      {kInkjet,
       {{"stage", "jog", "1", "-1", "0.5", "10"},
        {"stage", "where"},
        {"stage", "params"},
        {"stage", "pulse", "5", "0.5"},
        {"jet", "fire", "10"},
        {"lamp", "on"},
        {"lamp", "iris", "40"},
        {"lamp", "hours"},
        {"lamp", "shutter", "0.3"},
        {"lamp", "serial"},
        {"lamp", "off"},
        {"laser_profiler", "errors"}}},
      {kIce, {{"robot", "where"}, {"robot", "lines", "50"}, {"valve_b", "spit", "10"}, {"heater", "read"}}},
      {kAerosol,
       {{"gas", "read"},
        {"gas", "set", "0", "30"},
        {"gas", "serial"},
        {"gas", "stop"},
        {"heater", "set", "30", "-50", "-50"}}},
  };
  for (const auto& [lab, orders] : all)
    for (std::vector<std::string> words : orders) {
      words.insert(words.begin(), lab);
      const Json j = asked(words);
      CHECK(j["real"] == false);
      if (words[2] == "where" && words[1] == "stage")
        CHECK(j["text"] == "done: x 0.0000, y 0.0000, z 0.0000");
      if (words[2] == "serial")
        CHECK_THAT(j["text"].get<std::string>(),
                   Contains(words[1] == "gas" ? "MC-SCCM-D 52164B" : "serial 20158"));
      if (words[1] == "heater" && words[2] == "read") CHECK(j["degC"].size() == 3);
      if (words[1] == "gas" && words[2] == "read") CHECK(j["pressure_kPa"][1].get<double>() > 100.0);
    }
  // Each of its orders begins with a start of the jet's firmware: in a simulated lab where that takes a
  // second.
  SimulatedInstruments quick(load_lab_experiment(kInkjet, {}), true);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"jet", "continuous", "0.5"},
                                                {"jet", "waveform", "25", "-25", "18", "36"},
                                                {"jet", "strobe", "1", "150"},
                                                {"jet", "reset"}})
    CHECK(asked(joined(joined({kInkjet}, words), coupled(quick)))["real"] == true);
}

TEST_CASE("an arm that is at home is turned by one joint", "[device]") {
  SimulatedInstruments world(load_lab_experiment(kIce, {}));
  std::vector<std::string> ports;
  for (const char* node : {"robot", "valve_a", "valve_b", "laser_point"})
    ports.insert(ports.end(), {"--set", port_option(node, to_text(world.address(node)))});
  CHECK_THAT(device_verb(joined({kIce, "robot", "jog", "4", "2"}, ports)).err, Contains("no arm power"));
  REQUIRE(asked(joined({kIce, "robot", "home"}, ports))["text"] == "done");
  const auto where = [&] {
    return asked(joined({kIce, "robot", "where"}, ports))["text"].get<std::string>();
  };
  const std::string before = where();
  REQUIRE(asked(joined({kIce, "robot", "jog", "4", "2"}, ports))["text"] == "done");
  const std::string after = where();
  CHECK(before.substr(0, before.find("J2")) == after.substr(0, after.find("J2")));
  CHECK(before.substr(before.find("J4")) != after.substr(after.find("J4")));
}

TEST_CASE("the point laser's accuracy is that of many readings, and its zero a key of the lab file",
          "[device]") {
  const Json one = asked({kIce, "laser_point", "read"});
  REQUIRE(one["readings_mm"].size() == 1);
  const Json many = asked({kIce, "laser_point", "accuracy", "20"});
  CHECK(many["readings_mm"].size() == 20);
  const Json zero = asked({kIce, "laser_point", "zero", "5"});
  const auto text = zero["text"].get<std::string>();
  if (one["readings_mm"][0].is_null())  // nothing is in its range in the simulated lab at rest
    CHECK_THAT(text, Contains("no value in 5 readings"));
  else
    CHECK_THAT(text, Contains("laser_point.offset_z_mm = "));
}

TEST_CASE("profiles come as numbers and as a picture", "[device]") {
  SimulatedInstruments world(load_lab_experiment(kInkjet, {}));
  const fs::path folder = fresh_folder("profiles");
  const auto ports = coupled(world);
  const auto read = [&](const std::vector<std::string>& more) {
    return device_verb(joined(joined({kInkjet, "laser_profiler", "read"}, more), ports));
  };
  CHECK(read({}).code == 1);  // nothing was triggered
  REQUIRE(device_verb(joined({kInkjet, "stage", "home"}, ports)).code == 0);
  RawLine line(world.address("stage"));  // three triggers on Y
  for (const char* command : {"WAIT MODE NOWAIT", "ABS", "PSOCONTROL @1 RESET", "PSOOUTPUT @1 CONTROL 1",
                              "PSOOUTPUT @1 PULSE", "PSOPULSE @1 TIME 50,25", "PSOTRACK @1 INPUT 0",
                              "PSODISTANCE @1 FIXED 0.5 UNITS", "PSOCONTROL @1 ARM", "LINEAR @1 1.7 F5"})
    REQUIRE(line.ask_line(std::string(command) + "\n") == "%\n");
  line.wait(1.0);
  const std::string csv = (folder / "p.csv").string(), png = (folder / "p.png").string();
  CHECK(read({"--out", csv}).code == 0);
  CHECK(read({"--out", png}).code == 0);
  const std::string text = read_file(csv);
  CHECK(std::count(text.begin(), text.end(), '\n') == 801);
  CHECK_THAT(text, Contains("row,x_mm,y_mm,z_mm\n0,"));
  const std::string picture = read_file(png);
  const PngHeader header = png_header(std::as_bytes(std::span(picture.data(), picture.size())));
  CHECK(header.width == 800);
  CHECK(header.height == 64);
  const Said batch = device_verb(joined({kInkjet, "laser_profiler", "batch", "5", "0.3"}, ports));
  CHECK(batch.code == 0);
  CHECK_THAT(batch.out, Contains("0 of 5 profiles"));
  CHECK(read({"--out", "x.txt"}).code == 2);
}

TEST_CASE("one instrument is tried alone, whatever a trigger line couples to it in a print", "[device]") {
  SimulatedInstruments inkjet(load_lab_experiment(kInkjet, {})), ice(load_lab_experiment(kIce, {}));
  const std::string stage = port_option("stage", to_text(inkjet.address("stage")));
  const Said who = device_verb({kInkjet, "stage", "identify", "--set", stage});
  CHECK(who.code == 0);
  CHECK_THAT(who.out + who.err, Contains("REAL stage"));
  const std::string laser = port_option("laser_point", to_text(ice.address("laser_point")));
  CHECK(device_verb({kIce, "laser_point", "status", "--set", laser}).code == 0);
  CHECK_THAT(firn_says({"print", kInkjet, "--set", stage}).err, Contains("no trigger line couples them"));
}

TEST_CASE("identify is no success where another instrument answers, or one that the lab refuses",
          "[device]") {
  SimulatedInstruments inkjet(load_lab_experiment(kInkjet, {}));
  const Said lamp = device_verb({kAerosol, "gas", "identify", "--within", "1", "--set", "gas.use=\"on\"",
                                 "--set", port_option("gas", to_text(inkjet.address("lamp")))});
  CHECK(lamp.code == 3);
  CHECK_THAT(lamp.err, Contains("within 1 s"));
  SimulatedInstruments aerosol(load_lab_experiment(kAerosol, {"gas.use=\"on\""}));
  const Said argon =
      device_verb({kAerosol, "gas", "identify", "--set", "gas.use=\"on\"", "--set", "gas.gas=\"Ar\"", "--set",
                   port_option("gas", to_text(aerosol.address("gas")))});
  CHECK(argon.code == 1);
  CHECK_THAT(argon.err, Contains("atomizer is set to N2, gas.gas is \"Ar\""));
}

TEST_CASE("a dry run tells the bytes of an order and opens no port", "[device]") {
  const Said said = device_verb({kInkjet, "jet", "fire", "5", "--dry-run", "--set",
                                 port_option("jet", "serial:/dev/firn-none"), "--set",
                                 port_option("stage", "tcp:127.0.0.1:9"), "--set",
                                 port_option("laser_profiler", "tcp:127.0.0.1:9")});
  CAPTURE(said.err);
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("DRY RUN jet") && Contains("53 04 03 00 05 0c") && Contains("53 02 09 0b") &&
                           !Contains("58 |X|"));
  const Said raw = device_verb({kInkjet, "lamp", "raw", "GUSFA\\r", "--unsafe", "--dry-run", "--set",
                                port_option("lamp", "serial:/dev/firn-none")});
  CHECK(raw.code == 0);
  CHECK_THAT(raw.out, Contains("> GUSFA\\r"));
}

TEST_CASE("raw bytes go out only by --unsafe, and what comes back is shown", "[device]") {
  const Said safe = device_verb({kInkjet, "lamp", "raw", "CONN18\\r"});
  CHECK(safe.code == 2);
  CHECK_THAT(safe.err, Contains("--unsafe"));
  const Said said = device_verb({kInkjet, "lamp", "raw", "CONN18\\x0d", "--unsafe"});
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("> CONN18\\r\n< READY0A\\r"));
  CHECK_THAT(device_verb({kInkjet, "lamp", "raw", "\\q", "--unsafe"}).err, Contains("after \\ comes"));
}

TEST_CASE("a status that is watched goes on until Ctrl-C, which makes the instrument safe", "[device]") {
  const std::string program = FIRN_BINARY_DIR "/bin/firn", said = (fresh_folder("watch") / "said").string();
  const std::string command = "exec " + program + " device " + kInkjet + " lamp status --watch > " + said;
  const char* argv[] = {"/bin/sh", "-c", command.c_str(), nullptr};
  pid_t pid = -1;
  REQUIRE(::posix_spawn(&pid, argv[0], nullptr, nullptr, const_cast<char**>(argv), environ) == 0);
  const std::int64_t until_us = monotonic_us() + 20'000'000;
  while (monotonic_us() < until_us &&
         (!fs::exists(said) || read_file(said).find("safe") == std::string::npos))
    ::usleep(50'000);
  ::usleep(300'000);
  REQUIRE(::kill(pid, 0) == 0);  // still watching
  ::kill(pid, SIGINT);
  int status = 0;
  ::waitpid(pid, &status, 0);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 130));
  CHECK_THAT(read_file(said), Contains("lamp: connecting") && Contains("lamp: safe, Excelitas OmniCure"));
}

TEST_CASE("values beyond an order's limits are refused by name", "[device]") {
  const std::pair<std::vector<std::string>, std::string> wrong[] = {
      {{kInkjet, "stage", "jog", "6", "0", "0", "5"}, "beyond 5 mm; --far"},
      {{kInkjet, "jet", "continuous", "200"}, "(0, 180] s"},
      {{kInkjet, "jet", "waveform", "120", "-20", "20", "40"}, "100 V"},
      {{kInkjet, "jet", "waveform", "50", "-20", "20", "40", "--set", "devices.jet.dialect.max_abs_v=40"},
       "dwell voltage 50 V is beyond +-40 V"},
      {{kIce, "valve_a", "spit", "60"}, "most_spits"},
  };
  for (const auto& [words, why] : wrong) {
    const Said said = device_verb(words);
    CAPTURE(why, said.out, said.err);
    CHECK(said.code == 1);
    CHECK_THAT(said.err, Contains(why));
  }
  CHECK(device_verb({kInkjet, "stage", "jog", "6", "0", "0", "15", "--far"}).code == 0);
}

TEST_CASE("a camera's picture and the pictures of a sweep come as files", "[device]") {
  const auto folder = fresh_folder("device-camera");
  const auto taken = [&](std::vector<std::string> words, const std::string& name) {
    words.insert(words.begin(), {kInkjet, "camera"});
    words.insert(words.end(), {"--set", "camera.use=\"on\"", "--out", (folder / name).string()});
    const Said said = device_verb(words);
    INFO(said.err);
    CHECK(said.code == 0);
  };
  taken({"read"}, "one.png");
  taken({"sweep", "3", "100", "20"}, "sweep.png");
  for (const char* file : {"one.png", "sweep-1.png", "sweep-2.png", "sweep-3.png"}) {
    INFO(file);
    CHECK(file_text(folder / file).starts_with("\x89PNG"));
  }
}

TEST_CASE("identify takes at most a second behind a serial or a TCP line, for every instrument", "[device]") {
  using Kind = PortBridge::Kind;
  const std::string camera = "camera.use=\"on\"", microdrop = "jet.kind=\"microdrop\"",
                    gas = "gas.use=\"on\"";
  const std::tuple<std::string, std::string, Kind, int, std::string> all[] = {
      {kInkjet, "stage", Kind::kTcp, 0, camera},
      {kInkjet, "jet", Kind::kSerial, 9600, camera},
      {kInkjet, "laser_profiler", Kind::kTcp, 0, camera},
      {kInkjet, "lamp", Kind::kSerial, 19200, camera},
      {kInkjet, "camera", Kind::kTcp, 0, camera},
      {kInkjet, "jet", Kind::kSerial, 19200, microdrop},
      {kAerosol, "gas", Kind::kSerial, 19200, gas},
      {kAerosol, "heater", Kind::kSerial, 9600, gas},
      {kIce, "robot", Kind::kTcp, 0, ""},
      {kIce, "valve_a", Kind::kSerial, 115200, ""},
      {kIce, "valve_b", Kind::kSerial, 115200, ""},
      {kIce, "laser_point", Kind::kSerial, 115200, ""},
      {kIce, "heater", Kind::kSerial, 9600, ""}};
  std::string lab;
  std::unique_ptr<SimulatedInstruments> world;
  for (const auto& [file, node, kind, baud, key] : all) {
    const std::vector<std::string> keys = key.empty() ? std::vector<std::string>{} : std::vector{key};
    if (file + key != lab) world = std::make_unique<SimulatedInstruments>(load_lab_experiment(file, keys));
    lab = file + key;
    const PortBridge bridge(kind, world->address(node).place);
    std::vector<std::string> words{file,     node,    "identify",
                                   "--json", "--set", port_option(node, bridge.address(baud))};
    for (const std::string& k : keys) words.insert(words.end(), {"--set", k});
    // Instruments on one trigger line are real together.
    for (const char* other : {"stage", "jet", "laser_profiler", "robot", "valve_a", "valve_b", "laser_point"})
      if (node != other && node != "lamp" && node != "heater" && node != "camera" && node != "gas" &&
          (file == kInkjet) ==
              (std::string_view("stage jet laser_profiler").find(other) != std::string::npos)) {
        words.push_back("--set");
        words.push_back(port_option(other, "tcp:127.0.0.1:9"));
      }
    const std::int64_t began_us = monotonic_us();
    const Said said = device_verb(words);
    const double took_s = double(monotonic_us() - began_us) * 1e-6;
    CAPTURE(node, said.err, took_s);
    REQUIRE(said.code == 0);
    const Json j = Json::parse(said.out);
    CHECK(j["real"] == true);
    CHECK_FALSE(j["identity"].get<std::string>().empty());
    WARN(node << ": identified in " << took_s << " s");
    CHECK(took_s < 3.0);  // 1 s is promised; a machine that builds beside has its share
  }
}

// The JetDrive jets until it is told otherwise: nothing in it misses the host.
TEST_CASE("a jet whose host was killed while it jetted is ended by the next stop", "[device]") {
  SimulatedInstruments world(load_lab_experiment(kInkjet, {}), true);
  const auto ports = coupled(world);
  const auto jetting = [&] {
    RawLine line(world.address("jet"));
    const std::string r = line.ask(
        std::string("S\x02\x02\x04", 4), [](std::string_view s) { return s.size() >= 4; }, 1.0);
    return r.size() >= 4 && r[0] == 0x06 && (r[2] & 1) != 0;
  };
  bool any = false;
  for (const int after_ms : {300, 1300, 2200, 4000}) {
    const std::string program = FIRN_BINARY_DIR "/bin/firn";
    std::vector<const char*> argv{program.c_str(), "device", kInkjet.c_str(), "jet", "continuous", "60"};
    for (const std::string& word : ports) argv.push_back(word.c_str());
    argv.push_back(nullptr);
    pid_t pid = -1;
    REQUIRE(::posix_spawn(&pid, program.c_str(), nullptr, nullptr, const_cast<char**>(argv.data()),
                          environ) == 0);
    ::usleep(useconds_t(after_ms) * 1000);
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
    any = any || jetting();
    const Said said = device_verb(joined({kInkjet, "jet", "stop"}, ports));
    CAPTURE(after_ms, said.out, said.err);
    CHECK(said.code == 0);
    CHECK_FALSE(jetting());
  }
  CHECK(any);  // at one of the moments it was jetting
}
