// firn device: one instrument alone, simulated or behind a line.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "files/json.h"
#include "files/text_file.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

Said device(std::vector<std::string> words) {
  words.insert(words.begin(), "device");
  return firn_says(words);
}

}  // namespace

TEST_CASE("firn device names every instrument of the labs, and says that it is simulated") {
  const std::pair<std::string, std::string> all[] = {
      {kInkjet, "stage"}, {kInkjet, "jet"},  {kInkjet, "laser_profiler"}, {kInkjet, "lamp"},
      {kIce, "robot"},    {kIce, "valve_a"}, {kIce, "valve_b"},           {kIce, "laser_point"},
      {kIce, "heater"},   {kAerosol, "gas"}, {kAerosol, "heater"}};
  for (const auto& [lab, node] : all) {
    const Said said = device({lab, node, "identify", "--json"});
    CAPTURE(node, said.err);
    REQUIRE(said.code == 0);
    const Json j = Json::parse(said.out);
    CHECK(j["node"] == node);
    CHECK(j["real"] == false);
    CHECK_FALSE(j["identity"].get<std::string>().empty());
  }
}

TEST_CASE("? tells the verbs of an instrument with their values, as text and as JSON") {
  const Said said = device({kInkjet, "stage", "?"});
  CHECK(said.code == 0);
  CHECK_THAT(said.out,
             Contains("move X Y Z SPEED [mm, mm/s]") && Contains("homes the axes") && !Contains("waveform"));
  const Said json = device({kInkjet, "jet", "?", "--json"});
  REQUIRE(json.code == 0);
  const Json verbs = Json::parse(json.out);
  CHECK(std::count_if(verbs.begin(), verbs.end(), [](const Json& v) { return v["verb"] == "waveform"; }) ==
        1);
}

TEST_CASE("A question to a stage moves nothing, and a home command homes it") {
  const auto folder = fresh_folder("device");
  const auto record_of = [&](const std::string& verb) {
    const std::string file = (folder / (verb + ".txt")).string();
    const Said said = device({kInkjet, "stage", verb, "--record", file});
    CAPTURE(said.err);
    CHECK(said.code == 0);
    const std::string record = read_file(file);  // behind the experiment, which names every text
    return record.substr(record.rfind("\n#") + 1);
  };
  for (const char* verb : {"identify", "status", "stop"}) {
    const std::string record = record_of(verb);
    CHECK_THAT(record, Contains("ABORT @0") && !Contains("PROGRAM RUN") && !Contains("LINEAR"));
  }
  CHECK_THAT(record_of("home"), Contains("IGLOBAL(33)=2") && Contains("PROGRAM RUN 5"));
}

TEST_CASE("firn device keeps the limits of the lab, and exits with 1 when the instrument refuses") {
  CHECK(device({kInkjet, "stage", "move", "1", "2", "3", "20"}).code == 0);
  const Said beyond = device({kInkjet, "stage", "move", "500", "2", "3", "20"});
  CHECK(beyond.code == 1);
  CHECK_THAT(beyond.err, Contains("axis X: 500.0000 mm is outside"));
  const Said heat = device({kIce, "heater", "set", "10", "10", "10", "--json"});
  CHECK(heat.code == 0);
  CHECK(Json::parse(heat.out)["text"] == "done");
}

TEST_CASE("firn device refuses instruments, verbs and values that are none, by what there is") {
  const std::pair<std::vector<std::string>, std::string> wrong[] = {
      {{kInkjet, "lam", "identify"}, "it has stage, jet, laser_profiler, lamp"},
      {{kInkjet, "scheduler", "identify"}, "it has stage"},
      {{kInkjet, "stage", "jump"}, "known: identify, status, stop, serial, reset, home, move X Y Z SPEED"},
      {{kInkjet, "lamp", "home"}, "lamp has no verb 'home'"},
      {{kInkjet, "stage", "move", "1", "2"}, "takes 4 values"},
      {{kInkjet, "stage", "move", "1", "2", "x", "4"}, "'x' is no number"},
      {{kInkjet, "stage", "move", "1", "2", "nan", "4"}, "'nan' is no number"},
      {{"none.toml", "stage", "identify"}, "none.toml"},
  };
  for (const auto& [words, why] : wrong) {
    const Said said = device(words);
    CAPTURE(why, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(why));
  }
}

TEST_CASE("An instrument that is not there, or says nothing, ends with 3 and the name of its port") {
  const Said gone = device({kInkjet, "lamp", "status", "--within", "1", "--set",
                            "devices.lamp.port=\"serial:/dev/firn-none?baud=19200\""});
  CHECK(gone.code == 3);
  CHECK_THAT(gone.out, Contains("REAL lamp: serial:/dev/firn-none"));
  CHECK_THAT(gone.err, Contains("No such file") && Contains("its port does not open"));
}

TEST_CASE("An instrument that takes bytes and says nothing is named after two seconds, for every verb") {
  const auto folder = fresh_folder("device-silent");
  const int listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un a{};
  a.sun_family = AF_UNIX;
  (folder / "lamp").string().copy(a.sun_path, sizeof a.sun_path - 1);
  REQUIRE(::bind(listener, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
  REQUIRE(::listen(listener, 4) == 0);
  for (const char* verb : {"status", "identify", "on"}) {
    const Said said = device(
        {kInkjet, "lamp", verb, "--set", "devices.lamp.port=\"unix:" + (folder / "lamp").string() + "\""});
    CHECK(said.code == 3);
    CHECK_THAT(said.err, Contains("no answer within 2 s"));
  }
  ::close(listener);
}

TEST_CASE("A value that the order's message cannot carry is refused before the port is opened") {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"stage", "jog", "1e9", "0", "0", "5"},
                                             {"stage", "move", "1e12", "0", "0", "5"},
                                             {"jet", "fire", "1e9"}}) {
    std::vector<std::string> all{kInkjet};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--set", "devices." + words[0] + ".port=\"serial:/dev/firn-none?baud=9600\""});
    const Said said = device(all);
    CAPTURE(said.out, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains("is outside"));
  }
}

TEST_CASE(
    "firn host --install names what it lacks: hosts in the lab, a host of that name, a computer that "
    "answers") {
  const auto install = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"host", "--install"});
    return firn_says(words);
  };
  const Said none = install({kInkjet});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains(kInkjet) && Contains("has no [hosts]"));
  const std::string lab = (fresh_folder("install") / "lab.toml").string();
  write_file_text(lab, "include = \"" + kInkjet +
                           "\"\n[hosts]\nbench = \"nobody-of-firn@127.0.0.1\"\n"
                           "[devices]\nlamp.host = \"bench\"\n");
  const Said other = install({lab, "--host", "cellar"});
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("[hosts] has no 'cellar'"));
  const Said silent = install({lab});
  CHECK(silent.code == 3);
  CHECK_THAT(silent.err, Contains("host bench (nobody-of-firn@127.0.0.1)"));
}
