// The writers of exports against readers written for the test from the formats' texts.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <map>

#include "core/grid/random.h"
#include "report/export/csv_text.h"
#include "report/export/mcap_writer.h"
#include "report/export/member_texts.h"
#include "report/export/run_tables.h"
#include "report/export/spool.h"
#include "report/export/tables.h"
#include "runs/read/run_log.h"
#include "tests/support/temp_folder.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::uint64_t number(std::string_view bytes, std::size_t at, int n) {
  REQUIRE(at + std::size_t(n) <= bytes.size());
  std::uint64_t v = 0;
  for (int k = n - 1; k >= 0; --k) v = v << 8 | std::uint8_t(bytes[at + std::size_t(k)]);
  return v;
}

/// Content that deflates well in parts.
std::string content(RandomStream& random, std::size_t bytes) {
  std::string s(bytes, 'a');
  for (std::size_t n = 0; n < bytes; ++n)
    if (n / 1000 % 2) s[n] = char(random.below(256));
  return s;
}

}  // namespace

TEST_CASE("an .npz is the same every time, and in a folder that is not there it is refused by its name") {
  const test::TempFolder folder;
  report::Table table{"maps/A", "", {2, report::Column{}}, {}};
  table.columns[0].name = "a_mm";
  table.columns[0].kind = schema::Kind::kDouble;
  table.columns[1].name = "name";
  table.columns[1].kind = schema::Kind::kString;
  for (const char* name : {"one.npz", "two.npz"}) {
    const auto sink = report::npz_sink(folder.path() / name);
    REQUIRE(sink->open(table) == 0);
    for (int n = 0; n < 70'000; ++n) {  // more than a piece of the archive
      const double value = n * 0.1;
      sink->row(
          0, std::array{report::Cell{std::as_bytes(std::span(&value, 1)), {}}, report::Cell{{}, {"größe"}}});
    }
    sink->document("config/text", "", "grid.nx = 3");
    sink->finish();
  }
  CHECK(read(folder.path() / "one.npz") == read(folder.path() / "two.npz"));
  CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 2);
  CHECK_THROWS_WITH(report::npz_sink(folder.path() / "none" / "a.npz"), Catch::Contains("none/a.npz"));
}

