// Run folders of strangers: links, pipes, devices and bombs in each place, code, and single changed bytes.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cli/export_command.h"
#include "cli/log_command.h"
#include "cli/print_command.h"
#include "cli/replay_command.h"
#include "cli/report_command.h"
#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "files/record/file.h"
#include "files/record/packed.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "page/watched_run.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "runs/folder/list.h"
#include "runs/folder/notes.h"
#include "runs/folder/origin.h"
#include "runs/folder/pack.h"
#include "runs/folder/seal_check.h"
#include "runs/read/run_reader.h"
#include "tests/support/long_cases.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

fs::path printed(const fs::path& root, bool stopped) {
  const Experiment e = test::tiny_print("crafted");
  const runs::RunFolder run = runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  if (stopped) o.later = {{12.0, {new_order_id(), OperatorVerb::kStop, {}, {}}}};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == (stopped ? kSafetyStop : kOk));
  return run.path();
}

std::map<std::string, std::function<void(const fs::path&)>> commands() {
  return {{"replay",
           [](const fs::path& run) {
             ReplayCommandOptions o;
             o.run = run.string();
             replay_verdict(full_product(), o);
           }},
          {"audit", [](const fs::path& run) { replay::audit_run(run); }},
          {"report",
           [](const fs::path& run) {
             ReportOptions o;
             o.runs = {run.string()};
             o.output = (run / "report.html").string();
             o.no_replay = o.unsealed = true;
             write_report(full_product(), o);
           }},
          {"export",
           [](const fs::path& run) {
             ExportOptions o;
             o.runs = {run.string()};
             o.output = (run.parent_path() / "x.mcap").string();
             run_export(o);
           }},
          {"runs", [](const fs::path& run) { runs::list_runs(run.parent_path()); }},
          {"pack", [](const fs::path& run) { runs::pack_run(run); }},
          {"expand", [](const fs::path& run) { runs::expand_run(run); }},
          {"repair",
           [](const fs::path& run) {
             LogOptions o;
             o.action = LogAction::kRepair;
             o.file = (run / "log.lcm").string();
             run_log(o);
           }},
          {"note",
           [](const fs::path& run) {
             runs::add_notes(run, {{{}, "a note", {}, {}, {}}});
           }},
          {"page", [](const fs::path& run) { page::WatchedRun(full_product(), run, 0.0); }},
          {"resume", [](const fs::path& run) {
             PrintOptions o;
             o.resume = run.string();
             o.bus = "in-process";
             o.unsealed = true;
             run_print(full_product(), o);
           }}};
}

// Places of a run that a command opens, and some that it would write.
const char* const kPlaces[] = {"provenance.json",
                               "experiment.toml",
                               "result.json",
                               "notes.json",
                               "notes.jsonl",
                               "report.html",
                               "metrics.csv",
                               "log.lcm",
                               "log.lcm.idx",
                               "world.rec",
                               "seals/0.seal",
                               "seals/1.seal",
                               "seals/derived.seal",
                               "nodes/stage.wal",
                               "nodes/scheduler.wal",
                               "nodes/launcher.sent",
                               "world/state",
                               "nodes/stage.wal.part",
                               "result.json.part",
                               "seals/derived.seal.part",
                               "nodes",
                               "seals",
                               "world",
                               "inputs",
                               "lock"};

