#include "files/path/trajectory_file.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "core/grid/random.h"

using namespace firn;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

fs::path folder() {
  const fs::path f = fs::path(FIRN_BINARY_DIR) / "tests" / "trajectory_file";
  fs::create_directories(f);
  return f;
}

PlannedPath some_path(std::int64_t id, std::size_t samples) {
  RandomStream random(std::uint64_t(id), Purpose::kTest);
  PlannedPath p{1, 0, PathKind::kFill, 10.0, {}};
  p.trajectory = {
      id, 0.016, 2, {"rad", "rad"}, {}, {{{"total speed", 0.9, 0.1}}, double(samples) * 0.016, 0.0, 0.4}};
  for (std::size_t n = 0; n < 2 * samples; ++n) p.trajectory.positions.push_back(random.uniform(-1, 1));
  return p;
}

std::vector<std::byte> trajectory_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

std::size_t read_trajectory(TrajectoryReader reader) {
  std::size_t n = 0;
  while (reader.next()) ++n;
  return n;
}

const TrajectoryHead kTrajectoryHead{"cobra600", "thesis",     "firn test",   0.016,
                                     {1, 2},     {"J1", "J2"}, {"rad", "rad"}};

std::vector<std::byte> written_trajectory(const fs::path& file) {
  TrajectoryWriter out(file, kTrajectoryHead);
  for (std::int64_t id = 1; id <= 5; ++id) out.add(some_path(id, std::size_t(id) * 30));
  out.finish();
  return trajectory_bytes(file);
}

}  // namespace

TEST_CASE("A trajectory file reads back path by path, to the same bits, with its totals") {
  const fs::path file = folder() / "whole.traj";
  written_trajectory(file);
  TrajectoryReader reader(file);
  CHECK(reader.head() == kTrajectoryHead);
  for (std::int64_t id = 1; id <= 5; ++id) {
    const auto path = reader.next();
    REQUIRE(path);
    CHECK(path->trajectory.id == id);
    CHECK(path->trajectory.positions == some_path(id, std::size_t(id) * 30).trajectory.positions);
  }
  CHECK_FALSE(reader.next());
  CHECK_FALSE(reader.next());
  CHECK(reader.totals().paths == 5);
  CHECK(reader.totals().samples == 450);
}

TEST_CASE(
    "A file that is not finished never has its name, and one that is cut anywhere is called damaged or "
    "incomplete") {
  const fs::path file = folder() / "cut.traj";
  fs::remove(file);
  {
    TrajectoryWriter out(file, kTrajectoryHead);
    out.add(some_path(1, 10));
  }
  for (const auto& entry : fs::directory_iterator(folder()))  // other tests write beside it at the same time
    CHECK_FALSE(entry.path().filename().string().starts_with("cut.traj"));
  const std::vector<std::byte> bytes = written_trajectory(file);
  CHECK(read_trajectory(TrajectoryReader(bytes)) == 5);
  for (std::size_t n = 0; n < bytes.size(); n += 7)
    CHECK_THROWS_AS(read_trajectory(TrajectoryReader(std::span(bytes).first(n))), TrajectoryFormatError);
}

TEST_CASE("One changed bit anywhere in a trajectory file is found") {
  const std::vector<std::byte> bytes = written_trajectory(folder() / "flip.traj");
  RandomStream random(85, Purpose::kTest);
  std::size_t found = 0, trials = 400;
  for (std::size_t n = 0; n < trials; ++n) {
    std::vector<std::byte> changed = bytes;
    // Behind the file header, whose spare bytes nobody reads, and not in the padding of the last record.
    const std::size_t at = 16 + random.below(std::uint32_t(bytes.size() - 24));
    changed[at] ^= std::byte(1 << random.below(8));
    try {
      read_trajectory(TrajectoryReader(changed));
    } catch (const TrajectoryFormatError& e) {
      found += std::string(e.what()).find("byte ") == 0;
    }
  }
  CHECK(found >= trials - trials / 50);  // padding between records may change unseen: it means nothing
}

TEST_CASE("What is no trajectory file is refused by name") {
  CHECK_THROWS_AS(TrajectoryReader(folder() / "none.traj"), record::FileError);
  const std::vector<std::byte> nothing;
  CHECK_THROWS_WITH(TrajectoryReader(nothing), Contains("no head"));
  const std::vector<std::byte> zeros(1000, std::byte{0});
  CHECK_THROWS_AS(TrajectoryReader(zeros), TrajectoryFormatError);
}
