// The writers of exports against readers written for the test from the formats' texts.
#include <zlib.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <map>

#include "core/grid/random.h"
#include "report/export/csv_text.h"
#include "report/export/mcap_writer.h"
#include "report/export/member_texts.h"
#include "report/export/run_log.h"
#include "report/export/run_tables.h"
#include "report/export/spool.h"
#include "report/export/zip_file.h"
#include "tests/support/temp_folder.h"

namespace firn::tables {
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

std::string inflated(std::string_view packed, std::size_t plain) {
  z_stream z{};
  REQUIRE(inflateInit2(&z, -MAX_WBITS) == Z_OK);
  std::string out(plain + 1, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  z.avail_in = uInt(packed.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = uInt(out.size());
  const int result = inflate(&z, Z_FINISH);
  inflateEnd(&z);
  REQUIRE(result == Z_STREAM_END);
  out.resize(z.total_out);
  return out;
}

/// Files of a ZIP64 archive, found from its end by the directory.
std::map<std::string, std::string> unzipped(std::string_view zip) {
  REQUIRE(zip.size() >= 98);
  const std::size_t locator = zip.size() - 22 - 20;
  REQUIRE(number(zip, locator, 4) == 0x07064b50);
  const std::size_t end = number(zip, locator + 8, 8);
  REQUIRE(number(zip, end, 4) == 0x06064b50);
  std::map<std::string, std::string> files;
  std::size_t at = number(zip, end + 48, 8);
  for (std::uint64_t left = number(zip, end + 32, 8); left > 0; --left) {
    REQUIRE(number(zip, at, 4) == 0x02014b50);
    const std::size_t name = number(zip, at + 28, 2), extra = at + 46 + name;
    REQUIRE(number(zip, extra, 2) == 1);
    const std::uint64_t plain = number(zip, extra + 4, 8), packed = number(zip, extra + 12, 8);
    const std::size_t local = number(zip, extra + 20, 8);
    REQUIRE(number(zip, local, 4) == 0x04034b50);
    CHECK(number(zip, local + 14, 4) == number(zip, at + 16, 4));  // the sum, in both places
    const std::size_t begin = local + 30 + number(zip, local + 26, 2) + number(zip, local + 28, 2);
    const std::string bytes = inflated(zip.substr(begin, packed), plain);
    CHECK(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), uInt(bytes.size())) ==
          number(zip, at + 16, 4));
    files[std::string(zip.substr(at + 46, name))] = bytes;
    at += 46 + name + number(zip, at + 30, 2);
  }
  CHECK(at == end);
  return files;
}

}  // namespace

TEST_CASE("an archive holds its files byte by byte, empty and large ones, and is the same every time") {
  RandomStream random(31, Purpose::kTest);
  const test::TempFolder folder;
  std::map<std::string, std::string> files{{"empty", ""}, {"größe.npy", content(random, 700'000)}};
  for (int n = 0; n < 12; ++n) files["a/" + std::to_string(n)] = content(random, random.below(30'000));
  for (const char* name : {"one.zip", "two.zip"}) {
    ZipWriter zip(folder.path() / name);
    for (const auto& [file, bytes] : files)
      zip.add(file, [&, all = &bytes](const ZipWriter::Put& put) {
        for (std::size_t at = 0; at < all->size(); at += 4099) put(std::string_view(*all).substr(at, 4099));
      });
    zip.close();
  }
  CHECK(unzipped(read(folder.path() / "one.zip")) == files);
  CHECK(read(folder.path() / "one.zip") == read(folder.path() / "two.zip"));
}

TEST_CASE("an archive in a folder that is not there is refused by its name") {
  const test::TempFolder folder;
  CHECK_THROWS_WITH(ZipWriter(folder.path() / "none" / "a.zip"),
                    Catch::Contains("none/a.zip: cannot be written"));
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
    const std::string cell = csv_text(text);
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
      Spool spool(folder.path() / "out.part");
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
    McapWriter mcap(file);
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
  for (const auto& [name, unit] : names) CHECK(unit_of(name) == unit);
}

TEST_CASE("members are explained by the .lcm files") {
  CHECK(!type_text("layer_plan_t").empty());
  CHECK(member_text("header_t", "incarnation").range == "[0, 1e6]");
  CHECK_THAT(member_text("header_t", "incarnation").text, Catch::Contains("start of a run"));
}

TEST_CASE("channels go to groups by what they tell") {
  CHECK(topic_of("HEIGHT_MAP") == "maps");
  CHECK(topic_of("FAULT_JET") == "events");
}

TEST_CASE("a folder that is no run is named before anything is written") {
  const test::TempFolder folder;
  CHECK_THROWS_WITH(read_texts(folder.path()), Catch::Contains(folder.path().string()));
}

}  // namespace firn::tables
