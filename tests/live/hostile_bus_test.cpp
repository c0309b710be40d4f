// Live prints while another program of this host sends to their bus whatever it can.
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>
#include <thread>

#include "core/grid/random.h"
#include "firn/enable_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "print/process/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/transport_wire.h"
#include "tests/live/live_checks.h"
#include "tests/procs/foreigner.h"

using namespace firn;
using namespace firn::test;

namespace {

/// Listens to a run's bus, and while it lives sends forged, repeated, altered and malformed datagrams.
class Attacker {
 public:
  /// @param sealed whether the bus has a key; else only such forgeries are sent as jumps betray
  Attacker(const LiveRun& run, bool sealed)
      : url_(url_of(run)),
        run_id_(run.folder().run_id()),
        sealed_(sealed),
        listener_(url_ + (sealed ? "&key=none" : "")),
        foreigner_(port_of(url_)),
        thread_([this] { attack(); }) {}
  ~Attacker() {
    over_ = true;
    thread_.join();
  }
  int rounds() const { return rounds_; }
  int repeated() const { return repeated_; }

 private:
  static std::string url_of(const LiveRun& run) {
    std::ifstream clocks(run.path() / "clocks");
    std::string url;
    for (std::string line, word; std::getline(clocks, line);)
      for (std::istringstream words(line); words >> word;) url = word;
    return url;
  }
  static int port_of(const std::string& url) { return std::stoi(url.substr(url.rfind(':') + 1)); }

  void attack() {
    for (const char* channel : {"ENABLE", "SAFE_STOP", "HEIGHT_MAP", "HEIGHT_PROFILE", "STAGE_COMMAND",
                                "JET_COMMAND", "LAYER_PLAN", "ANSWER_STAGE", "HEARTBEAT_JET"})
      listener_.subscribe(channel);
    while (!over_) {
      pollfd p{listener_.fd(), POLLIN, 0};
      ::poll(&p, 1, 20);
      listener_.receive([&](std::string_view channel, std::span<const std::byte> b) {
        if (const auto h = wire::read_header(b)) {
          seq_[std::string(channel)] = h->seq;
          incarnation_ = h->incarnation;
        }
        auto& heard = heard_[std::string(channel)];
        if (heard.size() < 20) heard.emplace_back(b.begin(), b.end());
      });
      malformed();
      jumps();
      if (sealed_) {
        forged();
        again();
      }
      ++rounds_;
      ::usleep(15'000);  // a flood is another matter: it takes processor time from the lease
    }
  }

  void to_group(const std::string& channel, const Bytes& b) {
    foreigner_.to_group(short_message(channel, {reinterpret_cast<const char*>(b.data()), b.size()}));
  }
  template <class Message>
  void forge(const std::string& channel, Message m) {
    m.header.run_id = run_id_;
    m.header.incarnation = incarnation_;
    m.header.seq = seq_[channel] + 1;
    Bytes b(std::size_t(m.getEncodedSize()));
    m.encode(b.data(), 0, int(b.size()));
    to_group(channel, b);
  }

  void malformed() {
    for (const Bytes& b : malformed_datagrams()) {
      foreigner_.to_group(b);
      foreigner_.to_this_host(b);
    }
    to_group("ENABLE", Bytes(7));
    to_group("HEIGHT_MAP_TILES", Bytes(600, std::byte{0xff}));
  }
  void jumps() {
    safe_stop_t stop{};
    stop.enable_epoch = std::int64_t(1) << 53;
    stop.cause = "forged";
    forge("SAFE_STOP", stop);
    enable_t enable{};
    enable.enable_epoch = std::int64_t(1) << 53;
    enable.enabled = 1;
    enable.lease_s = 60.0;
    forge("ENABLE", enable);
    height_map_t map{};
    map.layer = 1'000'000;
    map.map_id = 1;
    forge("HEIGHT_MAP", map);
  }
  void forged() {
    safe_stop_t stop{};
    stop.enable_epoch = 2;
    forge("SAFE_STOP", stop);
    fault_t fault{};
    fault.severity = 2;
    fault.node = "stage";
    forge("FAULT_STAGE", fault);
  }
  void again() {
    for (const auto& [channel, heard] : heard_) {
      const Bytes& bytes = heard[random_.below(std::uint32_t(heard.size()))];
      to_group(channel, bytes);
      Bytes turned = bytes;
      turned[random_.below(std::uint32_t(turned.size()))] ^= std::byte(1 << random_.below(8));
      to_group(channel, turned);
      ++repeated_;
    }
  }

  std::string url_;
  std::int64_t run_id_;
  bool sealed_;
  LcmBus listener_;
  Foreigner foreigner_;
  RandomStream random_{9, Purpose::kTest};
  std::map<std::string, std::int64_t> seq_;
  std::int32_t incarnation_ = 0;
  std::map<std::string, std::vector<Bytes>> heard_;  // by channel
  std::atomic<bool> over_ = false;
  std::atomic<int> rounds_ = 0, repeated_ = 0;
  std::thread thread_;
};

}  // namespace

TEST_CASE("a print goes on while another program forges, repeats and alters its messages, and reports them") {
  if (skipped()) return;
  LiveRun run(tiny_part(61));
  INFO(run.path());
  run.start(false);
  REQUIRE(run.wait_started());
  int status = -1;
  {
    Attacker attacker(run, true);
    status = run.wait_finished();
    CHECK(attacker.rounds() > 5);
    CHECK(attacker.repeated() > 10);
  }
  INFO(run.said());
  CHECK(status == 0);
  CHECK_THAT(run.said(), Catch::Contains("foreign datagrams dropped") && Catch::Contains("a fragment") &&
                             Catch::Contains("no channel") && Catch::Contains("without the key of the run") &&
                             Catch::Contains("repeated"));
  check_finished_run(run);
}

TEST_CASE("a print on a bus without a key goes on and resumes under epochs and layers far ahead") {
  if (skipped()) return;
  LiveRun run(tiny_part(62));
  INFO(run.path());
  run.bus_url = default_bus_url(free_bus_port(run.folder().run_id())) + "&key=none";
  run.start(false);
  REQUIRE(run.wait_started());
  {
    Attacker attacker(run, false);
    ::usleep(1'000'000);
    run.kill("jet");
    CHECK(run.wait() == 3);
    CHECK(attacker.rounds() > 2);
  }
  run.wait_all_gone();
  run.start(true);
  REQUIRE(run.wait_started());
  int status = -1;
  {
    Attacker attacker(run, false);
    status = run.wait_finished();
    CHECK(attacker.rounds() > 5);
  }
  INFO(run.said());
  CHECK(status == 0);
  CHECK_THAT(run.said(), Catch::Contains("any program on this host may speak"));
  std::stringstream scheduler;
  scheduler << std::ifstream(run.path() / "nodes" / "scheduler.err").rdbuf();
  CHECK_THAT(scheduler.str(), Catch::Contains("SAFE_STOP: enable_epoch = 9007199254740992 cannot follow"));
  check_finished_run(run);
}
