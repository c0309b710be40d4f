// The index of runs agrees with the folders, also after changes, damage, and with two writers at once.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <span>
#include <thread>

#include "config/experiment.h"
#include "core/grid/random.h"
#include "files/digest.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/find/run_index.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_folder.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

struct Made {
  std::string name, scheme, ink, outcome;
  std::optional<double> rms_um;
  double alpha = 0.0;
  bool tagged = false;
};

fs::path make(const fs::path& place, const Made& m) {
  Experiment e = tiny_print(m.name, m.scheme);
  e.control.mpc.alpha = {{1, m.alpha}};
  Meta meta;
  if (!m.ink.empty()) meta.push_back({"ink", m.ink});
  const std::string target = "the target";
  const auto bytes = std::as_bytes(std::span(target));
  const Blobs inputs{{"target", sha256_hex(bytes), {bytes.begin(), bytes.end()}}};
  const runs::RunFolder run = runs::RunFolder::create(place, e, inputs, {"test"}, {}, meta);
  if (m.outcome != "interrupted") {
    runs::RunResult result{m.outcome, 0, 3, "of the test"};
    if (m.rms_um) result.error = runs::MapError{0.1, *m.rms_um, 0.5};
    run.write_result(result);
  }
  if (m.tagged) runs::add_notes(run.path(), {{runs::NoteEntry::Kind::kTag, "good", {}, {}, {}}});
  return run.path();
}

std::vector<std::string> names(const std::vector<runs::FoundRun>& found) {
  std::vector<std::string> all;
  for (const runs::FoundRun& r : found) all.push_back(nlohmann::json::parse(r.listing).at("name"));
  return all;
}

struct Indexed {
  explicit Indexed(const fs::path& file)
      : index(file, [this](const std::string& line) { said += line + "\n"; }) {}
  std::vector<std::string> find(const std::string& text, const std::vector<fs::path>& places,
                                const runs::FindOptions& o = {}) {
    index.refresh(places);
    return names(index.find(runs::parse_query(text), text, places, o));
  }
  std::string said;
  runs::RunIndex index;
};

TEST_CASE("random conditions find the runs that a reading of every run finds") {
  const TempFolder root;
  const fs::path place = root.path() / "runs";
  RandomStream random(58, Purpose::kTest);
  std::vector<Made> made;
  const std::vector<std::string> schemes{"mpc", "smf", "open_loop"}, inks{"", "TPGDA 7", "HDDA"},
      ends{"finished", "out of tolerance", "interrupted"};
  for (int n = 0; n < 24; ++n) {
    Made m{"r" + std::to_string(n),
           schemes[random.below(3)],
           inks[random.below(3)],
           ends[random.below(3)],
           std::nullopt,
           0.25 * double(1 + random.below(4)),
           random.below(2) == 1};
    if (m.outcome != "interrupted" && random.below(4) > 0) m.rms_um = 0.5 * double(1 + random.below(6));
    make(place, m);
    made.push_back(m);
  }
  struct Condition {
    std::string text;
    std::function<bool(const Made&)> holds;
  };
  const std::vector<Condition> simple{
      {"rms_um < 2", [](const Made& m) { return m.rms_um && *m.rms_um < 2; }},
      {"rms_um >= 1.5", [](const Made& m) { return m.rms_um && *m.rms_um >= 1.5; }},
      {"rms_um != 2", [](const Made& m) { return !(m.rms_um && *m.rms_um == 2); }},
      {"has rms_um", [](const Made& m) { return m.rms_um.has_value(); }},
      {"meta.ink ~ tpgda", [](const Made& m) { return m.ink == "TPGDA 7"; }},
      {"meta.ink !~ \"tp\"", [](const Made& m) { return m.ink != "TPGDA 7"; }},
      {"meta.ink = HDDA", [](const Made& m) { return m.ink == "HDDA"; }},
      {"has meta.ink", [](const Made& m) { return !m.ink.empty(); }},
      {"outcome = finished", [](const Made& m) { return m.outcome == "finished"; }},
      {"outcome = \"out of tolerance\"", [](const Made& m) { return m.outcome == "out of tolerance"; }},
      {"scheme = smf", [](const Made& m) { return m.scheme == "smf"; }},
      {"control.scheme != mpc", [](const Made& m) { return m.scheme != "mpc"; }},
      {"tag = good", [](const Made& m) { return m.tagged; }},
      {"started >= 2026", [](const Made&) { return true; }},
      {"name >= r2", [](const Made& m) { return m.name >= "r2"; }},
      {"tpGDA", [](const Made& m) { return m.ink == "TPGDA 7"; }},
      {"\"of the TEST\"", [](const Made& m) { return m.outcome != "interrupted"; }},
      {"layers = 3", [](const Made& m) { return m.outcome != "interrupted"; }},
  };
  Indexed index(root.path() / "cache" / "runs.sqlite");
  for (const Condition& c : simple) {
    std::vector<std::string> expected;
    for (const Made& m : made)
      if (c.holds(m)) expected.push_back(m.name);
    std::vector<std::string> found = index.find(c.text, {place});
    std::ranges::sort(found);
    std::ranges::sort(expected);
    INFO(c.text);
    CHECK(found == expected);
  }
  for (int trial = 0; trial < 200; ++trial) {
    std::function<Condition(int)> draw = [&](int depth) -> Condition {
      const std::uint32_t kind = depth == 0 ? 0 : random.below(4);
      if (kind == 0) return simple[random.below(std::uint32_t(simple.size()))];
      const Condition a = draw(depth - 1);
      if (kind == 1) return {"not (" + a.text + ")", [a](const Made& m) { return !a.holds(m); }};
      const Condition b = draw(depth - 1);
      if (kind == 2)
        return {"(" + a.text + ") and (" + b.text + ")",
                [a, b](const Made& m) { return a.holds(m) && b.holds(m); }};
      return {"(" + a.text + ") or (" + b.text + ")",
              [a, b](const Made& m) { return a.holds(m) || b.holds(m); }};
    };
    const Condition c = draw(3);
    std::vector<std::string> expected;
    for (const Made& m : made)
      if (c.holds(m)) expected.push_back(m.name);
    std::vector<std::string> found = names(index.index.find(runs::parse_query(c.text), c.text, {place}));
    std::ranges::sort(found);
    std::ranges::sort(expected);
    INFO(c.text);
    CHECK(found == expected);
  }
  CHECK(index.said.empty());
}