TEST_CASE("a link, a pipe or a device in any place of a run leads no command to a byte outside of it") {
  const test::TempFolder root;
  const fs::path original = printed(root.path() / "runs", true);
  const std::string secret = "what nobody may read or write";
  const auto all = commands();
  std::size_t n = 0;
  const auto chosen = test::long_cases(std::size(kPlaces) * 3 * all.size(), 150);
  std::size_t number = 0;
  for (const char* place : kPlaces)
    for (const char* kind : {"link", "pipe", "zero"})
      for (const auto& [name, act] : all) {
        const std::size_t mine = number++;
        if (n == chosen.size() || chosen[n] != mine) continue;
        ++n;
        const fs::path outside = root.path() / "outside", run = root.path() / "work" / "run";
        fs::remove_all(outside);
        fs::remove_all(run.parent_path());
        fs::create_directories(run.parent_path());
        fs::copy(original, run, fs::copy_options::recursive);
        const fs::path target = run / place;
        const bool folder = fs::is_directory(target);
        if (folder)
          fs::copy(target, outside, fs::copy_options::recursive);
        else
          write_file_atomically(outside, fs::exists(target) ? read_file(target) : secret);
        fs::remove_all(target);
        std::map<std::string, std::string> before;
        const auto contents = [&] {
          std::map<std::string, std::string> c;
          if (!folder)
            c[""] = read_file(outside);
          else
            for (const auto& entry : fs::recursive_directory_iterator(outside))
              c[entry.path().string()] = entry.is_regular_file() ? read_file(entry.path()) : "";
          return c;
        };
        before = contents();
        if (std::string(kind) == "link")
          folder ? fs::create_directory_symlink(outside, target) : fs::create_symlink(outside, target);
        else if (std::string(kind) == "pipe")
          REQUIRE(::mkfifo(target.c_str(), 0600) == 0);
        else
          fs::create_symlink("/dev/zero", target);
        INFO(place << " is a " << kind << ", " << name);
        try {
          act(run);
        } catch (const std::exception& e) {
          CHECK(std::string(e.what()).size() > 10);
        }
        CHECK(contents() == before);
      }
}

TEST_CASE("a linked note, report and result of a run are not read, and named as links") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), false), other = root.file("other", "{\"note\": \"secret\"}");
  fs::create_symlink(other, run / "notes.json");
  CHECK(runs::read_notes(run).entries.empty());
  fs::remove(run / "notes.json");
  fs::create_symlink(other, run / "notes.jsonl");
  CHECK(runs::read_notes(run).entries.empty());
  CHECK_THROWS_WITH(runs::add_notes(run, {{{}, "a note", {}, {}, {}}}),
                    Contains("notes.jsonl") && Contains("link"));
  fs::create_symlink(other, run / "report.html");
  CHECK_THROWS_WITH(read_file(run / "report.html"), Contains("report.html") && Contains("is a link"));
  ReportOptions o;
  o.runs = {run.string()};
  o.output = (run / "report.html").string();
  o.no_replay = true;
  CHECK_THROWS_WITH(write_report(full_product(), o), Contains("report.html") && Contains("link"));
  CHECK(read_file(other) == "{\"note\": \"secret\"}");
}

TEST_CASE("the run folder itself may be reached by a link") {
  const test::TempFolder root;
  const fs::path run = printed(root.path() / "runs", false), latest = root.path() / "latest";
  fs::create_directory_symlink(run, latest);
  CHECK(replay::audit_run(latest).clean());
  runs::add_notes(latest, {{{}, "b", {}, {}, {}}});
  CHECK(runs::read_notes(run).notes().front().text == "b");
}

TEST_CASE("a file without an end is not read into memory") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), false);
  std::ofstream(run / "notes.jsonl") << "{";
  fs::resize_file(run / "notes.jsonl", std::uintmax_t(1) << 40);  // a hole
  CHECK_THROWS_WITH(read_file(run / "notes.jsonl"), Contains("notes.jsonl") && Contains("has more than"));
  CHECK(runs::read_notes(run).entries.empty());
}

TEST_CASE("a packed file that declares more than it can hold is refused before it is unpacked") {
  const test::TempFolder root;
  const fs::path file = root.path() / "stage.wal";
  std::vector<std::byte> plain(std::size_t(100) << 20, std::byte{0});
  CHECK(record::pack(plain, {}, "").empty());  // Firn itself packs no such file
  plain.resize(std::size_t(60) << 20);
  std::vector<std::byte> bomb = record::pack(plain, {}, "");
  const std::uint64_t declared = std::uint64_t(6) << 30;
  std::memcpy(bomb.data() + 8, &declared, 8);
  std::memset(bomb.data() + 44, 0, 4);  // as of Firn 0.1, without a checksum
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bomb.data()), std::streamsize(bomb.size()));
  CHECK_THROWS_AS(record::MappedFile(file), record::PackedError);
  CHECK_THROWS_WITH(record::MappedFile(file), Contains(file.string()) && Contains("byte 8"));
}

