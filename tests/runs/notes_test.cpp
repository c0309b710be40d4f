// Notes and tags of a run: added to alone, with author and time, covered by seals.
#include <catch2/catch.hpp>

#include <fstream>
#include <thread>

#include "core/grid/random.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_meta.h"
#include "runs/folder/seal_check.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using runs::NoteEntry;
using Kind = NoteEntry::Kind;

fs::path bare_run(const TempFolder& root) {
  return runs::RunFolder::create(root.path(), tiny_print("notes"), {}, {"test"}).path();
}

fs::path printed_run(const TempFolder& root) {
  Experiment e = tiny_print("notes", "smf");
  e.part.shape.height_mm = 0.015;
  const runs::RunFolder run =
      runs::RunFolder::create(root.path(), e, make_inputs(full_product(), e, ""), {"test"});
  REQUIRE(run_in_lab(full_product(), run, {}).result.status == 0);
  return run.path();
}

void note(const fs::path& run, const std::string& text) {
  runs::add_notes(run, {{Kind::kNote, text, "Ada", {}, {}}});
}

TEST_CASE("an alarm is acknowledged once, by the first, and is no note and no tag") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  const std::string alarm = "12.345 s, jet: no droplets";
  runs::add_notes(run, {{Kind::kAck, alarm, "Ada", {}, {}}, {Kind::kTag, "good", "Ada", {}, {}}});
  runs::add_notes(run, {{Kind::kAck, alarm, "Lee", {}, {}}, {Kind::kAck, "13 s, lamp: gone", "Lee", {}, {}}});
  const runs::RunNotes notes = runs::read_notes(run);
  const auto seen = notes.acknowledged();
  REQUIRE(seen.size() == 2);
  CHECK(seen[0].text == alarm);
  CHECK(seen[0].author == "Ada");
  CHECK(seen[0].time_utc.size() == 20);
  CHECK(seen[1].author == "Lee");
  CHECK(notes.entries.size() == 3);
  CHECK(notes.notes().empty());
  CHECK(notes.tags() == std::vector<std::string>{"good"});
  CHECK_THROWS_WITH(runs::add_notes(run, {{Kind::kAck, "", "Ada", {}, {}}}),
                    Contains("an alarm must not be empty"));
}

TEST_CASE("notes and tags come back in their order, with author, time and host") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  CHECK(runs::read_notes(run).entries.empty());
  runs::add_notes(run, {{Kind::kTag, "good", "Ada", {}, {}},
                        {Kind::kNote, " line one\nline \"two\" \xc3\xb6 ", {}, {}, {}}});
  runs::add_notes(run, {{Kind::kTag, "dry", {}, {}, {}}, {Kind::kUntag, "good", {}, {}, {}}});
  const runs::RunNotes notes = runs::read_notes(run);
  CHECK(notes.tags() == std::vector<std::string>{"dry"});
  REQUIRE(notes.notes().size() == 1);
  CHECK(notes.notes().front().text == "line one\nline \"two\" \xc3\xb6");
  CHECK(notes.notes().front().author == runs::user_name());
  CHECK(notes.entries.front().author == "Ada");
  for (const NoteEntry& e : notes.entries) {
    CHECK(e.time_utc.size() == 20);
    CHECK(!e.host.empty());
  }
}

TEST_CASE("a tag that is set already, or is not there to take away, adds no line") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  runs::add_notes(
      run, {{Kind::kTag, "a", {}, {}, {}}, {Kind::kTag, "a", {}, {}, {}}, {Kind::kUntag, "b", {}, {}, {}}});
  CHECK(runs::read_notes(run).entries.size() == 1);
}

TEST_CASE("a note beyond its limits is refused, and nothing of the request is written") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  const auto refused = [&](const NoteEntry& bad, const std::string& why) {
    CHECK_THROWS_WITH(runs::add_notes(run, {{Kind::kNote, "fine", {}, {}, {}}, bad}), Contains(why));
    CHECK(!fs::exists(run / "notes.jsonl"));
  };
  refused({Kind::kNote, "  ", {}, {}, {}}, "a note must not be empty");
  refused({Kind::kNote, std::string(runs::kMaxNoteBytes + 1, 'x'), {}, {}, {}}, "at most 16384");
  refused({Kind::kTag, std::string(65, 'x'), {}, {}, {}}, "a tag has 65 bytes; at most 64");
  refused({Kind::kTag, "a\nb", {}, {}, {}}, "a tag must not have control characters");
  refused({Kind::kNote, "x", std::string(101, 'x'), {}, {}}, "the author of a note has 101 bytes");
  refused({Kind::kNote, "\xff\xfe", {}, {}, {}}, "no UTF-8");
  std::vector<NoteEntry> many;
  for (int n = 0; n < 33; ++n) many.push_back({Kind::kTag, "t" + std::to_string(n), {}, {}, {}});
  CHECK_THROWS_WITH(runs::add_notes(run, many), Contains("at most 32 tags"));
}

