// firn bringup: whole checklists on twins, and the mistakes that people make, each named with its mend.
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <future>
#include <set>
#include <thread>

#include "drivers/heater/thermostat.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/laser_profiler/ljv.h"
#include "drivers/robot/fvp.h"
#include "drivers/stage/ensemble.h"
#include "drivers/stage/grbl.h"
#include "files/json.h"
#include "files/text_file.h"
#include "print/bringup/bringup.h"
#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "print/labs/full_product.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

namespace fs = std::filesystem;

const std::set<int> kTimed{6, 22, 28, 44};  // rows that measure this machine's time too

// A lab file and the instruments as they truly are: `truth` are the keys in which they differ.
struct Bench {
  explicit Bench(const std::string& file, const std::vector<std::string>& truth = {},
                 const std::vector<std::string>& believed = {})
      : world(load_lab_experiment(file, truth), true), lab_file(load_lab_experiment(file, believed)) {}

  /// The link row of a node whose port has the address of another instrument, carried out beside others.
  std::future<BringupResult> linked(const std::string& node, const PortAddress& address) {
    return std::async(std::launch::async, [this, node, address] {
      BringupLab lab(full_product(), lab_file, [address](const std::string&) { return address; }, {}, {});
      return row(0, node, lab);
    });
  }

  BringupResult row(int id, const std::string& node) {
    BringupLab lab(
        full_product(), lab_file,
        [this](const std::string& name) {
          return exchanged.contains(name) ? exchanged.at(name) : world.address(name);
        },
        [this](int asked, const std::string& question) -> std::optional<bool> {
          INFO(question);
          if (asked == 47) world.inject("laser_profiler trip 1");  // a person lays the block
          if (asked == 67) world.inject("laser_profiler trip 5");
          ::usleep(50'000);
          return true;
        },
        {});
    return row(id, node, lab);
  }
  BringupResult row(int id, const std::string& node, BringupLab& lab) const {
    for (const PlannedRow& planned : planned_rows(lab_file))
      if (planned.row->id == id && planned.node == node) return carry_out(planned, lab);
    throw std::logic_error("no such row");
  }
  void hurt(const std::string& fault) {
    world.inject(fault);
    ::usleep(50'000);
  }

  SimulatedInstruments world;
  Experiment lab_file;
  std::map<std::string, PortAddress> exchanged;
};

// An instrument of the test's own behind a serial line.
class SerialInstrument {
 public:
  using Answer = std::function<std::string(std::string_view heard)>;
  explicit SerialInstrument(Answer answer) : answer_(std::move(answer)) {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    REQUIRE(master_ >= 0);
    REQUIRE(::grantpt(master_) == 0);
    REQUIRE(::unlockpt(master_) == 0);
    path_ = ::ptsname(master_);
    held_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    thread_ = std::thread([this] {
      char bytes[256];
      while (!over_) {
        pollfd p{master_, POLLIN, 0};
        if (::poll(&p, 1, 20) <= 0) continue;
        const ssize_t n = ::read(master_, bytes, sizeof bytes);
        const std::string said = n > 0 ? answer_({bytes, std::size_t(n)}) : std::string();
        if (!said.empty() && ::write(master_, said.data(), said.size()) < 0) return;
      }
    });
  }
  ~SerialInstrument() {
    over_ = true;
    thread_.join();
    ::close(held_);
    ::close(master_);
  }
  PortAddress address() const { return parse_port_address("serial:" + path_ + "?baud=9600"); }

 private:
  Answer answer_;
  int master_ = -1, held_ = -1;
  std::string path_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

// At the wrong speed other bytes arrive.
std::string garbled(std::string_view heard) {
  std::string said(heard);
  for (char& c : said) c = char(c * 7 ^ 0xE5);
  return said;
}

void check_failed(const BringupResult& r, const char* measured, const char* mend) {
  INFO(r.what << ": " << r.measured << " | " << r.limit << " | " << r.mend);
  CHECK(r.state == "failed");
  CHECK_THAT(r.measured, Contains(measured));
  CHECK_THAT(r.mend, Contains(mend));
}

}  // namespace

TEST_CASE("the checklist has the rows of the page, most of them carried out by the program", "[bringup]") {
  const std::string page = read_file(FIRN_SOURCE_DIR "/docs/devices/HARDWARE_CHECKLIST.md");
  std::set<int> all, automatic;
  for (const auto rows : {stage_rows(), inkjet_rows(), camera_rows(), gas_rows(), ice_rows(), grbl_rows(),
                          point_scan_rows(), python_rows()})
    for (const BringupRow& row : rows) {
      CHECK(all.insert(row.id).second);
      if (row.check) automatic.insert(row.id);
      INFO(row.id);
      CHECK_THAT(page, Contains("\n|" + std::to_string(row.id) + "|"));
      const auto at = page.find("\n|" + std::to_string(row.id) + "|");
      const std::string instrument = page.substr(at + 1, page.find('|', page.find('|', at + 2) + 1) - at);
      CHECK((instrument.find('*') != std::string::npos) == (row.check != nullptr));
    }
  for (int id = 1; id <= 67; ++id)
    if (id != 27) CHECK(all.contains(id));
  const auto of_the_46 = std::distance(automatic.begin(), automatic.upper_bound(46));
  WARN(of_the_46 << " of the 46 rows are automatic, " << automatic.size() << " of all 67");
  CHECK(of_the_46 >= 30);
}

TEST_CASE("a sound ink-jet lab passes every row that a program can check", "[bringup]") {
  Bench b(kInkjet);
  int checked = 0;
  for (const PlannedRow& planned : planned_rows(b.lab_file)) {
    if (planned.row->id != 0 && !planned.row->check) continue;
    const BringupResult r = b.row(planned.row->id, planned.node);
    INFO(r.node << " " << r.id << " " << r.what << ": " << r.measured << " | " << r.limit << " | " << r.mend);
    if (!kTimed.contains(r.id)) CHECK(r.state == "ok");
    CHECK_FALSE(r.measured.empty());
    ++checked;
  }
  CHECK(checked >= 22);
}

TEST_CASE("a sound ice lab passes every row that a program can check", "[bringup]") {
  Bench b(kIce);
  for (const PlannedRow& planned : planned_rows(b.lab_file)) {
    if (planned.row->id != 0 && !planned.row->check) continue;
    const BringupResult r = b.row(planned.row->id, planned.node);
    INFO(r.node << " " << r.id << " " << r.what << ": " << r.measured << " | " << r.limit << " | " << r.mend);
    if (!kTimed.contains(r.id)) CHECK(r.state == "ok");
    CHECK_FALSE(r.measured.empty());
  }
}

TEST_CASE("a sound aerosol lab passes the rows of gas and platen, and each of their faults is named",
          "[bringup]") {
  const std::vector<std::string> warm{"laser_profiler.read=\"memory\"", "gas.settle_s=3"};
  Bench b(kAerosol, warm, warm);
  std::set<int> ids;
  for (const PlannedRow& planned : planned_rows(b.lab_file)) {
    if (planned.node != "gas" && planned.node != "heater") continue;
    ids.insert(planned.row->id);
    if (planned.row->id != 0 && !planned.row->check) continue;
    const BringupResult r = b.row(planned.row->id, planned.node);
    INFO(r.node << " " << r.id << " " << r.what << ": " << r.measured << " | " << r.limit << " | " << r.mend);
    CHECK(r.state == "ok");
    if (r.id == 53) CHECK_THAT(r.measured, Contains("sheath ") && Contains("atomizer 0 sccm"));
  }
  CHECK(ids == std::set<int>{0, 45, 52, 53, 54, 57, 58});
  b.hurt("gas echo 1");  // something else before its answer, as from the driver that had the line
  CHECK(b.row(52, "gas").state == "ok");
  b.hurt("gas trip 2");
  check_failed(b.row(53, "gas"), "0 of 40 sccm", "bottle");
  b.hurt("gas trip 6");
  check_failed(b.row(52, "gas"), "unit B answers ''", "mend this first");
  b.hurt("gas trip 0");
  b.exchanged["gas"] = b.world.address("heater");
  CHECK(b.row(0, "gas").state == "failed");

  Bench litres(kAerosol, {}, {"devices.gas.dialect.kpa_per_unit=1.0"});
  check_failed(litres.row(52, "gas"), "14.7", "kpa_per_unit");
  Bench argon(kAerosol, {"gas.gas=\"Ar\""}, {});
  check_failed(argon.row(52, "gas"), "Ar", "select the gas");
  Bench letters(kAerosol, {"gas.atomizer_unit=\"D\""}, {"gas.atomizer_unit=\"D\""});
  CHECK(letters.row(0, "gas").state == "ok");
}

TEST_CASE("a camera passes its rows, and each of its faults is named", "[bringup]") {
  const std::vector<std::string> with_camera{"camera.use=\"on\""};
  Bench b(kInkjet, with_camera, with_camera);
  for (const int id : {0, 48, 49}) {
    const BringupResult r = b.row(id, "camera");
    INFO(id << ": " << r.measured << " | " << r.limit << " | " << r.mend);
    CHECK(r.state == "ok");
    CHECK(r.automatic);
  }
  CHECK_THAT(b.row(48, "camera").measured, Contains("x") && Contains("of 255"));
  CHECK_FALSE(b.row(50, "camera").automatic);
  b.hurt("camera trip 1");
  check_failed(b.row(48, "camera"), "the sensor is disconnected", "mend this first");
  b.hurt("camera trip 2");
  check_failed(b.row(48, "camera"), "checksum is told as", "mend this first");
  b.exchanged["camera"] = b.world.address("lamp");
  CHECK(b.row(0, "camera").state == "failed");
  b.exchanged = {{"lamp", b.world.address("camera")}};
  CHECK(b.row(0, "lamp").state == "failed");

  auto dim = with_camera;
  dim.push_back("plant.camera.light=0.1");
  dim.push_back("plant.camera.uneven=1");
  Bench dark(kInkjet, dim, with_camera);
  check_failed(dark.row(49, "camera"), "of white", "the strobe does not flash");
}

TEST_CASE("a Microdrop passes its rows, and one without a trigger or in a JetDrive's place is named",
          "[bringup]") {
  const std::vector<std::string> silent{"jet.kind=\"microdrop\""},
      triggered{"jet.kind=\"microdrop\"", "jet.trigger_on=\"SetTrigger(1,1)\"",
                "jet.trigger_off=\"SetTrigger(1,0)\""};
  Bench b(kInkjet, triggered, triggered);
  std::set<int> ids;
  for (const PlannedRow& planned : planned_rows(b.lab_file))
    if (planned.node == "jet" && planned.row->check) ids.insert(planned.row->id);
  CHECK(ids == std::set<int>{51});
  for (const int id : {0, 51}) {
    const BringupResult r = b.row(id, "jet");
    INFO(id << ": " << r.measured << " | " << r.limit << " | " << r.mend);
    CHECK(r.state == "ok");
  }
  b.lab_file = load_lab_experiment(kInkjet, silent);
  check_failed(b.row(51, "jet"), "no trigger command", "jet.trigger_on");
  b.lab_file = load_lab_experiment(kInkjet, {});
  CHECK(b.row(0, "jet").state == "failed");
  Bench jetdrive(kInkjet, {}, triggered);
  CHECK(jetdrive.row(0, "jet").state == "failed");
}

TEST_CASE("doctor looks at the port of each real instrument, the camera's too", "[bringup]") {
  const std::vector<std::string> with_camera{"camera.use=\"on\""};
  const Bench b(kInkjet, with_camera, with_camera);
  std::vector<std::string> words{"doctor", kInkjet, "--json", "--set", with_camera[0]};
  const std::vector<std::string> nodes{"stage", "jet", "laser_profiler", "lamp", "camera"};
  for (const std::string& node : nodes)
    words.insert(words.end(),
                 {"--set", "devices." + node + ".port=\"unix:" + b.world.address(node).place + "\""});
  const Said said = firn_says(words);
  std::set<std::string> fine;
  const Json answer = Json::parse(said.out);
  for (const Json& check : answer["checks"])
    if (check["ok"]) fine.insert(check["check"]);
  INFO(said.out);
  for (const std::string& node : nodes) CHECK(fine.contains(node));
}

TEST_CASE("a line at the wrong speed is named", "[bringup]") {
  Bench b(kInkjet);
  const SerialInstrument line(&garbled);
  b.exchanged["lamp"] = line.address();
  check_failed(b.row(0, "lamp"), "that are no answer", "wrong baud or frame");
}

TEST_CASE("bring-up sends no bytes to a port but the questions of its own kind", "[bringup]") {
  struct Case {
    std::string lab, node;
    std::vector<std::string> set;
    std::string only;  // that may come, again and again
  };
  const std::string grbl = "devices.stage.kind=\"grbl\"";
  const std::string point = "devices.laser_profiler.kind=\"lkg\"";
  for (const Case& c : {Case{kInkjet, "stage", {}, drivers::ensemble::link_probe().question},
                        Case{kInkjet, "stage", {grbl}, drivers::grbl::link_probe().question},
                        Case{kInkjet, "lamp", {}, drivers::omnicure::frame("CONN")},
                        Case{kInkjet, "laser_profiler", {}, drivers::ljv::link_probe().question},
                        Case{kInkjet, "laser_profiler", {point}, drivers::lkg::link_probe().question},
                        Case{kIce, "laser_point", {}, drivers::lkg::link_probe().question},
                        Case{kIce, "robot", {}, drivers::fvp::link_probe().question},
                        Case{kIce, "heater", {}, drivers::thermostat::link_probe().question}}) {
    std::string heard;
    {
      const SerialInstrument silent([&](std::string_view bytes) {
        heard += bytes;
        return std::string();
      });
      const Experiment e = load_lab_experiment(c.lab, c.set);
      BringupLab lab(full_product(), e, [&](const std::string&) { return silent.address(); }, {}, {});
      INFO(c.node);
      CHECK_FALSE(check_link(lab, c.node).ok);
    }
    INFO(c.node << " heard " << drivers::shown_line(heard));
    REQUIRE_FALSE(c.only.empty());
    CHECK(heard == c.only);
  }
}

TEST_CASE("the port of another instrument is named where what it says tells", "[bringup]") {
  Bench b(kInkjet);
  // A flow controller says its line to any end of a line.
  const SerialInstrument gas([](std::string_view heard) {
    return heard.ends_with("\r") ? "A +014.70 +025.00 +00.000 +00.000 +00.000     N2\r" : "";
  });
  check_failed(b.linked("lamp", gas.address()).get(), "this is the port of an Alicat flow controller",
               "belongs to gas");
  // An instrument that says nothing to the questions of another may be anything.
  check_failed(b.linked("lamp", b.world.address("stage")).get(), "no byte comes", "are exchanged");
}

TEST_CASE("a port that is not there, and an instrument that says nothing, are told apart", "[bringup]") {
  Bench b(kInkjet);
  b.exchanged["lamp"] = parse_port_address("serial:/dev/firn-none?baud=9600");
  check_failed(b.row(0, "lamp"), "No such file", "cable, power and address");
  b.exchanged.clear();
  b.hurt("lamp hang");
  check_failed(b.row(0, "lamp"), "no byte comes", "power, cable, remote mode");
}

TEST_CASE("a wrong number of counts per unit is named before anything moves", "[bringup]") {
  Bench b(kInkjet, {}, {"stage.counts_per_mm=20000"});
  check_failed(b.row(12, "stage"), "CountsPerUnit 10000", "wrong counts per unit");
}

TEST_CASE("soft limits of the controller inside those of the lab file are named", "[bringup]") {
  Bench b(kInkjet, {"stage.x_max_mm=100"});
  check_failed(b.row(12, "stage"), "soft limits [-50, 100] mm", "stage.x_min_mm, _max_mm");
}

TEST_CASE("a pressed emergency stop is named", "[bringup]") {
  Bench b(kInkjet);
  b.hurt("stage trip 1");
  check_failed(b.row(0, "stage"), "AXISSTATUS -2147483648", "the emergency stop is pressed");
}

TEST_CASE("swapped axes are named by the encoder that does not follow Y", "[bringup]") {
  Bench b(kInkjet);
  REQUIRE(b.row(7, "stage").state == "ok");
  REQUIRE(b.row(20, "laser_profiler").state == "ok");
  b.hurt("stage trip 6");
  check_failed(b.row(20, "laser_profiler"), "mm", "axes swapped");
}

TEST_CASE("a trigger that does not reach the profiler is named", "[bringup]") {
  Bench b(kInkjet);
  REQUIRE(b.row(7, "stage").state == "ok");
  b.hurt("stage trip 5");
  check_failed(b.row(20, "laser_profiler"), "no profile after a pulse", "cable from the stage's PSO output");
}

TEST_CASE("a profiler that hangs upside down or is mirrored is named by a gauge block", "[bringup]") {
  Bench down(kInkjet, {"laser_profiler.z_sign=down"});
  REQUIRE(down.row(7, "stage").state == "ok");
  check_failed(down.row(47, "laser_profiler"), "-0.5 mm", "upside down: laser_profiler.z_sign = \"down\"");
  Bench mirrored(kInkjet, {"laser_profiler.mirror_x=on"});
  REQUIRE(mirrored.row(7, "stage").state == "ok");
  check_failed(mirrored.row(47, "laser_profiler"), "at the end of greater x",
               "mirrored: laser_profiler.mirror_x = \"on\"");
}

TEST_CASE("a point laser in the profiler's place is brought up by its own rows, and one upside down is named",
          "[bringup]") {
  const std::string kind = "devices.laser_profiler.kind=\"lkg\"";
  Bench b(kInkjet, {kind}, {kind});
  for (const int id : {0, 65, 67}) {
    INFO(id);
    CHECK(b.row(id, "laser_profiler").state == "ok");
  }
  Bench down(kInkjet, {kind, "laser_profiler.z_sign=down"}, {kind});
  check_failed(down.row(67, "laser_profiler"), "-0.", "counts downwards: laser_profiler.z_sign = \"down\"");
}

TEST_CASE("a lamp that is cold or dark is named before it is to cure anything", "[bringup]") {
  Bench b(kInkjet);
  {
    RawLine line(b.world.address("lamp"));
    for (const char* command : {"CONN", "TOF", "TON"}) line.ask_line(drivers::omnicure::frame(command), '\r');
  }
  check_failed(b.row(0, "lamp"), "GUS 2", "the lamp is cold");
  ::usleep(1'200'000);
  CHECK(b.row(0, "lamp").state == "ok");
  b.hurt("lamp trip 2");
  check_failed(b.row(0, "lamp"), "GUS 0", "does not burn");
}

TEST_CASE("a shutter that is stuck is named", "[bringup]") {
  Bench b(kInkjet);
  b.hurt("lamp trip 3");
  check_failed(b.row(23, "lamp"), "shutter", "the shutter is stuck");
}

TEST_CASE("a profiler program with another number of points is named", "[bringup]") {
  Bench b(kInkjet, {"laser_profiler.points=400"});
  REQUIRE(b.row(7, "stage").state == "ok");
  check_failed(b.row(19, "laser_profiler"), "400 points", "laser_profiler.points");
}

TEST_CASE("results are kept row by row, and a second call goes on where the first one ended", "[bringup]") {
  const auto folder = fresh_folder("bringup");
  const std::string file = (folder / "lab.bringup.json").string();
  const Said lamp = firn_says({"bringup", kInkjet, "--device", "lamp", "--result", file, "--json", "--answer",
                               "23=no", "--answer", "26=yes"});
  INFO(lamp.out << lamp.err);
  CHECK(lamp.code == 1);
  const Json first = Json::parse(lamp.out);
  CHECK(first["ok"] == 4);
  CHECK(first["failed"] == 1);
  const Said again =
      firn_says({"bringup", kInkjet, "--device", "lamp", "--result", file, "--json", "--answer", "23=yes"});
  INFO(again.out << again.err);
  CHECK(again.code == 0);
  CHECK(Json::parse(again.out)["ok"] == 5);
  const auto state = read_bringup(file);
  REQUIRE(state);
  CHECK_THAT(state->identities.at("lamp"), Contains("OmniCure"));
  // Other settings of an instrument: all rows are to be done again.
  const Said other = firn_says({"bringup", kInkjet, "--device", "lamp", "--row", "24", "--result", file,
                                "--json", "--set", "lamp.max_on_s=19"});
  CHECK(other.code == 0);
  CHECK(read_bringup(file)->rows.size() == 1);
  write_file_atomically(file, "{\"rows\": 1}");
  CHECK_THAT(firn_says({"bringup", kInkjet, "--result", file}).err, Contains("is no bring-up result"));
}

TEST_CASE("rows done on the simulation, or at another port, do not vouch for a real instrument",
          "[bringup]") {
  const std::vector<std::string> real{"devices.lamp.port=\"tcp:h:2\""};
  const std::string file = (fresh_folder("bringup-ports") / "lab.bringup.json").string();
  const Said lamp =
      firn_says({"bringup", kInkjet, "--device", "lamp", "--row", "24", "--result", file, "--json"});
  INFO(lamp.out << lamp.err);
  CHECK(lamp.code == 0);
  auto state = read_bringup(file);
  REQUIRE((state && state->rows.size() == 1 && state->rows[0].port == "sim:"));
  const Experiment e = load_lab_experiment(kInkjet, real);
  CHECK(state->configuration == bringup_configuration(e));
  CHECK_THAT(bringup_refusal(e, state, "x", {}), Contains("lamp:24 (not carried out)"));
  state->rows[0].port = "tcp:h:1";
  CHECK_THAT(bringup_refusal(e, state, "x", {}), Contains("lamp:24 (not carried out)"));
  state->rows[0].port = "tcp:h:2";
  CHECK_THAT(bringup_refusal(e, state, "x", {}), !Contains("lamp:24"));
}

TEST_CASE("a print on real instruments wants its bring-up, or somebody who takes the risk", "[bringup]") {
  const Experiment e =
      load_lab_experiment(kInkjet, {"devices.stage.port=\"tcp:h:1\"", "devices.jet.port=\"tcp:h:2\"",
                                    "devices.laser_profiler.port=\"tcp:h:3\""});
  CHECK_THAT(bringup_refusal(e, std::nullopt, "lab.bringup.json", {}),
             Contains("lab.bringup.json is missing") && Contains("firn bringup LAB") &&
                 Contains("--accept-bringup all"));
  CHECK(bringup_refusal(e, std::nullopt, "x", {"all"}).empty());
  CHECK(bringup_refusal(load_lab_experiment(kInkjet, {}), std::nullopt, "x", {}).empty());
  BringupState state{bringup_configuration(e), {}, {}};
  for (const PlannedRow& planned : planned_rows(e)) {
    BringupResult r;
    r.id = planned.row->id;
    r.node = planned.node;
    r.state = "ok";
    r.port = port_of(e, r.node);
    state.rows.push_back(r);
  }
  CHECK(bringup_refusal(e, state, "x", {}).empty());
  for (BringupResult& r : state.rows)
    if (r.node == "lamp") r.state = "failed";  // simulated: it does not matter
  CHECK(bringup_refusal(e, state, "x", {}).empty());
  for (BringupResult& r : state.rows)
    if (r.node == "jet" && r.id == 15) r.state = "open";
  CHECK_THAT(bringup_refusal(e, state, "x", {}), Contains("1 row is not done: jet:15 (open)"));
  CHECK(bringup_refusal(e, state, "x", {"jet:15"}).empty());
  Experiment faster = e;
  faster.stage.counts_per_mm *= 2;
  CHECK_THAT(bringup_refusal(faster, state, "x", {"jet:15"}), Contains("other settings"));
  const Said said = firn_says({"print", FIRN_SOURCE_DIR "/experiments/cylinder.toml", "--set",
                               "devices.lamp.port=\"tcp:127.0.0.1:9\"", "--bringup", "/nowhere.json"});
  CHECK(said.code == 2);
  CHECK_THAT(said.err, Contains("/nowhere.json is missing"));
}

TEST_CASE("each kind of port that nobody is behind is named with node, address and cause", "[bringup]") {
  const std::string unheard = (fresh_folder("bringup-unheard") / "lamp").string();
  const auto refused = [](const std::string& port) {
    return closed_ports(load_lab_experiment(kInkjet, {"devices.lamp.port=\"" + port + "\""}));
  };
  CHECK(refused("tcp:127.0.0.1:9") == "lamp at tcp:127.0.0.1:9: Connection refused");
  CHECK_THAT(refused("serial:/dev/firn-none"),
             Contains("lamp at serial:/dev/firn-none?") && Contains("No such file or directory"));
  CHECK(refused("unix:" + unheard) == "lamp at unix:" + unheard + ": No such file or directory");
  CHECK_THAT(refused("tcp:no-such-host.invalid:9"),
             Contains("lamp at tcp:no-such-host.invalid:9: the host is not known"));
}

TEST_CASE("all ports that nobody is behind are named, and those that open are not", "[bringup]") {
  SimulatedInstruments world(load_lab_experiment(kInkjet, {}));
  const auto real = [&](const std::string& node) {
    return "devices." + node + ".port=\"unix:" + world.address(node).place + "\"";
  };
  std::vector<std::string> ports{real("stage"), real("jet"), real("laser_profiler"), real("lamp")};
  CHECK(closed_ports(load_lab_experiment(kInkjet, ports)).empty());
  ports[0] = "devices.stage.port=\"tcp:127.0.0.1:9\"";
  ports[3] = "devices.lamp.port=\"tcp:127.0.0.1:9\"";
  CHECK(closed_ports(load_lab_experiment(kInkjet, ports)) ==
        "lamp at tcp:127.0.0.1:9: Connection refused; stage at tcp:127.0.0.1:9: Connection refused");
}

TEST_CASE("a print whose lamp is unplugged is refused before anything begins", "[bringup]") {
  const fs::path runs = fresh_folder("bringup-unplugged");
  const Said said = firn_says({"print", FIRN_SOURCE_DIR "/experiments/cylinder.toml", "--set",
                               "devices.lamp.port=\"tcp:127.0.0.1:9\"", "--accept-bringup", "all", "--runs",
                               runs.string()});
  CHECK(said.code == 2);
  CHECK_THAT(said.err,
             Contains("lamp at tcp:127.0.0.1:9: Connection refused") && Contains("nothing was begun"));
  CHECK(fs::is_empty(runs));
}

TEST_CASE("another instrument at the same port is refused by its serial number, and a print asks",
          "[bringup]") {
  SimulatedInstruments world(load_lab_experiment(kInkjet, {}));
  const std::string at = "unix:" + world.address("lamp").place;
  const std::string port = "devices.lamp.port=\"" + at + "\"";
  const std::string file = (fresh_folder("bringup-serial") / "lab.bringup.json").string();
  const Said lamp = firn_says(
      {"bringup", kInkjet, "--device", "lamp", "--row", "0", "--result", file, "--json", "--set", port});
  INFO(lamp.out << lamp.err);
  REQUIRE(lamp.code == 0);
  const Json told = Json::parse(lamp.out);
  CHECK(told["assumptions"].contains("lamp"));
  auto state = read_bringup(file);
  REQUIRE(state);
  CHECK(state->identities.at("lamp") == "Excelitas OmniCure S2000 board 105 serial 20158");
  const Experiment e = load_lab_experiment(kInkjet, {port});
  CHECK(identity_refusal(full_product(), e, {}, *state, file, {}, {}).empty());
  state->identities["lamp"] = "Excelitas OmniCure S2000 board 105 serial 20157";
  CHECK_THAT(identity_refusal(full_product(), e, {}, *state, file, {}, {}),
             Contains("another instrument is at " + at) && Contains("serial 20158' answers") &&
                 Contains("'Excelitas OmniCure S2000 board 105 serial 20157'") &&
                 Contains("--accept-bringup lamp:identity"));
  CHECK(identity_refusal(full_product(), e, {}, *state, file, {"lamp:identity"}, {}).empty());
  CHECK(identity_refusal(full_product(), e, {}, *state, file, {"all"}, {}).empty());
  state->identities.clear();
  CHECK_THAT(identity_refusal(full_product(), e, {}, *state, file, {}, {}),
             Contains("it does not name the lamp"));
  CHECK(identity_refusal(full_product(), load_lab_experiment(kInkjet, {}), {}, *state, file, {}, {})
            .empty());  // nothing is real

  state->identities["lamp"] = "Excelitas OmniCure S2000 board 105 serial 20157";
  for (const PlannedRow& planned : planned_rows(e)) {
    BringupResult r;
    r.id = planned.row->id;
    r.node = planned.node;
    r.state = "ok";
    r.port = port_of(e, r.node);
    state->rows.push_back(r);
  }
  const Experiment cylinder = load_lab_experiment(FIRN_SOURCE_DIR "/experiments/cylinder.toml", {port});
  state->configuration = bringup_configuration(cylinder);
  write_bringup(file, *state);
  const Said print =
      firn_says({"print", FIRN_SOURCE_DIR "/experiments/cylinder.toml", "--set", port, "--bringup", file});
  CHECK(print.code == 2);
  CHECK_THAT(print.err, Contains("another instrument is at " + at));
}

TEST_CASE("a key of an instrument's dialect is one of the settings that a bring-up is made with",
          "[bringup]") {
  const auto of = [](const std::vector<std::string>& keys) {
    return bringup_configuration(load_lab_experiment(kInkjet, keys));
  };
  CHECK(of({"devices.lamp.dialect.run=\"RUN2\""}) != of({}));
  CHECK(of({"devices.jet.dialect.max_abs_v=60"}) != of({}));
  CHECK(of({"devices.lamp.port=\"tcp:h:1\""}) == of({}));  // rows hold the ports
}
