// HDF5 files of hand-made tables, as h5dump describes them: scales of every axis, default plots, texts.
#include <catch2/catch.hpp>
#include <sstream>

#include "files/command.h"
#include "report/export/tables.h"
#include "tests/support/temp_folder.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using schema::Kind;

/// @returns h5dump's words about an object; empty: there is none
std::string h5dump(const fs::path& file, const std::vector<std::string>& what) {
  std::vector<std::string> words{"h5dump"};
  words.insert(words.end(), what.begin(), what.end());
  words.push_back(file.string());
  const CommandEnd end = run_command(words);
  REQUIRE_FALSE(end.missing());
  return end.code == 0 ? end.output : "";
}

std::string attribute(const fs::path& file, const std::string& path) { return h5dump(file, {"-a", path}); }

std::vector<std::byte> big_endian(std::initializer_list<std::int64_t> values) {
  std::vector<std::byte> bytes;
  for (const std::int64_t v : values)
    for (int k = 7; k >= 0; --k) bytes.push_back(std::byte(v >> (8 * k) & 255));
  return bytes;
}

Table table_of_messages() {
  Table t;
  t.path = "maps/A";
  t.text = "Messages of A.";
  t.columns = {{"log_utime_us", Kind::kInt64, Shape::kOne, "us", "Time.", ""},
               {"layer", Kind::kInt64, Shape::kOne, "1", "Layer.", ""},
               {"height_mm", Kind::kInt64, Shape::kMap, "mm", "Height.", ""},
               {"names", Kind::kString, Shape::kList, "text", "Names.", ""}};
  t.grid = GridSpec{3, 2, 0.5, 0.25, 1.0, -1.0};
  t.plot = DefaultPlot{"height_mm", "layer", true};
  t.time_column = "log_utime_us";
  return t;
}

void write_row(TableSink& sink, std::size_t table, std::int64_t utime_us, std::int64_t layer) {
  const auto time = big_endian({utime_us}), number = big_endian({layer}),
             map = big_endian({layer, 2, 3, 4, 5, 6});
  sink.row(table, std::vector<Cell>{{time, {}}, {number, {}}, {map, {}}, {{}, {"a", "grö\xc3\x9f"}}});
}

struct Written {
  test::TempFolder folder;
  fs::path file = folder.path() / "a.h5";

  explicit Written(const std::string& started_utc, int rows = 2) {
    const auto sink = hdf5_sink(file);
    sink->begin_run({"", "my run", started_utc});
    const std::size_t table = sink->open(table_of_messages());
    const std::size_t plain = sink->open(
        {"provenance/meta", "Words.", {{"key", Kind::kString, Shape::kOne, "text", "Key.", ""}}, {}});
    for (int n = 0; n < rows; ++n) write_row(*sink, table, 1'500'000 * (n + 1), n + 1);
    sink->row(plain, std::vector<Cell>{{{}, {"operator"}}});
    sink->end_run(started_utc.empty() ? "" : "2026-12-01T10:00:03Z");
    sink->finish();
  }
};

}  // namespace

TEST_CASE("rows of messages have their time along them, which counts from the start of the run") {
  const Written w("2026-12-01T10:00:00Z");
  CHECK_THAT(attribute(w.file, "/maps/A/time/units"), Contains("microseconds since 2026-12-01T10:00:00Z"));
  CHECK_THAT(attribute(w.file, "/maps/A/time/CLASS"), Contains("DIMENSION_SCALE"));
  CHECK_THAT(h5dump(w.file, {"-d", "/maps/A/time"}), Contains("1500000, 3000000"));
  CHECK_THAT(attribute(w.file, "/maps/A/layer/DIMENSION_LIST"), Contains("DATASET"));
  CHECK_THAT(attribute(w.file, "/maps/A/log_utime_us/units"), Contains("\"us\""));
}

TEST_CASE("a run whose start nobody told has times without an epoch") {
  const Written w("");
  CHECK_THAT(attribute(w.file, "/maps/A/time/units"), Contains("\"us\""));
  CHECK(h5dump(w.file, {"-d", "/entry/start_time"}).empty());
  CHECK_THAT(h5dump(w.file, {"-d", "/entry/title"}), Contains("my run"));
}