TEST_CASE("a setting is found at its default and at another value, and not in a lab without it") {
  const TempFolder root;
  const fs::path place = root.path() / "runs";
  const double usual = Experiment{}.control.mpc.alpha.front().alpha;
  make(place, {"usual", "mpc", "", "finished", 1.0, usual, false});
  make(place, {"other", "mpc", "", "finished", 1.0, 0.5 * usual, false});
  Indexed index(root.path() / "runs.sqlite");
  const auto at = [&](const std::string& condition) {
    return index.find("control.mpc.alpha " + condition, {place});
  };
  const std::string value = std::to_string(usual);
  CHECK(at("= " + value) == std::vector<std::string>{"usual"});
  CHECK(at("!= " + value) == std::vector<std::string>{"other"});
  CHECK(at("<= " + value).size() == 2);
  CHECK(at("< " + value) == std::vector<std::string>{"other"});
  CHECK(index.find("has ice.layer_height_mm", {place}).empty());
  CHECK(index.find("has grid.nx and grid.nx = 9", {place}).size() == 2);
}

TEST_CASE("the index follows its folders: results, notes, new runs, removed ones and moved ones") {
  const TempFolder root;
  const fs::path place = root.path() / "runs";
  const fs::path first = make(place, {"a", "mpc", "", "finished", 1.0, 0.5, false});
  make(place, {"b", "mpc", "", "finished", 3.0, 0.5, false});
  Indexed index(root.path() / "runs.sqlite");
  CHECK(index.find("rms_um < 2", {place}) == std::vector<std::string>{"a"});
  CHECK(index.index.refresh({place}).read == 0);
  runs::RunResult result{"out of tolerance", 4, 3, "again"};
  result.error = runs::MapError{0, 9.0, 1};
  runs::RunFolder::open(first).write_result(result);
  CHECK(index.find("rms_um < 2", {place}).empty());
  runs::add_notes(first, {{runs::NoteEntry::Kind::kNote, "rim falls", {}, {}, {}}});
  CHECK(index.find("note ~ RIM", {place}) == std::vector<std::string>{"a"});
  runs::add_notes(first, {{runs::NoteEntry::Kind::kNote, "rim rises", {}, {}, {}}});
  CHECK(index.find("note ~ rises", {place}) == std::vector<std::string>{"a"});
  fs::rename(first, place / "renamed");
  CHECK(index.find("folder = renamed", {place}) == std::vector<std::string>{"a"});
  CHECK(index.find("", {place}).size() == 2);
  fs::remove_all(place / "renamed");
  CHECK(index.find("", {place}) == std::vector<std::string>{"b"});
  make(place, {"c", "smf", "", "finished", 1.0, 0.5, false});
  CHECK(index.index.refresh({place}).read == 1);
}