namespace {

// Writes a table and a document in a process of its own, whose files may have so many bytes.
// @returns its status, 0: whole, 7: it said that it cannot write; negative: the signal that ended it
int write_within(std::size_t bytes, const fs::path& file) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit most{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &most);
    int status = 0;
    try {
      report::Table table{"maps/A", "", {2, report::Column{}}, {}};
      table.columns[0].name = "a_mm";
      table.columns[0].kind = schema::Kind::kDouble;
      table.columns[1].name = "name";
      table.columns[1].kind = schema::Kind::kString;
      const auto sink = file.extension() == ".h5" ? report::hdf5_sink(file) : report::npz_sink(file);
      sink->open(table);
      RandomStream random(bytes, Purpose::kTest);
      for (int n = 0; n < 60'000; ++n) {
        const double value = random.uniform();
        sink->row(0, std::array{report::Cell{std::as_bytes(std::span(&value, 1)), {}},
                                report::Cell{{}, {std::to_string(n)}}});
      }
      sink->document("config/text", "", "grid.nx = 3");
      sink->finish();
    } catch (const std::exception&) {
      status = 7;
    }
    std::exit(status);  // libraries may still write here
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace

TEST_CASE("a disk that is full at any byte of an export is told, and nothing of the file stays") {
  for (const char* name : {"a.h5", "a.npz"}) {
    std::size_t last = 1000;
    for (int status = 7; status != 0; last += last / 3) {
      const test::TempFolder folder;
      status = write_within(last, folder.path() / name);
      INFO(name << " within " << last << " bytes");
      CHECK((status == 7 || status == 0));
      CHECK(fs::is_empty(folder.path()) == (status != 0));
      REQUIRE(last < (std::size_t(100) << 20));
      if (status < 0) break;
    }
  }
}

TEST_CASE("texts of a CSV file read back by RFC 4180") {
  const auto unquoted = [](std::string_view cell) {
    if (cell.empty() || cell[0] != '"') return std::string(cell);
    std::string out;
    for (std::size_t n = 1; n + 1 < cell.size(); ++n) {
      if (cell[n] == '"') REQUIRE(cell[++n] == '"');
      out += cell[n];
    }
    return out;
  };
  RandomStream random(32, Purpose::kTest);
  for (int n = 0; n < 500; ++n) {
    std::string text(random.below(12), ' ');
    for (char& c : text) c = "a,\"\n\r; '"[random.below(8)];
    const std::string cell = report::csv_text(text);
    INFO(cell);
    CHECK(unquoted(cell) == text);
    if (text.find_first_of(",\"\r\n") != text.npos) CHECK(cell.front() == '"');
  }
}

TEST_CASE("a spool keeps the bytes of many growing files apart, and leaves nothing unless it is kept") {
  RandomStream random(33, Purpose::kTest);
  const test::TempFolder folder;
  std::vector<std::string> wanted(40);
  for (const bool keep : {false, true}) {
    for (std::string& w : wanted) w.clear();
    {
      report::Spool spool(folder.path() / "out.part");
      for (std::size_t n = 0; n < wanted.size(); ++n) spool.add("f" + std::to_string(n));
      for (int n = 0; n < 600; ++n) {
        const std::size_t file = random.below(40);
        const std::string bytes = content(random, random.below(20'000));
        spool.append(file, bytes);
        wanted[file] += bytes;
        REQUIRE(spool.size(file) == wanted[file].size());
      }
      if (keep) spool.keep_as(folder.path() / "out");
    }
    CHECK(!fs::exists(folder.path() / "out.part"));
    REQUIRE(fs::exists(folder.path() / "out") == keep);
  }
  for (std::size_t n = 0; n < wanted.size(); ++n)
    CHECK(read(folder.path() / "out" / ("f" + std::to_string(n))) == wanted[n]);
}

TEST_CASE("the records of an MCAP file fill it from magic to magic, and its statistics count the messages") {
  const test::TempFolder folder;
  const fs::path file = folder.path() / "a.mcap";
  constexpr int kMessages = 5000;
  {
    report::McapWriter mcap(file);
    const auto schema = mcap.add_schema("firn.metric", "jsonschema", "{\"type\":\"object\"}");
    const auto one = mcap.add_channel(schema, "/A", "json", {}),
               two = mcap.add_channel(schema, "/B", "json", {});
    const std::string text = "{\"rms_um\":1.5,\"text\":\"" + std::string(400, 'x') + "\"}";
    for (int n = 0; n < kMessages; ++n)
      mcap.message(n % 3 ? one : two, std::uint32_t(n), std::uint64_t(n) * 1000, text);
    mcap.attachment("experiment.toml", "application/toml", "a = 1\n");
    mcap.close();
  }
  const std::string bytes = read(file), magic("\x89MCAP0\r\n", 8);
  REQUIRE(bytes.starts_with(magic));
  REQUIRE(bytes.ends_with(magic));
  std::map<int, int> records;
  std::size_t at = 8, last = 0;
  for (const std::size_t end = bytes.size() - 8; at < end; at += 9 + number(bytes, at + 1, 8)) {
    last = std::uint8_t(bytes[at]);
    ++records[int(last)];
    if (last == 0x0b) CHECK(number(bytes, at + 9, 8) == kMessages);
  }
  CHECK(at == bytes.size() - 8);
  CHECK(last == 0x02);        // the footer
  CHECK(records[0x01] == 1);  // the header
  CHECK(records[0x06] > 1);   // chunks
  CHECK(records[0x06] == records[0x08]);
  CHECK(records[0x09] == 1);  // the attachment
  CHECK(records[0x0b] == 1);
}

TEST_CASE("names of members give their units, and names without one none") {
  const std::pair<const char*, const char*> names[] = {
      {"height_mm", "mm"}, {"rate_hz", "Hz"}, {"sample_utime_us", "us"}, {"layer", "1"}, {"rms_um", "um"}};
  for (const auto& [name, unit] : names) CHECK(report::unit_of(name) == unit);
}

TEST_CASE("members are explained by the .lcm files") {
  CHECK(!report::type_text("layer_plan_t").empty());
  CHECK(report::member_text("header_t", "incarnation").range == "[0, 1e6]");
  CHECK_THAT(std::string(report::member_text("header_t", "incarnation").text),
             Catch::Contains("start of a run"));
}

TEST_CASE("channels go to groups by what they tell") {
  CHECK(report::topic_of("HEIGHT_MAP") == "maps");
  CHECK(report::topic_of("FAULT_JET") == "events");
}

TEST_CASE("a folder that is no run is named before anything is written") {
  const test::TempFolder folder;
  CHECK_THROWS_WITH(runs::read_texts(folder.path()), Catch::Contains(folder.path().string()));
}

}  // namespace firn::report