TEST_CASE("one changed byte anywhere in the sealed files of a packed run is found") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), false);
  runs::pack_run(run);
  std::vector<std::pair<fs::path, std::size_t>> places;
  for (const runs::SealedFile& f : runs::check_seals(run).files)
    for (std::size_t at = 0; at < fs::file_size(run / f.path); ++at) places.emplace_back(run / f.path, at);
  for (const auto& entry : fs::directory_iterator(run / "seals"))
    for (std::size_t at = 0; at < entry.file_size(); ++at) places.emplace_back(entry.path(), at);
  for (const std::size_t n : test::long_cases(places.size(), 300)) {
    const fs::path& file = places[n].first;
    const std::size_t at = places[n].second;
    RandomStream random(n, Purpose::kTest);
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekg(std::streamoff(at));
    const char was = char(bytes.get());
    const auto put = [&](char c) {
      bytes.seekp(std::streamoff(at));
      bytes.put(c);
      bytes.flush();
    };
    put(char(was ^ (1 + int(random.below(255)))));
    INFO(file << ", byte " << at);
    bool found = false;
    try {
      found = !runs::check_seals(run).whole();
    } catch (const record::PackedError& e) {
      found = std::string(e.what()).find("packed file: ") != std::string::npos;
    }
    CHECK(found);
    put(was);
  }
  CHECK(runs::check_seals(run).whole());
}

TEST_CASE("damage of a packed file has one wording in audit, replay, report and resume, and exit code 2") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), true);
  runs::pack_run(run);
  const fs::path file = run / "nodes" / "scheduler.wal";
  REQUIRE(record::is_packed(file));
  std::string bytes = read_file(file);
  bytes[bytes.size() / 2] = char(bytes[bytes.size() / 2] ^ 0x10);
  write_file_atomically(file, bytes);
  for (const auto& [name, act] : commands()) {
    if (name != "replay" && name != "audit" && name != "report" && name != "resume") continue;
    INFO(name);
    CHECK_THROWS_AS(act(run), record::PackedError);
    CHECK_THROWS_WITH(act(run), Catch::Equals(file.string() + ": packed file: it is not as it was written"));
  }
}

TEST_CASE("a run is one's own by user, host, configuration, inputs and folder, and by nothing less") {
  const test::TempFolder root;
  const fs::path path = printed(root.path(), false);
  const runs::RunFolder run = runs::RunFolder::open(path);
  const auto own = [&](std::int64_t id, const std::string& config, const runs::InputDigests& inputs) {
    return runs::is_own_run(path, id, config, inputs);
  };
  const runs::InputDigests inputs = run.input_digests();
  CHECK(own(run.run_id(), run.experiment_toml(), inputs));
  CHECK_FALSE(own(run.run_id() + 1, run.experiment_toml(), inputs));
  CHECK_FALSE(own(run.run_id(), run.experiment_toml() + " ", inputs));
  runs::InputDigests more = inputs;
  more.emplace_back("python:controller:level.py", std::string(64, 'a'));
  CHECK_FALSE(own(run.run_id(), run.experiment_toml(), more));
  std::string provenance = read_file(path / "provenance.json");
  const std::size_t at = provenance.find("\"origin\": \"") + 11;
  provenance[at] = provenance[at] == '0' ? '1' : '0';
  write_file_atomically(path / "provenance.json", provenance);
  CHECK_FALSE(own(run.run_id(), run.experiment_toml(), inputs));
}

}  // namespace
}  // namespace firn
