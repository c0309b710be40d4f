#include "files/record/packed.h"

#include <sys/mman.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "core/grid/random.h"
#include "files/record/file.h"
#include "files/record/record_file.h"
#include "tests/support/temp_folder.h"

namespace firn::logfile {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> noise(RandomStream& random, std::size_t n) {
  std::vector<std::byte> bytes(n);
  for (std::byte& b : bytes) b = std::byte(random.below(256));
  return bytes;
}

std::vector<std::byte> content(const fs::path& file) {
  const MappedFile mapped(file);
  return {mapped.bytes().begin(), mapped.bytes().end()};
}

void write(const fs::path& file, std::span<const std::byte> bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

/// A record file whose payloads repeat parts of `log`.
void write_records(const fs::path& file, RandomStream& random, std::span<const std::byte> log) {
  RecordWriter writer(file, RecordWriter::Mode::kCreate);
  for (int n = 0; n < 200; ++n) {
    const std::size_t length = random.below(300);
    writer.append(std::uint16_t(random.below(5)),
                  log.subspan(random.below(std::uint32_t(log.size() - length)), length));
  }
  writer.close();
}

TEST_CASE("a packed file reads as the plain one: records, damaged records, any other bytes, nothing") {
  RandomStream random(7, Purpose::kTest);
  for (int n = 0; n < 40; ++n) {
    INFO("case " << n);
    const test::TempFolder folder;
    fs::create_directory(folder.path() / "nodes");
    const fs::path log = folder.path() / "log.lcm", wal = folder.path() / "nodes" / "a.wal";
    const std::vector<std::byte> known = noise(random, 20'000);
    write(log, known);
    write_records(wal, random, known);
    std::vector<std::byte> plain = content(wal);
    if (n % 4 == 1)
      for (int flip = 0; flip < 9; ++flip) plain[random.below(std::uint32_t(plain.size()))] ^= std::byte(4);
    if (n % 4 == 2) plain.resize(random.below(std::uint32_t(plain.size())));
    if (n % 4 == 3) plain = noise(random, random.below(3000));
    write(wal, pack(plain, known, "../log.lcm"));
    CHECK(is_packed(wal));
    CHECK(content(wal) == plain);
    write(log, pack(known, {}, ""));  // the known file may be packed itself
    CHECK(content(wal) == plain);
  }
}

TEST_CASE("a file that repeats the messages of the log takes less than a fifth of its room") {
  RandomStream random(8, Purpose::kTest);
  const test::TempFolder folder;
  const std::vector<std::byte> known = noise(random, 300'000);
  write_records(folder.path() / "a.wal", random, known);
  const std::vector<std::byte> plain = content(folder.path() / "a.wal");
  CHECK(pack(plain, known, "log.lcm").size() * 5 < plain.size());
  CHECK(pack(plain, {}, "").size() * 2 > plain.size());
}

TEST_CASE("a packed file that is damaged, cut or without its known file is named, and nothing crashes") {
  RandomStream random(9, Purpose::kTest);
  const test::TempFolder folder;
  const fs::path log = folder.path() / "log.lcm", wal = folder.path() / "a.wal";
  const std::vector<std::byte> known = noise(random, 5000);
  write(log, known);
  write_records(wal, random, known);
  const std::vector<std::byte> plain = content(wal), packed = pack(plain, known, "log.lcm");
  for (int n = 0; n < 400; ++n) {
    std::vector<std::byte> bad = packed;
    bad[random.below(std::uint32_t(bad.size()))] ^= std::byte(1 << random.below(8));
    if (n % 3 == 0) bad.resize(random.below(std::uint32_t(bad.size())));
    write(wal, bad);
    try {
      const std::vector<std::byte> read = content(wal);
      CHECK((read == plain || !is_packed(wal)));
    } catch (const std::runtime_error& e) {
      CHECK_THAT(e.what(), Catch::Contains("a.wal") || Catch::Contains("lo"));  // or the name it asks for
    }
  }
  write(wal, packed);
  write(log, noise(random, 5000));
  CHECK_THROWS_WITH(content(wal), Catch::Contains("log.lcm is not as it was"));
  fs::remove(log);
  CHECK_THROWS_WITH(content(wal), Catch::Contains("log.lcm"));
}

}  // namespace
}  // namespace firn::logfile
