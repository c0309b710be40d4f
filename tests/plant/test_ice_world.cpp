#include <catch2/catch.hpp>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/grid/random.h"
#include "tests/plant/ice_bench.h"

using namespace firn;
using namespace firn::plant;

TEST_CASE("A world saved in the middle of a path goes on bit for bit, and one of another lab is refused") {
  const IceWorldConfig c = small();
  const auto run = line_of(c);
  const auto folder = std::filesystem::temp_directory_path() / ("ice_state_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  IceBench b(c);
  prepare(b, run);
  b.robot("PATH RUN 7 1");
  b.run(300'000);
  for (const auto port : kIcePortNames) b.world.disconnect(port, b.now_us);
  b.world.save(folder / "state");
  World again = World::restore(folder / "state", b.world.config(), nullptr);
  for (World* world : {&b.world, &again}) {
    world->advance(b.now_us + 700'000, [](const World::Sent&) {});
    world->advance(b.now_us + 9'000'000, [](const World::Sent&) {});
  }
  b.world.save(folder / "a");
  again.save(folder / "b");
  const auto bytes = [&](const char* name) {
    std::ifstream file(folder / name, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(file)), {});
  };
  CHECK(bytes("a") == bytes("b"));
  CHECK(bytes("a").size() > 100'000);
  CHECK_THROWS_WITH(World::restore(folder / "a", WorldConfig{}, nullptr),
                    Catch::Contains("of another configuration"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("Whatever bytes arrive at the ice lab's ports, nothing fires and nothing breaks") {
  IceBench b(small());
  RandomStream random(4, Purpose::kTest);
  const char* words[] = {"@1 HELLO FIRN 1*E003\r\n",
                         "@2 PATH P 0 1 2 3 4",
                         "PATH RUN 1 7*",
                         "\xA5\x5A\x02\x01",
                         "AS\r",
                         "SW,HB,1,9\r",
                         "T?*",
                         "S,9,99999*"};
  for (int n = 0; n < 4000; ++n) {
    std::string bytes;
    if (random.below(3) == 0) bytes = words[random.below(8)];
    for (std::uint32_t k = random.below(20); k > 0; --k) bytes.push_back(char(random.below(256)));
    b.world.receive(kIcePortNames[random.below(5)], std::as_bytes(std::span(bytes)), b.now_us);
    b.run(random.below(3000));
  }
  CHECK(b.truth().pulses[0] + b.truth().pulses[1] == 0);
  CHECK(b.world.truth().volume_mm3 == Approx(0.0).margin(1e-9));
}

TEST_CASE("The ice world does not depend on how finely its time is cut") {
  const IceWorldConfig c = small();
  const auto run = line_of(c);
  const auto folder = std::filesystem::temp_directory_path() / ("ice_cut_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::vector<std::string> states;
  for (const bool fine : {false, true}) {
    IceBench b(c);
    prepare(b, run);
    b.robot("PATH RUN 7 1");
    const std::int64_t from_us = b.now_us, until_us = from_us + 1'500'000;
    RandomStream random(6, Purpose::kTest);
    drivers::LineWriter beat;
    beat.text("@60000 HB");
    const std::string sign(beat.finish(1));
    for (std::int64_t t_us = from_us; t_us < until_us;) {
      t_us = std::min(until_us, t_us + 400'000);
      while (fine && b.now_us + 5000 < t_us) b.run(1 + random.below(5000));
      b.run(t_us - b.now_us);
      b.send(kRobotPort, std::as_bytes(std::span(sign.data(), sign.size())));
    }
    b.run(100'000);
    b.world.save(folder / "state");
    std::ifstream file(folder / "state", std::ios::binary);
    states.emplace_back((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  }
  CHECK(states[0] == states[1]);
  std::filesystem::remove_all(folder);
}
