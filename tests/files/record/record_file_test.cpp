#include "files/record/record_file.h"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstring>

#include "tests/files/record/scratch.h"

using namespace firn::record;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

std::vector<Bytes> write_some(const std::filesystem::path& path, std::size_t n, std::uint64_t seed) {
  Random random{seed};
  std::vector<Bytes> payloads;
  record::RecordWriter writer(path, record::RecordWriter::Mode::kCreate);
  for (std::size_t i = 0; i < n; ++i) {
    payloads.push_back(random_bytes(random, random.below(100)));
    REQUIRE(writer.append(std::uint16_t(i % 7), payloads.back()) == i);
  }
  writer.close();
  return payloads;
}

void expect_all(const std::filesystem::path& path, const std::vector<Bytes>& payloads) {
  const record::MappedFile file(path);
  record::RecordReader reader(file.bytes());
  for (std::size_t i = 0; i < payloads.size(); ++i) {
    const auto record = reader.next();
    REQUIRE(record);
    REQUIRE(record->index == i);
    REQUIRE_FALSE(record->damaged);
    REQUIRE(Bytes(record->payload.begin(), record->payload.end()) == payloads[i]);
  }
  CHECK_FALSE(reader.next());
  CHECK(reader.damage().count() == 0);
  CHECK(reader.valid_end() == file.bytes().size());
}

}  // namespace

TEST_CASE("Records come back as they were written, in order and with their kind") {
  const Scratch scratch("records");
  expect_all(scratch / "a.wal", write_some(scratch / "a.wal", 300, 1));
}

TEST_CASE("A record given in parts reads as the parts joined") {
  const Scratch scratch("parts");
  {
    record::RecordWriter writer(scratch / "a.wal", record::RecordWriter::Mode::kCreate);
    const std::array<std::span<const std::byte>, 4> parts{as_span("deposit"), as_span(""), as_span(" at "),
                                                          as_span("most once")};
    writer.append(9, parts);
    const std::vector<std::span<const std::byte>> many(15, as_span("x"));
    CHECK_THROWS_WITH(writer.append(9, many), Contains("at most 14 parts"));
    CHECK(writer.append(10, as_span("next")) == 1);
  }
  const Bytes bytes = read_bytes(scratch / "a.wal");
  record::RecordReader reader(bytes);
  const auto record = reader.next();
  REQUIRE(record);
  CHECK(record->kind == 9);
  CHECK(Bytes(record->payload.begin(), record->payload.end()).size() == 20);
  CHECK(std::memcmp(record->payload.data(), "deposit at most once", 20) == 0);
  CHECK(reader.next()->kind == 10);
}

TEST_CASE("A written record stands in the file before the writer is closed, as after kill -9") {
  const Scratch scratch("killed");
  record::RecordWriter writer(scratch / "a.wal", record::RecordWriter::Mode::kCreate);
  writer.append(1, as_span("fired"));
  const Bytes bytes = read_bytes(scratch / "a.wal");
  record::RecordReader reader(bytes);
  CHECK(reader.next());
  CHECK(writer.bytes() == bytes.size());
}

TEST_CASE("A buffered writer leaves the same bytes, once it is flushed or gone") {
  const Scratch scratch("buffered");
  for (const std::size_t buffer_bytes : {std::size_t(1), std::size_t(200), std::size_t(1) << 20}) {
    const auto plain = scratch / ("plain" + std::to_string(buffer_bytes)),
               buffered = scratch / ("buffered" + std::to_string(buffer_bytes));
    {
      record::RecordWriter a(plain, record::RecordWriter::Mode::kCreate),
          b(buffered, record::RecordWriter::Mode::kCreate, buffer_bytes);
      for (int n = 0; n < 40; ++n) {
        const std::string text(std::size_t(n * 7 % 50), char('a' + n % 26));
        CHECK(a.append(std::uint16_t(n), as_span(text)) == b.append(std::uint16_t(n), as_span(text)));
        CHECK(a.bytes() == b.bytes());
        if (n != 20) continue;
        b.flush();
        CHECK(read_bytes(plain) == read_bytes(buffered));
      }
    }
    CHECK(read_bytes(plain) == read_bytes(buffered));
  }
}

