#include "files/record/event_log.h"

#include <lcm/lcm.h>
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstring>

#include "tests/files/record/event_samples.h"

using namespace firn;
using namespace firn::record;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

void expect_all(const std::filesystem::path& path, const std::vector<Sample>& samples, bool checked) {
  const record::EventLogFile file(path);
  record::EventLogReader reader = file.reader();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto event = reader.next();
    REQUIRE(event);
    REQUIRE(event->eventnum == i);
    REQUIRE(same(*event, samples[i]));
    REQUIRE_FALSE(event->damaged);
    REQUIRE(event->checked == checked);
  }
  CHECK_FALSE(reader.next());
  CHECK(reader.damage().count() == 0);
}

}  // namespace

TEST_CASE("Events come back as they were written, and the index vouches for each") {
  const Scratch scratch("events");
  const auto samples = some_events(2000, 200, 1);
  write_events(scratch / "log.lcm", samples);
  expect_all(scratch / "log.lcm", samples, true);
  std::filesystem::remove(scratch / "log.lcm.idx");
  expect_all(scratch / "log.lcm", samples, false);
}

TEST_CASE("LCM's own reader reads every event of our log") {
  const Scratch scratch("lcm-reads");
  const auto samples = some_events(1000, 3000, 2);
  write_events(scratch / "log.lcm", samples);
  lcm_eventlog_t* log = lcm_eventlog_create((scratch / "log.lcm").c_str(), "r");
  REQUIRE(log);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    lcm_eventlog_event_t* e = lcm_eventlog_read_next_event(log);
    REQUIRE(e);
    REQUIRE(e->eventnum == std::int64_t(i));
    REQUIRE(e->timestamp == samples[i].utime_us);
    REQUIRE(std::string(e->channel, std::size_t(e->channellen)) == samples[i].channel);
    REQUIRE(std::size_t(e->datalen) == samples[i].data.size());
    REQUIRE(std::memcmp(e->data, samples[i].data.data(), samples[i].data.size()) == 0);
    lcm_eventlog_free_event(e);
  }
  CHECK(lcm_eventlog_read_next_event(log) == nullptr);
  lcm_eventlog_destroy(log);
}

TEST_CASE("Our reader reads every event of a log written by LCM, also one that LCM appended to") {
  const Scratch scratch("lcm-writes");
  const auto samples = some_events(500, 3000, 3);
  std::size_t n = 0;
  for (const char* mode : {"w", "a"}) {  // LCM's append counts from 0 again
    lcm_eventlog_t* log = lcm_eventlog_create((scratch / "log.lcm").c_str(), mode);
    REQUIRE(log);
    for (std::size_t i = 0; i < 250; ++i) {
      const Sample& s = samples[n++];
      lcm_eventlog_event_t e{};
      e.timestamp = s.utime_us;
      e.channellen = std::int32_t(s.channel.size());
      e.channel = const_cast<char*>(s.channel.data());
      e.datalen = std::int32_t(s.data.size());
      e.data = const_cast<std::byte*>(s.data.data());
      REQUIRE(lcm_eventlog_write_event(log, &e) == 0);
    }
    lcm_eventlog_destroy(log);
  }
  const record::EventLogFile file(scratch / "log.lcm");
  record::EventLogReader reader = file.reader();
  for (const Sample& s : samples) {
    const auto event = reader.next();
    REQUIRE(event);
    REQUIRE(same(*event, s));
  }
  CHECK_FALSE(reader.next());
  CHECK(reader.damage().count() == 0);
}