TEST_CASE("a line that a kill tore costs that line alone") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  note(run, "first");
  const std::string whole = read_file(run / "notes.jsonl");
  RandomStream random(5, Purpose::kTest);
  for (int trial = 0; trial < 50; ++trial) {
    std::ofstream(run / "notes.jsonl")
        << whole << whole.substr(0, 1 + random.below(std::uint32_t(whole.size() - 1)));
    note(run, "after");
    const runs::RunNotes notes = runs::read_notes(run);
    REQUIRE(notes.notes().size() >= 2);  // a line without its end alone is whole
    CHECK(notes.notes().front().text == "first");
    CHECK(notes.notes().back().text == "after");
    CHECK(notes.notes().size() + std::size_t(notes.unreadable) == 3);
  }
}

TEST_CASE("two writers at once lose no note") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  const auto write = [&](const std::string& who) {
    for (int n = 0; n < 20; ++n) note(run, who + std::to_string(n));
  };
  std::thread other(write, "a");
  write("b");
  other.join();
  CHECK(runs::read_notes(run).notes().size() == 40);
  CHECK(runs::read_notes(run).unreadable == 0);
}

TEST_CASE("notes of Firn 0.1 are read, without author and time") {
  const TempFolder root;
  const fs::path run = bare_run(root);
  std::ofstream(run / "notes.json") << R"({"tags": ["old"], "note": "from the page"})";
  note(run, "new");
  const runs::RunNotes notes = runs::read_notes(run);
  CHECK(notes.tags() == std::vector<std::string>{"old"});
  REQUIRE(notes.notes().size() == 2);
  CHECK(notes.notes()[0].text == "from the page");
  CHECK(notes.notes()[0].author.empty());
}

TEST_CASE(
    "a note after the end breaks no seal, and the next seal covers it: then no byte of it changes unseen") {
  const TempFolder root;
  const fs::path run = printed_run(root);
  CHECK_FALSE(runs::seal_notes(run));
  note(run, "the rim falls");
  const runs::SealCheck open = runs::check_seals(run);
  CHECK(open.whole());
  REQUIRE(open.notes.size() == 1);
  CHECK_THAT(open.notes.front(), Contains("notes were added after seal 1"));
  CHECK(runs::seal_notes(run));
  CHECK_FALSE(runs::seal_notes(run));
  CHECK(runs::check_seals(run).notes.empty());
  note(run, "and again");
  CHECK(runs::check_seals(run).whole());
  std::string text = read_file(run / "notes.jsonl");
  text[text.find("falls")] = 'b';
  std::ofstream(run / "notes.jsonl") << text;
  REQUIRE(runs::check_seals(run).differs.size() == 1);
  CHECK(runs::check_seals(run).differs.front().file == "notes.jsonl");
  CHECK_THROWS_WITH(runs::seal_notes(run), Contains("is not as it was sealed: notes.jsonl"));
  fs::remove(run / "notes.jsonl");
  REQUIRE(runs::check_seals(run).differs.size() == 1);
  CHECK_THAT(runs::check_seals(run).differs.front().what, Contains("is missing"));
}

TEST_CASE(
    "provenance.json keeps [meta] with its types and the computer's name, and what is no value is refused by "
    "key") {
  const TempFolder root;
  const Meta meta{{"dry", true},
                  {"humidity_percent", 41.0},
                  {"pass", std::int64_t{3}},
                  {"sample", std::string("PCB \"7\"")}};
  const runs::RunFolder run =
      runs::RunFolder::create(root.path(), tiny_print("meta"), {}, {"test"}, {}, meta);
  const runs::RunMeta read = runs::run_meta(run.provenance());
  CHECK(read.values == meta);
  CHECK(!read.host.empty());
  CHECK(runs::meta_words(read.values) == "dry true, humidity_percent 41, pass 3, sample PCB \"7\"");
  const auto of = [](const std::string& text) {
    return runs::run_meta(runs::parse_provenance(text, "provenance.json"));
  };
  CHECK(of("{}").values.empty());
  CHECK_THROWS_WITH(of(R"({"meta": 3})"), Contains("meta: must be an object"));
  CHECK_THROWS_WITH(of(R"({"meta": {"a": null}})"),
                    Contains("meta.a: must be a text, a number, true or false"));
  CHECK_THROWS_WITH(of(R"({"meta": {"../a": 1}})"), Contains("'../a' is no key"));
}

}  // namespace
}  // namespace firn::test