TEST_CASE("a map has three axes: time, y and x, with the positions of its cells") {
  const Written w("2026-12-01T10:00:00Z");
  CHECK_THAT(h5dump(w.file, {"-d", "/maps/A/grid_x_mm"}), Contains("1, 1.5, 2"));
  CHECK_THAT(h5dump(w.file, {"-d", "/maps/A/grid_y_mm"}), Contains("-1, -0.75"));
  const std::string axes = attribute(w.file, "/maps/A/height_mm/DIMENSION_LIST");
  CHECK_THAT(axes, Contains("time") || Contains("( 3 )"));
  for (const char* scale : {"/maps/A/grid_x_mm", "/maps/A/grid_y_mm"})
    CHECK_THAT(attribute(w.file, std::string(scale) + "/REFERENCE_LIST"), Contains("dimension"));
  CHECK_THAT(attribute(w.file, "/maps/A/height_mm/coordinates"), Contains("\"layer\""));
}

TEST_CASE("a list has a dimension of its own without coordinates, which its count names") {
  const Written w("2026-12-01T10:00:00Z");
  CHECK_THAT(attribute(w.file, "/maps/A/names_count/sample_dimension"), Contains("\"names_value\""));
  CHECK_THAT(attribute(w.file, "/maps/A/names_value/NAME"),
             Contains("This is a netCDF dimension but not a netCDF variable.         4"));
  CHECK_THAT(h5dump(w.file, {"-H", "-d", "/maps/A/names_value"}), Contains("( 4 ) / ( 4 )"));
  CHECK_THAT(h5dump(w.file, {"-d", "/maps/A/names_first"}), Contains("0, 2"));
}

TEST_CASE("a table without times is numbered along its rows") {
  const Written w("2026-12-01T10:00:00Z");
  CHECK_THAT(h5dump(w.file, {"-d", "/provenance/meta/row"}), Contains("(0): 0"));
  CHECK_THAT(attribute(w.file, "/provenance/meta/row/CLASS"), Contains("DIMENSION_SCALE"));
  CHECK(h5dump(w.file, {"-d", "/provenance/meta/time"}).empty());
}

TEST_CASE("the default plot of a file leads from the root to the signal and its axes") {
  const Written w("2026-12-01T10:00:00Z");
  CHECK_THAT(attribute(w.file, "/default"), Contains("\"entry\""));
  CHECK_THAT(attribute(w.file, "/creator"), Contains("\"firn\""));
  CHECK_THAT(attribute(w.file, "/entry/default"), Contains("\"plot\""));
  CHECK_THAT(attribute(w.file, "/entry/plot/signal"), Contains("\"height_mm\""));
  CHECK_THAT(attribute(w.file, "/entry/plot/axes"), Contains(R"("layer", "grid_y_mm", "grid_x_mm")"));
  CHECK_THAT(h5dump(w.file, {"-d", "/entry/end_time"}), Contains("2026-12-01T10:00:03Z"));
}

TEST_CASE("attributes and values are texts of variable length in UTF-8") {
  const Written w("2026-12-01T10:00:00Z");
  for (const std::string& said :
       {attribute(w.file, "/maps/A/description"), h5dump(w.file, {"-H", "-d", "/maps/A/names"})}) {
    CHECK_THAT(said, Contains("STRSIZE H5T_VARIABLE"));
    CHECK_THAT(said, Contains("CSET H5T_CSET_UTF8"));
  }
}

TEST_CASE("a table without a row is whole, too") {
  const Written w("2026-12-01T10:00:00Z", 0);
  CHECK_THAT(h5dump(w.file, {"-H", "-d", "/maps/A/height_mm"}), Contains("( 0, 2, 3 )"));
  CHECK_THAT(attribute(w.file, "/maps/A/time/CLASS"), Contains("DIMENSION_SCALE"));
  CHECK_THAT(h5dump(w.file, {"-H", "-d", "/maps/A/names_value"}), Contains("( 0 ) / ( 0 )"));
}

TEST_CASE("of several runs each group is an entry, and the first is shown") {
  const test::TempFolder folder;
  const fs::path file = folder.path() / "b.h5";
  {
    const auto sink = hdf5_sink(file);
    for (const char* run : {"one", "two"}) {
      const std::string prefix = std::string(run) + "/";
      sink->begin_run({prefix, run, "2026-12-01T10:00:00Z"});
      Table table = table_of_messages();
      table.path = prefix + table.path;
      write_row(*sink, sink->open(table), 5, 1);
      sink->end_run("2026-12-01T10:00:05Z");
    }
    sink->finish();
  }
  CHECK_THAT(attribute(file, "/default"), Contains("\"one\""));
  for (const char* run : {"/one", "/two"}) {
    CHECK_THAT(attribute(file, std::string(run) + "/NX_class"), Contains("\"NXentry\""));
    CHECK_THAT(attribute(file, std::string(run) + "/plot/signal"), Contains("\"height_mm\""));
  }
}

}  // namespace firn::report