TEST_CASE("Events wait in memory until a large piece is full or the caller flushes") {
  const Scratch scratch("batch");
  record::EventLogWriter writer(scratch / "log.lcm");
  const Bytes data(100'000);
  for (int i = 0; i < 10; ++i) writer.append(1000 + i, "HEIGHT_MAP", data);
  CHECK(writer.bytes() == 0);
  CHECK(writer.pending_events() == 10);
  writer.append(1010, "HEIGHT_MAP", data);
  CHECK(writer.bytes() > std::size_t(1) << 20);
  CHECK(writer.pending_events() == 0);
  writer.append(2000, "HEIGHT_MAP", data);
  CHECK(writer.pending_events() == 1);
  writer.flush();
  CHECK(writer.pending_events() == 0);
  CHECK(std::filesystem::file_size(scratch / "log.lcm") == writer.bytes());
  writer.close();
  const record::EventLogFile file(scratch / "log.lcm");
  CHECK(file.index().entries().size() == 12);
  CHECK(file.index().channel(file.index().entries()[3].channel) == "HEIGHT_MAP");
}

TEST_CASE("Channels and data that the format cannot hold are refused by name") {
  const Scratch scratch("refuse");
  record::EventLogWriter writer(scratch / "log.lcm");
  CHECK_THROWS_WITH(writer.append(0, "", as_span("x")), Contains("channel ''"));
  CHECK_THROWS_WITH(writer.append(0, std::string(64, 'A'), as_span("x")), Contains("1 to 63"));
  CHECK_THROWS_WITH(writer.append(0, "BELL\a", as_span("x")), Contains("printable"));
  writer.append(0, std::string(63, 'A'), as_span(""));
  writer.close();
  expect_all(scratch / "log.lcm", {{0, std::string(63, 'A'), {}}}, true);
}

TEST_CASE(
    "When the disk is full the log and its index hold whole events only, and the rest is kept and can "
    "follow") {
  for (const std::uint64_t room : {0u, 10u, 5'000u, 30'000u, 77'777u}) {
    const Scratch scratch("full");
    const auto path = scratch / "log.lcm";
    const auto samples = some_events(400, 1000, 4);
    record::EventLogWriter writer(path);
    for (std::size_t i = 0; i < 100; ++i)
      writer.append(samples[i].utime_us, samples[i].channel, samples[i].data);
    writer.flush();
    for (std::size_t i = 100; i < 400; ++i)
      writer.append(samples[i].utime_us, samples[i].channel, samples[i].data);
    const std::uint64_t due = writer.bytes() + writer.pending_bytes();

    struct rlimit before {};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    struct rlimit tight = before;
    tight.rlim_cur = writer.bytes() + room;
    REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    std::string said;
    bool full = false;
    try {
      writer.flush();
    } catch (const record::FileError& e) {
      said = e.what();
      full = e.disk_full();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, old_handler);

    CHECK(full);
    CHECK_THAT(said, Contains("log.lcm") && Contains("cannot write") && Contains("File too large"));
    CHECK(writer.bytes() + writer.pending_bytes() == due);  // nothing is forgotten
    {
      const record::EventLogFile file(path);
      record::EventLogReader reader = file.reader();
      std::size_t whole = 0;
      while (const auto event = reader.next()) REQUIRE(same(*event, samples[whole++]));
      CHECK(whole + writer.pending_events() == 400);
      CHECK(reader.damage().count() == 0);
      CHECK(file.index().entries().size() <= whole);
    }
    writer.close();  // room again
    expect_all(path, samples, true);
  }
}

TEST_CASE("A writer that may keep no more names what it does not take") {
  const Scratch scratch("bounded");
  record::EventLogWriter::Options options;
  options.flush_bytes = 1000;
  options.max_pending_bytes = 2000;
  record::EventLogWriter writer(scratch / "log.lcm", options);
  struct rlimit before {};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit tight = before;
  tight.rlim_cur = 16;
  REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
  int refused = 0;
  for (int i = 0; i < 40; ++i) try {
      writer.append(i, "STATE_JET", Bytes(172));
    } catch (const record::FileError&) {
      ++refused;
    }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  CHECK(refused > 0);
  CHECK(writer.pending_bytes() <= 2000);
  CHECK(writer.pending_events() + writer.dropped_events() == 40);
}

TEST_CASE("Appending goes on behind the last whole event, wherever log and index were cut") {
  const Scratch scratch("continue");
  const auto samples = some_events(40, 60, 5);
  write_events(scratch / "whole.lcm", samples);
  const Bytes log = read_bytes(scratch / "whole.lcm"), index = read_bytes(scratch / "whole.lcm.idx");
  Random random{5};
  for (std::size_t size = 0; size <= log.size(); size += 1 + random.below(4)) {
    const auto path = scratch / "log.lcm";
    write_file(path, std::span(log).first(size));
    write_file(scratch / "log.lcm.idx",
               std::span(index).first(random.below(2) ? index.size() : random.below(index.size())));
    std::vector<Sample> expected;
    std::uint64_t end = 0;
    while (expected.size() < samples.size()) {
      const Sample& s = samples[expected.size()];
      const std::uint64_t bytes = record::kEventHeaderBytes + s.channel.size() + s.data.size();
      if (end + bytes > size) break;
      end += bytes;
      expected.push_back(s);
    }
    {
      record::EventLogWriter::Options options;
      options.mode = record::EventLogWriter::Mode::kAppend;
      record::EventLogWriter writer(path, options);
      REQUIRE(writer.events() == expected.size());
      REQUIRE(writer.torn_path().empty() == (end == size));
      if (end != size) REQUIRE(read_bytes(writer.torn_path()).size() == size - end);
      expected.push_back({99'999'999, "RUN_START", Bytes(9)});
      writer.append(expected.back().utime_us, expected.back().channel, expected.back().data);
      writer.close();
    }
    expect_all(path, expected, true);
    std::filesystem::remove(scratch / "log.lcm.torn-1");
  }
}

TEST_CASE("Appending to a file that is no log is refused and leaves it alone") {
  const Scratch scratch("foreign");
  write_file(scratch / "data.csv", as_span("time,height\n0,1\n1,2\n2,3\n3,4\n4,5\n"));
  record::EventLogWriter::Options options;
  options.mode = record::EventLogWriter::Mode::kAppend;
  CHECK_THROWS_WITH(record::EventLogWriter(scratch / "data.csv", options), Contains("not an LCM log"));
  CHECK(read_bytes(scratch / "data.csv").size() == 32);
}

TEST_CASE("The index of another log is ignored, not believed") {
  const Scratch scratch("other-index");
  const auto samples = some_events(50, 100, 6);
  write_events(scratch / "a.lcm", samples);
  write_events(scratch / "b.lcm", some_events(50, 100, 7));
  std::filesystem::rename(scratch / "b.lcm.idx", scratch / "a.lcm.idx");
  const record::EventLogFile file(scratch / "a.lcm");
  record::EventLogReader reader = file.reader();
  CHECK(reader.index_ignored());
  std::size_t n = 0;
  while (const auto event = reader.next()) CHECK(same(*event, samples[n++]));
  CHECK(n == 50);
}
