#include <catch2/catch.hpp>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <thread>

#include "plant/world/serve.h"
#include "plant/world/setup.h"
#include "plant/world/world.h"
#include "runtime/ports.h"

using namespace firn;
using namespace firn::plant;
namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("firn_serve_" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

/// Reads until `until` appears, or the other side closes, or nothing comes for ten seconds.
std::string read_until(int fd, std::string_view until) {
  std::string text;
  char buffer[4096];
  for (pollfd p{fd, POLLIN, 0}; text.find(until) == std::string::npos && ::poll(&p, 1, 10'000) > 0;) {
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n <= 0) break;
    text.append(buffer, std::size_t(n));
  }
  return text;
}

void put(int fd, std::string_view text) {
  REQUIRE(::write(fd, text.data(), text.size()) == ssize_t(text.size()));
}

int open_port(const fs::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  REQUIRE(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  return fd;
}

/// The process `world` in a thread, with its control line.
struct Served {
  int control[2];
  std::thread thread;
  explicit Served(const fs::path& run) {
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, control) == 0);
    ServeOptions o;
    o.run = run;
    o.io = run / "io";
    o.control_fd = control[1];
    o.time_scale = 10.0;
    timespec t{};
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    o.epoch_ns = std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
    thread = std::thread([o] { serve(o, WorldConfig{}); });
    CHECK(read_until(control[0], "\n") == "READY\n");
  }
  ~Served() {
    ::close(control[0]);  // the launcher is gone: save and end
    thread.join();
  }
};

}  // namespace

TEST_CASE(
    "The served world answers on its sockets, tells the truth, takes faults, and saves itself at the end") {
  const Folder folder;
  {
    Served world(folder.path);
    const int stage = open_port(folder.path / "io" / "stage");
    put(stage, "ENABLE @0\nAXISSTATUS(@0)\n");
    CHECK(read_until(stage, "%5\n") == "%\n%5\n");
    const int lamp = open_port(folder.path / "io" / "lamp");
    put(lamp, "CONN18\r");
    CHECK(read_until(lamp, "\r") == "READY0A\r");
    put(lamp, "OPN40\r");
    read_until(lamp, "\r");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    put(lamp, "CLS3A\r");
    read_until(lamp, "\r");
    put(world.control[0], "TRUTH\n");
    const std::string truth = read_until(world.control[0], "\n");
    CHECK(truth.starts_with("TRUTH 1 0 0x0p+0 40 40 "));
    put(world.control[0], "SIMFAULT stage close\nSIMFAULT stage melt\n");
    CHECK(read_until(world.control[0], "melt").starts_with("OK\nERROR "));
    put(world.control[0], "WEIGH 0 1\n");
    CHECK(read_until(world.control[0], "ice lab").find("ERROR WEIGH material weighing") != std::string::npos);
    CHECK(read_until(stage, "never") == "");
    ::close(stage);
    ::close(lamp);
  }
  CHECK(fs::exists(folder.path / "world" / "state"));
  CHECK_FALSE(fs::exists(folder.path / "io" / "stage"));
  {
    Served again(folder.path);
    put(again.control[0], "TRUTH\n");
    CHECK(read_until(again.control[0], "\n").starts_with("TRUTH 1 0 "));
    put(again.control[0], "STOP done\n");
  }
  const WorldHistory h = read_history(folder.path / "world.rec");
  CHECK(h.begins.size() == 2);
  CHECK(h.begins[1].restored == 1);
  CHECK(h.lamp.size() == 2);
}

TEST_CASE("When the launcher dies, nature stays until the drivers have made their instruments safe") {
  const Folder folder;
  {
    Served world(folder.path);
    const int lamp = open_port(folder.path / "io" / "lamp");
    put(lamp, "CONN18\r");
    CHECK(read_until(lamp, "\r") == "READY0A\r");
    put(lamp, "OPN40\r");
    read_until(lamp, "\r");
    ::shutdown(world.control[0], SHUT_RDWR);  // the other end of the control line is gone
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    put(lamp, "CLS3A\r");
    CHECK(read_until(lamp, "\r") == "ReceivedBF\r");
    ::close(lamp);
  }
  const WorldHistory h = read_history(folder.path / "world.rec");
  REQUIRE(h.lamp.size() == 2);
  CHECK(h.lamp[1].event == LampEvent::kClosed);
}