TEST_CASE("several places, and one run alone, are asked as they were named") {
  const TempFolder root;
  const fs::path a = make(root.path() / "one", {"a", "mpc", "", "finished", 1.0, 0.5, false});
  make(root.path() / "one", {"b", "mpc", "", "finished", 1.0, 0.5, false});
  make(root.path() / "two", {"c", "mpc", "", "finished", 1.0, 0.5, false});
  fs::create_directory_symlink(root.path() / "two", root.path() / "linked");
  Indexed index(root.path() / "runs.sqlite");
  CHECK(index.find("", {root.path() / "one", root.path() / "two"}).size() == 3);
  CHECK(index.find("", {a}) == std::vector<std::string>{"a"});
  index.index.refresh({root.path() / "linked"});
  const auto found = index.index.find({}, "", {root.path() / "linked"});
  REQUIRE(found.size() == 1);
  CHECK(found.front().folder.parent_path() == root.path() / "linked");
  CHECK_THROWS_WITH(index.index.refresh({root.path() / "none"}), Contains("none: no such folder"));
}

TEST_CASE("runs come in the order that was asked for, those without the key last") {
  const TempFolder root;
  const fs::path place = root.path() / "runs";
  make(place, {"a", "mpc", "", "finished", 3.0, 0.5, false});
  make(place, {"b", "mpc", "", "interrupted", std::nullopt, 0.5, false});
  make(place, {"c", "mpc", "", "finished", 10.0, 0.5, false});
  make(place, {"d", "mpc", "", "finished", 1.0, 0.5, false});
  Indexed index(root.path() / "runs.sqlite");
  using Names = std::vector<std::string>;
  CHECK(index.find("", {place}, {"rms_um", false, 0}) == Names{"d", "a", "c", "b"});
  CHECK(index.find("", {place}, {"rms_um", true, 0}) == Names{"c", "a", "d", "b"});
  CHECK(index.find("", {place}, {"name", true, 2}) == Names{"d", "c"});
}

TEST_CASE(
    "an index that is damaged anywhere, or is none, is made anew with the same answers, and that is said") {
  const TempFolder root;
  const fs::path place = root.path() / "runs", file = root.path() / "runs.sqlite";
  for (int n = 0; n < 6; ++n)
    make(place, {"r" + std::to_string(n), n % 2 ? "mpc" : "smf", "", "finished", double(n), 0.5, n == 2});
  const std::string text = "rms_um >= 1 and (scheme = smf or tag = good)";
  const auto expected = Indexed(file).find(text, {place});
  REQUIRE(expected == std::vector<std::string>{"r2", "r4"});
  const std::string whole = read_file(file);
  RandomStream random(59, Purpose::kTest);
  int said = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::string damaged = whole;
    if (trial == 0) damaged = "this is no database, but a text of some length that is written here";
    if (trial == 1) damaged = whole.substr(0, whole.size() / 2);
    if (trial == 2) damaged.clear();
    for (int n = 0; trial > 2 && n < 400; ++n)
      damaged[random.below(std::uint32_t(damaged.size()))] = char(random.below(256));
    std::ofstream(file, std::ios::binary) << damaged;
    Indexed index(file);
    INFO(trial);
    CHECK(index.find(text, {place}) == expected);
    said += index.said.find("it is made anew") != std::string::npos;
  }
  CHECK(said >= 30);
}

TEST_CASE("where no index can be written, the runs are read this once") {
  const TempFolder root;
  const fs::path place = root.path() / "runs";
  make(place, {"a", "mpc", "", "finished", 1.0, 0.5, false});
  std::ofstream(root.path() / "file") << "x";
  Indexed index(root.path() / "file" / "runs.sqlite");
  CHECK(index.find("rms_um = 1", {place}) == std::vector<std::string>{"a"});
  CHECK_THAT(index.said, Contains("the runs are read this once"));
  Indexed memory{fs::path()};
  CHECK(memory.find("rms_um = 1", {place}) == std::vector<std::string>{"a"});
}

TEST_CASE("two commands that make the index at once both find every run") {
  const TempFolder root;
  const fs::path place = root.path() / "runs", file = root.path() / "runs.sqlite";
  for (int n = 0; n < 12; ++n)
    make(place, {"r" + std::to_string(n), "mpc", "", "finished", double(n), 0.5, false});
  for (int trial = 0; trial < 5; ++trial) {
    fs::remove(file);
    std::array<std::size_t, 2> found{};
    std::thread other([&] { found[0] = Indexed(file).find("", {place}).size(); });
    found[1] = Indexed(file).find("", {place}).size();
    other.join();
    CHECK(found[0] == 12);
    CHECK(found[1] == 12);
  }
}

}  // namespace
}  // namespace firn::test
