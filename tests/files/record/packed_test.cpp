#include "files/record/packed.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>

#include "core/grid/random.h"
#include "files/record/file.h"
#include "files/record/record_file.h"
#include "files/record/squeeze.h"
#include "tests/support/peak_memory.h"
#include "tests/support/temp_folder.h"

namespace firn::record {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> noise(RandomStream& random, std::size_t n) {
  std::vector<std::byte> bytes(n);
  for (std::byte& b : bytes) b = std::byte(random.below(256));
  return bytes;
}

std::vector<std::byte> content(const fs::path& file) {
  const record::MappedFile mapped(file);
  return {mapped.bytes().begin(), mapped.bytes().end()};
}

void write(const fs::path& file, std::span<const std::byte> bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

/// A record file whose payloads, short and long ones, repeat parts of `log`.
void write_records(const fs::path& file, RandomStream& random, std::span<const std::byte> log) {
  record::RecordWriter writer(file, record::RecordWriter::Mode::kCreate);
  for (int n = 0; n < 200; ++n) {
    const std::size_t length = n % 2 == 0 ? random.below(300) : 600 + random.below(300);
    writer.append(std::uint16_t(random.below(5)),
                  log.subspan(random.below(std::uint32_t(log.size() - length)), length));
  }
  writer.close();
}

TEST_CASE(
    "a file is packed with the known text where long messages may repeat it, and not for short ones alone") {
  RandomStream random(11, Purpose::kTest);
  const std::vector<std::byte> known = noise(random, 20'000);
  const test::TempFolder folder;
  const auto needs_known = [&](const char* name, std::size_t length) {
    const fs::path file = folder.path() / name;
    {
      record::RecordWriter writer(file, record::RecordWriter::Mode::kCreate);
      for (int n = 0; n < 50; ++n) writer.append(1, std::span(known).subspan(random.below(10'000), length));
      writer.close();
    }
    std::uint32_t bytes_of_name = 0;  // docs/formats.md: at byte 40
    std::memcpy(&bytes_of_name, record::pack(content(file), known, "log.lcm").data() + 40, 4);
    return bytes_of_name > 0;
  };
  CHECK(needs_known("long", record::kLongPayload_bytes));
  CHECK_FALSE(needs_known("short", record::kLongPayload_bytes - 1));
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
    write(wal, record::pack(plain, known, "../log.lcm"));
    CHECK(record::is_packed(wal));
    CHECK(content(wal) == plain);
    write(log, record::pack(known, {}, ""));  // the known file may be packed itself
    CHECK(content(wal) == plain);
  }
}

TEST_CASE("a file that repeats the messages of the log takes less than a fifth of its room") {
  RandomStream random(8, Purpose::kTest);
  const test::TempFolder folder;
  const std::vector<std::byte> known = noise(random, 300'000);
  write_records(folder.path() / "a.wal", random, known);
  const std::vector<std::byte> plain = content(folder.path() / "a.wal");
  CHECK(record::pack(plain, known, "log.lcm").size() * 5 < plain.size());
  CHECK(record::pack(plain, {}, "").size() * 2 > plain.size());
}

TEST_CASE("a packed file that is damaged, cut or without its known file is named, and nothing crashes") {
  RandomStream random(9, Purpose::kTest);
  const test::TempFolder folder;
  const fs::path log = folder.path() / "log.lcm", wal = folder.path() / "a.wal";
  const std::vector<std::byte> known = noise(random, 5000);
  write(log, known);
  write_records(wal, random, known);
  const std::vector<std::byte> plain = content(wal), packed = record::pack(plain, known, "log.lcm");
  for (int n = 0; n < 400; ++n) {
    std::vector<std::byte> bad = packed;
    bad[random.below(std::uint32_t(bad.size()))] ^= std::byte(1 << random.below(8));
    if (n % 3 == 0) bad.resize(random.below(std::uint32_t(bad.size())));
    write(wal, bad);
    try {
      const std::vector<std::byte> read = content(wal);
      CHECK((read == plain || !record::is_packed(wal)));
    } catch (const std::runtime_error& e) {
      CHECK_THAT(e.what(), Catch::Contains("a.wal") || Catch::Contains("lo"));  // or the name it asks for
    }
  }
  std::vector<std::byte> longer = packed;
  longer.push_back(std::byte(0));
  write(wal, longer);
  CHECK_THROWS_WITH(content(wal), Catch::Contains("it is not as it was written"));
  write(wal, packed);
  write(log, noise(random, 5000));
  CHECK_THROWS_WITH(content(wal), Catch::Contains("log.lcm is not as it was"));
  fs::remove(log);
  CHECK_THROWS_WITH(content(wal), Catch::Contains("log.lcm"));
}

/// A packed file with these numbers in its header.
std::vector<std::byte> crafted(std::uint64_t plain, std::uint64_t squeezed, const std::string& name,
                               std::span<const std::byte> frame = {}) {
  std::vector<std::byte> file(48 + name.size() + frame.size());
  const std::uint32_t length = std::uint32_t(name.size());
  std::memcpy(file.data(), "FIRNPAC1", 8);
  std::memcpy(file.data() + 8, &plain, 8);
  std::memcpy(file.data() + 16, &squeezed, 8);
  std::memcpy(file.data() + 40, &length, 4);
  std::memcpy(file.data() + 48, name.data(), name.size());
  if (!frame.empty()) std::memcpy(file.data() + 48 + name.size(), frame.data(), frame.size());
  return file;
}

TEST_CASE("a packed file asks for no other file than the log of its own run") {
  const test::TempFolder folder;
  const fs::path file = folder.path() / "a.wal";
  for (const std::string& name :
       {std::string("/etc/passwd"), std::string("../../log.lcm"), std::string("a/../log.lcm"),
        std::string("b.wal"), std::string("log.lcm\0", 8), std::string(".")}) {
    write(file, crafted(1, 1, name));
    CHECK_THROWS_WITH(content(file), Catch::Contains("a.wal: packed file: byte 48"));
  }
}

TEST_CASE("packed files that ask for each other in a circle are refused by name") {
  const test::TempFolder folder;
  write(folder.path() / "log.lcm", crafted(1, 1, "log.lcm"));
  CHECK_THROWS_WITH(content(folder.path() / "log.lcm"), Catch::Contains("log.lcm: packed file: it needs"));
  write(folder.path() / "a.wal", crafted(1, 1, "log.lcm"));
  CHECK_THROWS_WITH(content(folder.path() / "a.wal"), Catch::Contains("log.lcm: packed file: it needs"));
}

TEST_CASE("a small packed file that would fill the memory is refused by its size") {
  const test::TempFolder folder;
  const std::uint64_t huge = std::uint64_t(1) << 50;
  // The head of a zstd frame: magic number, a content size of 8 bytes, a window.
  std::vector<std::byte> frame{std::byte(0x28), std::byte(0xb5), std::byte(0x2f),
                               std::byte(0xfd), std::byte(0xc0), std::byte(0x58)};
  const auto size = std::as_bytes(std::span(&huge, 1));
  frame.insert(frame.end(), size.begin(), size.end());
  write(folder.path() / "a.wal", crafted(huge, huge, "", frame));
  CHECK_THROWS_WITH(
      content(folder.path() / "a.wal"),
      Catch::Contains(
          "a.wal: packed file: byte 8: 1125899906842624 bytes cannot come from a packed file of 62"));
}

TEST_CASE("a named pipe in the place of a record is refused, not waited for") {
  const test::TempFolder folder;
  const fs::path pipe = folder.path() / "log.lcm";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(content(pipe), Catch::Contains("log.lcm: byte 0: cannot map"));
}

TEST_CASE("a large packed file is opened and read through with a part of it in memory at a time") {
  const test::TempFolder folder;
  const fs::path file = folder.path() / "a.wal", log = folder.path() / "log.lcm";
  constexpr std::size_t kBytes = std::size_t(160) << 20;
  {
    std::vector<std::byte> plain(kBytes);
    RandomStream random(5, Purpose::kTest);
    for (std::size_t at = 0; at < kBytes; at += 64) plain[at] = std::byte(random.below(256));
    write(log, plain);
    plain[7] = std::byte{1};
    write(file, record::pack(plain, record::MappedFile(log).bytes(), "log.lcm"));
  }
  const std::size_t peak = test::peak_of([&] {
    const record::MappedFile mapped(file);
    std::uint64_t sum = 0;
    for (std::size_t at = 0; at < mapped.bytes().size(); at += 4096) {
      sum += std::uint64_t(mapped.bytes()[at]);
      mapped.forget_before(at);
    }
    if (sum == 0) ::_exit(2);
  });
  CHECK(peak > 0);
  CHECK(peak < (std::size_t(100) << 20));
  CHECK(content(file)[7] == std::byte{1});
}

TEST_CASE("a file is packed part by part, and a packing that is ended gives no header") {
  RandomStream random(6, Purpose::kTest);
  std::vector<std::byte> plain = noise(random, 3 << 20);
  std::size_t largest = 0, written = 0;
  const auto write = [&](std::span<const std::byte> part) {
    largest = std::max(largest, part.size());
    written += part.size();
  };
  REQUIRE(pack(plain, {}, "", write));
  CHECK(largest < std::size_t(1) << 18);
  CHECK(written > plain.size());  // noise
  CHECK_FALSE(pack(plain, {}, "", write, [&](std::size_t read) { return read < plain.size(); }));
}

TEST_CASE("bytes of a packed file that were read and forgotten read the same again") {
  const test::TempFolder folder;
  std::vector<std::byte> plain(std::size_t(50) << 20, std::byte{7});
  const fs::path file = folder.path() / "a.wal";
  write(file, record::pack(plain, {}, ""));
  const record::MappedFile packed(file);
  packed.forget_before(plain.size());
  CHECK(std::ranges::equal(packed.bytes(), plain));
  write(folder.path() / "plain", plain);
  const record::MappedFile mapped(folder.path() / "plain");
  mapped.forget_before(plain.size());
  CHECK(std::ranges::equal(mapped.bytes(), plain));
}

}  // namespace
}  // namespace firn::record