TEST_CASE("World and drivers meet on a socket whose path is longer than the address of a Unix socket") {
  const Folder folder;
  const fs::path run = folder.path / std::string(120, 'x');
  fs::create_directories(run);
  Served world(run);
  Ports ports({unix_port((run / "io" / "stage").string()),
               unix_port((folder.path / std::string(130, 'y') / "lamp").string())});
  std::vector<std::pair<PortId, LinkState>> links;
  std::string text;
  ports.open_all(0);
  for (int n = 0; n < 1000 && text.find("%5\n") == std::string::npos; ++n) {
    ports.service(
        n * 1000,
        [&](PortId port, LinkState state) {
          links.emplace_back(port, state);
          const std::string_view ask = "ENABLE @0\nAXISSTATUS(@0)\n";
          ports.write(port, std::as_bytes(std::span(ask)), false);
        },
        [&](PortId, std::span<const std::byte> bytes) {
          text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        });
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(text == "%\n%5\n");
  REQUIRE(links.size() == 1);  // nobody made the folder of the lamp
  CHECK(links[0] == std::pair(PortId(0), LinkState::kOpen));
}

TEST_CASE("Arguments of the world are checked by name") {
  const ServeOptions o =
      parse_serve_options({"--run", "r", "--time-scale", "2.5", "--offset-us", "7", "--incarnation", "3"});
  CHECK(o.time_scale == 2.5);
  CHECK(o.offset_us == 7);
  CHECK(o.io == fs::path("r") / "io");
  CHECK_THROWS_WITH(parse_serve_options({"--run"}), Catch::Contains("--run"));
  CHECK_THROWS_WITH(parse_serve_options({"--io", "x"}), Catch::Contains("--run is missing"));
  CHECK_THROWS_WITH(parse_serve_options({"--run", "r", "--time-scale", "fast"}), Catch::Contains("fast"));
  CHECK_THROWS_WITH(parse_serve_options({"--speed", "2"}), Catch::Contains("--speed"));
}

TEST_CASE("An experiment's numbers reach nature, the controllers' beliefs do not") {
  Experiment e;
  e.plant.size_std = 0.07;
  e.plant.flow = 0.9;
  e.plant.spread = 1.1;
  e.plant.seed = 99;
  e.model.h1_mm = 0.009;
  e.stage.x_max_mm = 77.0;
  e.lamp.max_on_s = 5.0;
  const WorldConfig c = world_config(e);
  CHECK(c.droplet.size_scatter == 0.07);
  CHECK(c.droplet.flow == 0.9);
  CHECK(c.droplet.spread == 1.1);
  CHECK(c.seed == 99);
  CHECK(c.lu2015.h1_mm == 0.0044);
  CHECK(c.stage.high_limit_mm[0] == 77.0);
  CHECK(c.lamp.max_on_us == 5'000'000);
  check(c);
  e.plant.model = "lu2015";
  CHECK(world_config(e).model == "lu2015");
}

TEST_CASE("The drift of an ice lab's valves is drawn from the seed, either way and for each valve") {
  Experiment e;
  e.lab.kind = "ice";
  e.plant.ice.drift_water = 0.05;
  CHECK(world_config(e).ice.disturbance.roughness == IceDisturbanceParams{}.roughness);
  e.plant.ice.roughness = 0.56;
  CHECK(world_config(e).ice.disturbance.roughness == 0.56);
  CHECK(world_config(e).ice.line[0].drift == 0.05);
  CHECK(world_config(e).ice.line[1].drift == 0.0);
  e.plant.ice.drift_water = 0.0;
  e.plant.ice.drift_spread = 0.2;
  int rising = 0, alike = 0;
  for (e.plant.seed = 1; e.plant.seed <= 200; ++e.plant.seed) {
    const WorldConfig c = world_config(e);
    check(c);
    for (const auto& line : c.ice.line) CHECK(std::abs(line.drift) <= 0.2);
    rising += c.ice.line[0].drift > 0.0;
    alike += c.ice.line[0].drift == c.ice.line[1].drift;
  }
  CHECK(rising > 70);
  CHECK(rising < 130);
  CHECK(alike == 0);
}