TEST_CASE("Creating over an existing record file is refused, and so are two writers of one file") {
  const Scratch scratch("exists");
  record::RecordWriter writer(scratch / "a.wal", record::RecordWriter::Mode::kCreate);
  CHECK_THROWS_WITH(record::RecordWriter(scratch / "a.wal", record::RecordWriter::Mode::kCreate),
                    Contains("a.wal") && Contains("exists"));
  CHECK_THROWS_WITH(record::RecordWriter(scratch / "a.wal", record::RecordWriter::Mode::kAppend),
                    Contains("another process"));
}

TEST_CASE(
    "Appending goes on behind the last whole record, wherever the file was cut, and keeps the torn bytes") {
  const Scratch scratch("torn");
  const auto payloads = write_some(scratch / "whole.wal", 12, 2);
  const Bytes whole = read_bytes(scratch / "whole.wal");
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const auto path = scratch / ("cut" + std::to_string(size) + ".wal");
    write_file(path, std::span(whole).first(size));
    std::uint64_t next = 0;
    Bytes torn;
    {
      record::RecordWriter writer(path, record::RecordWriter::Mode::kAppend);
      next = writer.next_index();
      if (!writer.torn_path().empty()) torn = read_bytes(writer.torn_path());
      REQUIRE(writer.append(3, as_span("resumed")) == next);
    }
    const Bytes now = read_bytes(path);
    record::RecordReader reader(now);
    for (std::uint64_t i = 0; i < next; ++i) {
      const auto record = reader.next();
      REQUIRE(record);
      REQUIRE(Bytes(record->payload.begin(), record->payload.end()) == payloads[i]);
    }
    REQUIRE(reader.next()->index == next);
    REQUIRE(reader.damage().count() == 0);
    const std::size_t kept = reader.valid_end() - record::kRecordHeaderBytes - 8;
    if (size >= record::kRecordFileHeaderBytes) {
      REQUIRE(kept + torn.size() == size);
      REQUIRE(std::equal(torn.begin(), torn.end(), whole.begin() + std::ptrdiff_t(kept)));
    }
    std::filesystem::remove(path);
    std::filesystem::remove(path.string() + ".torn-1");
  }
}

TEST_CASE("A second torn tail does not overwrite the first") {
  const Scratch scratch("torn2");
  for (int n = 1; n <= 3; ++n) {
    record::RecordWriter writer(scratch / "a.wal", record::RecordWriter::Mode::kAppend);
    if (n > 1) CHECK(writer.torn_path() == (scratch / ("a.wal.torn-" + std::to_string(n - 1))));
    writer.append(1, as_span("x"));
    writer.close();
    std::ofstream(scratch / "a.wal", std::ios::app) << "torn";
  }
}

TEST_CASE("Appending to a file that is no record file is refused and leaves it alone") {
  const Scratch scratch("foreign");
  write_file(scratch / "thesis.tex", as_span("\\documentclass{article}, years of work"));
  CHECK_THROWS_WITH(record::RecordWriter(scratch / "thesis.tex", record::RecordWriter::Mode::kAppend),
                    Contains("not a record file"));
  CHECK(read_bytes(scratch / "thesis.tex").size() == 38);
}

TEST_CASE("When the disk is full the error names file, byte and cause, and no half record stays") {
  const Scratch scratch("full");
  const auto path = scratch / "a.wal";
  record::RecordWriter writer(path, record::RecordWriter::Mode::kCreate);
  writer.append(1, as_span("first"));
  const std::uint64_t end = writer.bytes();

  struct rlimit before {};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit tight = before;
  tight.rlim_cur = end + 50;  // room for part of the next record
  REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
  const Bytes large(1000);
  std::string said;
  bool full = false;
  try {
    writer.append(2, large);
  } catch (const record::FileError& e) {
    said = e.what();
    full = e.disk_full();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);

  CHECK(full);
  CHECK_THAT(said, Contains("a.wal: byte " + std::to_string(end + 50)) && Contains("File too large"));
  CHECK(std::filesystem::file_size(path) == end);
  CHECK(writer.append(2, large) == 1);  // room again: goes on
  writer.sync();
  const Bytes bytes = read_bytes(path);
  record::RecordReader reader(bytes);
  CHECK(reader.next()->payload.size() == 5);
  CHECK(reader.next()->payload.size() == 1000);
  CHECK(reader.damage().count() == 0);
}
