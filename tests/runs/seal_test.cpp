// A run folder is sealed: each change of a file, however small, is found and named.
#include <catch2/catch.hpp>

#include <fstream>
#include <set>

#include "cli/print_command.h"
#include "cli/replay_command.h"
#include "cli/report_command.h"
#include "core/grid/random.h"
#include "files/record/event_log.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/channels.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/truth_check.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

Experiment tiny_sealed() {
  Experiment e = tiny_print("seal", "smf");
  e.part.shape.height_mm = 0.015;
  return e;
}

runs::RunFolder new_run(const TempFolder& root) {
  const Experiment e = tiny_sealed();
  return runs::RunFolder::create(root.path(), e, make_inputs(full_product(), e, ""), {"test"});
}

fs::path sealed_print(const TempFolder& root) {
  const runs::RunFolder run = new_run(root);
  REQUIRE(run_in_lab(full_product(), run, {}).result.status == 0);
  return run.path();
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void write_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

bool names(const runs::SealCheck& check, const std::string& file) {
  return std::ranges::any_of(check.differs, [&](const runs::SealDifference& d) { return d.file == file; });
}

TEST_CASE("A print that ended is sealed whole, and audit and replay say nothing but that") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  const runs::SealCheck c = runs::check_seals(run);
  INFO((c.lines().empty() ? "" : c.lines().front()));
  CHECK(c.whole());
  CHECK(c.notes.empty());
  CHECK(c.seals.size() == 2);
  const replay::AuditVerdict audit = replay::audit_run(run);
  CHECK(audit.clean());
  CHECK_THAT(audit.seal, Contains("sealed: 2 seals, ") && Contains(c.seals.back().digest));
  CHECK(audit.notes.empty());
  ReplayCommandOptions r;
  r.run = run.string();
  CHECK(replay_verdict(full_product(), r).identical());
}

TEST_CASE("Each of 1,000 single bytes changed anywhere in a run folder is reported with its file") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  const std::vector<fs::path> files = files_in(run);
  std::vector<std::uint64_t> ends;  // of each file in the folder's bytes
  for (const fs::path& f : files) ends.push_back(fs::file_size(f) + (ends.empty() ? 0 : ends.back()));
  RandomStream random(20, Purpose::kTest);
  int reported = 0;
  for (int n = 0; n < 1000; ++n) {
    // Half of the places are anywhere in the bytes, half in any file, so that small files take their part.
    std::size_t file = random.below(std::uint32_t(files.size()));
    if (n % 2 == 0)
      file = std::size_t(std::ranges::upper_bound(ends, random.below(std::uint32_t(ends.back()))) -
                         ends.begin());
    const std::uint64_t size = fs::file_size(files[file]);
    if (size == 0) {
      ++reported;  // has no byte to change
      continue;
    }
    std::fstream stream(files[file], std::ios::binary | std::ios::in | std::ios::out);
    const auto at = std::streamoff(random.below(std::uint32_t(size)));
    const char old = char(stream.seekg(at).get());
    stream.seekp(at).put(char(old ^ char(1 + random.below(255)))).flush();
    const std::string name = files[file].lexically_relative(run).generic_string();
    const runs::SealCheck c = runs::check_seals(run);
    CAPTURE(name, at);
    REQUIRE_FALSE(c.whole());
    CHECK(names(c, name));
    reported += names(c, name);
    stream.seekp(at).put(old).flush();
  }
  CHECK(reported == 1000);
  CHECK(runs::check_seals(run).whole());
}

TEST_CASE("The audit of a run with one changed byte in any of its files is not clean and names the file") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  for (const fs::path& file : files_in(run)) {
    const std::string whole = read_file(file);
    if (whole.empty()) continue;
    std::string bytes = whole;
    bytes[bytes.size() / 2] = char(bytes[bytes.size() / 2] ^ 4);
    write_bytes(file, bytes);
    const replay::AuditVerdict v = replay::audit_run(run);
    const std::string name = file.lexically_relative(run).generic_string();
    CAPTURE(name, to_text(v));
    CHECK(std::ranges::any_of(v.violations, [&](const replay::Violation& x) {
      return x.kind == replay::ViolationKind::kAltered && x.what.find(name) != std::string::npos;
    }));
    write_bytes(file, whole);
  }
}

TEST_CASE("A file that is cut, continued, added, removed or replaced by a link is named") {
  const TempFolder root;
  const fs::path run = sealed_print(root), log = run / "log.lcm", index = run / "log.lcm.idx";
  const std::string whole = read_file(log);
  const auto only = [&](const std::string& file) {
    const runs::SealCheck c = runs::check_seals(run);
    REQUIRE(c.differs.size() == 1);
    CHECK(c.differs[0].file == file);
    return c.differs[0];
  };
  write_bytes(log, whole.substr(0, whole.size() - 3));
  CHECK(only("log.lcm").from == whole.size() - 3);
  write_bytes(log, whole + "more");
  CHECK(only("log.lcm").from == whole.size());
  CHECK(only("log.lcm").to == whole.size() + 4);
  write_bytes(log, whole);
  write_bytes(run / "nodes" / "other.wal", "");
  CHECK_THAT(only("nodes/other.wal").what, Contains("added"));
  fs::remove(run / "nodes" / "other.wal");
  const std::string entries = read_file(index);
  fs::remove(index);
  CHECK_THAT(only("log.lcm.idx").what, Contains("missing"));
  write_bytes(root.path() / "elsewhere", entries);
  fs::create_symlink(root.path() / "elsewhere", index);
  CHECK_THAT(only("log.lcm.idx").what, Contains("no regular file"));
  fs::remove(index);
  write_bytes(index, entries);
  CHECK(runs::check_seals(run).whole());
}

TEST_CASE("A page of the user's own in the run folder is no difference") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  write_bytes(run / "notes.txt", "a good print");
  CHECK(runs::check_seals(run).whole());
}

TEST_CASE("A changed byte of a page or table that firn report made in the run folder is named by the audit") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  ReportOptions page;
  page.runs = {run.string()};
  page.output = (run / "report.html").string();
  page.verdicts = {"identical"};
  write_report(full_product(), page);
  CHECK(replay::audit_run(run).clean());
  for (const char* name : {"metrics.csv", "report.html", "seals/derived.seal"}) {
    const std::string whole = read_file(run / name);
    std::string bytes = whole;
    bytes[bytes.size() / 3] = char(bytes[bytes.size() / 3] ^ 2);
    write_bytes(run / name, bytes);
    const replay::AuditVerdict v = replay::audit_run(run);
    CAPTURE(name);
    REQUIRE(v.violations.size() == 1);
    CHECK_THAT(v.violations[0].what, Contains(name));
    write_bytes(run / name, whole);
  }
  write_report(full_product(), page);  // made again
  CHECK(replay::audit_run(run).clean());
}

TEST_CASE("The end of a run that was killed before its last seal is sealed by a resume, as found") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  fs::remove(run / "seals" / "1.seal");
  CHECK_FALSE(replay::audit_run(run).clean());
  PrintOptions o;
  o.resume = run.string();
  CHECK(run_print(full_product(), o) == 0);
  const replay::AuditVerdict v = replay::audit_run(run);
  INFO(to_text(v));
  CHECK(v.clean());
  REQUIRE(v.notes.size() == 1);
  CHECK(v.notes[0] == "the end of incarnation 0 was sealed later, as found");
  CHECK_THROWS_WITH(run_print(full_product(), o), Contains("has finished"));
}

TEST_CASE("Seals that were all made anew do not have the digest that the user kept") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  const std::string kept = runs::check_seals(run).seals.back().digest;
  CHECK(replay::audit_run(run, kept).clean());
  const std::string text = read_file(run / "result.json");
  write_bytes(run / "result.json", text + "\n");
  for (const char* n : {"0", "1"}) {
    const fs::path file = run / "seals" / (std::string(n) + ".seal");
    runs::Seal s = runs::decode_seal(read_file(file));
    for (runs::SealedFile& f : s.files)
      if (f.path == "result.json")
        f = {f.path, text.size() + 1, runs::digest_file(run / f.path, {}).sha256, true};
    write_bytes(file, runs::encode_seal(s));
  }
  CHECK(replay::audit_run(run).clean());
  CHECK_FALSE(replay::audit_run(run, kept).clean());
}

TEST_CASE("Seals that are missing, exchanged or made of other seals are named") {
  const TempFolder root;
  const fs::path run = sealed_print(root), first = run / "seals" / "0.seal", last = run / "seals" / "1.seal";
  const std::string begun = read_file(first), ended = read_file(last);
  fs::remove(first);
  CHECK(names(runs::check_seals(run), "seals/0.seal"));
  write_bytes(first, begun);
  fs::remove(last);
  CHECK(names(runs::check_seals(run), "result.json"));  // of a run that ended
  write_bytes(last, begun);
  CHECK(names(runs::check_seals(run), "seals/1.seal"));
  runs::Seal other = runs::decode_seal(ended);
  other.before = std::string(64, '0');
  write_bytes(last, runs::encode_seal(other));
  CHECK(names(runs::check_seals(run), "seals/1.seal"));
  fs::remove_all(run / "seals");
  CHECK(names(runs::check_seals(run), "seals"));
}

TEST_CASE(
    "A run whose last incarnation was killed is not sealed since then, and its earlier bytes still are") {
  const TempFolder root;
  const runs::RunFolder run = new_run(root);
  LabRunOptions o;
  o.crash_after_steps = 1500;
  REQUIRE(run_in_lab(full_product(), run, o).crashed);
  runs::SealCheck c = runs::check_seals(run.path());
  CHECK(c.whole());
  REQUIRE(c.notes.size() == 1);
  CHECK(c.notes[0] == "not sealed since incarnation 0 began");

  o.resume = true;
  o.crash_after_steps = 300;
  REQUIRE(run_in_lab(full_product(), run, o).crashed);
  c = runs::check_seals(run.path());
  CHECK(c.whole());
  REQUIRE(c.notes.size() == 2);
  CHECK_THAT(c.notes[0], Contains("incarnation 0 was not sealed at its end, but as found"));
  CHECK(c.notes[1] == "not sealed since incarnation 1 began");

  const fs::path wal = run.wal_path("scheduler");
  const std::string whole = read_file(wal);
  std::string bytes = whole;
  bytes[100] = char(bytes[100] ^ 1);
  write_bytes(wal, bytes);
  CHECK(names(runs::check_seals(run.path()), "nodes/scheduler.wal"));
  write_bytes(wal, whole);

  o.crash_after_steps = 0;
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  c = runs::check_seals(run.path());
  INFO((c.lines().empty() ? "" : c.lines().front()));
  CHECK(c.whole());
  CHECK(c.seals.size() == 4);
  CHECK(c.notes.size() == 2);
  CHECK(replay::audit_run(run.path()).clean());
}

TEST_CASE("A torn write that a resume moves away leaves the seal verifiable") {
  const TempFolder root;
  const runs::RunFolder run = new_run(root);
  LabRunOptions o;
  o.crash_after_steps = 1500;
  REQUIRE(run_in_lab(full_product(), run, o).crashed);
  const std::string torn = read_file(run.wal_path("jet")).substr(16, 30);
  for (const char* node : {"jet", "scheduler"})
    std::ofstream(run.wal_path(node), std::ios::binary | std::ios::app) << torn;
  o.resume = true;
  o.crash_after_steps = 1;
  REQUIRE(run_in_lab(full_product(), run, o).crashed);
  CHECK(fs::exists(run.wal_path("jet").string() + ".torn-1"));
  CHECK(runs::check_seals(run.path()).whole());
  o.crash_after_steps = 0;
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  const runs::SealCheck c = runs::check_seals(run.path());
  INFO((c.lines().empty() ? "" : c.lines().front()));
  CHECK(c.whole());
}

TEST_CASE("A print whose last seal cannot be written is stopped by name and goes on with a resume") {
  const TempFolder root;
  const runs::RunFolder run = new_run(root);
  fs::create_directories(run.path() / "seals" / "1.seal.part");
  const runs::RunResult stopped = run_in_lab(full_product(), run, {}).result;
  CHECK(stopped.status == 3);
  CHECK(runs::can_go_on(stopped));
  CHECK_THAT(stopped.reason, Contains("could not be sealed") && Contains("1.seal"));
  fs::remove(run.path() / "seals" / "1.seal.part");
  PrintOptions o;
  o.resume = run.path().string();
  CHECK(run_print(full_product(), o) == 0);
  CHECK(runs::check_seals(run.path()).whole());
  CHECK(replay::audit_run(run.path()).clean());
}

TEST_CASE("Two processes do not print one run at a time") {
  const TempFolder root;
  const runs::RunFolder run = new_run(root);
  const runs::RunLock first(run.path(), runs::RunUse::kPrint);
  CHECK_THROWS_WITH(run_in_lab(full_product(), run, {}), Contains("is running (pid"));
}

TEST_CASE("Replay marks a changed experiment.toml, and a changed setting in it as one made on purpose") {
  const TempFolder root;
  const fs::path run = sealed_print(root);
  const std::string whole = read_file(run / "experiment.toml");
  ReplayCommandOptions r;
  r.run = run.string();
  write_bytes(run / "experiment.toml", whole + "# a remark\n");
  CHECK_FALSE(replay_verdict(full_product(), r).identical());
  const std::size_t at = whole.find("name = \"seal\"");
  REQUIRE(at != std::string::npos);
  write_bytes(run / "experiment.toml", std::string(whole).replace(at, 13, "name = \"deal\""));
  const replay::RunVerdict v = replay_verdict(full_product(), r);
  CHECK(v.changed_settings.size() == 1);
  REQUIRE(v.notes.size() == 2);
  CHECK_THAT(v.notes[0], Contains("experiment.toml"));
  CHECK_THAT(v.notes[1], Contains("each decision is the one on the recorded surface"));
  CHECK(v.altered.empty());
}

TEST_CASE("Resume refuses a run that was altered, and what was forced is marked for ever") {
  const TempFolder root;
  const runs::RunFolder run = new_run(root);
  LabRunOptions o;
  o.crash_after_steps = 1500;
  REQUIRE(run_in_lab(full_product(), run, o).crashed);
  std::ofstream(run.path() / "experiment.toml", std::ios::app) << "# one line more\n";
  o.resume = true;
  o.crash_after_steps = 0;
  CHECK_THROWS_AS(run_in_lab(full_product(), run, o), UsageError);
  CHECK_THROWS_WITH(run_in_lab(full_product(), run, o),
                    Contains("experiment.toml: bytes") && Contains("--unsealed"));
  o.unsealed = true;
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  const runs::SealCheck c = runs::check_seals(run.path());
  CHECK(c.differs.empty());
  REQUIRE(c.past_differs.size() == 1);
  CHECK_THAT(c.past_differs[0], Contains("experiment.toml") && Contains("when incarnation 1 began"));
  CHECK_FALSE(replay::audit_run(run.path()).clean());
}

// Writes every SIM_TRUTH of the log as a perfect surface.
void rewrite_truth(const fs::path& run) {
  const fs::path log = run / "log.lcm", other = run / "log.lcm.new";
  {
    const record::EventLogFile file(log);
    record::EventLogReader reader = file.reader();
    record::EventLogWriter::Options options;
    options.mode = record::File::Mode::kCreate;
    record::EventLogWriter writer(other, options);
    while (const auto e = reader.next()) {
      std::vector<std::byte> bytes(e->data.begin(), e->data.end());
      sim_truth_t m{};
      if (e->channel == channels::kSimTruth.name && m.decode(bytes.data(), 0, int(bytes.size())) > 0) {
        m.height_mm.assign(m.height_mm.size(), 0.015F);
        m.encode(bytes.data(), 0, int(bytes.size()));
      }
      writer.append(e->utime_us, e->channel, bytes);
    }
    writer.close();
  }
  fs::rename(other, log);
  fs::remove(run / "log.lcm.idx");
  fs::remove(run / "log.lcm.new.idx");
}

TEST_CASE("Truth rewritten in the log, its index removed, is noticed by audit, replay and report") {
  for (const bool sealed : {true, false}) {
    const TempFolder root;
    const fs::path run = sealed_print(root);
    CHECK(runs::check_truth(run).differs.empty());
    CHECK(runs::check_truth(run).compared > 0);
    rewrite_truth(run);
    if (!sealed) {  // whoever makes the seals anew still has the world's record against him
      fs::remove_all(run / "seals");
      const std::string text = read_file(run / "provenance.json");
      const std::size_t at = text.find("\"sealed\": true");
      write_bytes(run / "provenance.json", std::string(text).replace(at, 14, "\"sealed\": false"));
      CHECK(runs::check_seals(run).whole());
    }
    CAPTURE(sealed);
    const replay::AuditVerdict v = replay::audit_run(run);
    CHECK(std::ranges::any_of(v.violations, [](const replay::Violation& x) {
      return x.kind == replay::ViolationKind::kOtherTruth && x.what.find("SIM_TRUTH 2") != std::string::npos;
    }));
    ReplayCommandOptions r;
    r.run = run.string();
    CHECK_FALSE(replay_verdict(full_product(), r).identical());
    ReportOptions page;
    page.runs = {run.string()};
    page.output = (root.path() / "r.html").string();
    page.verdicts = {"differs"};
    CHECK_THROWS_AS(write_report(full_product(), page), UsageError);
    page.unsealed = true;
    write_report(full_product(), page);
    CHECK_THAT(read_file(page.output), Contains("no truth is shown"));
  }
}

TEST_CASE("A seal reads back as it was written, and no changed byte of it is accepted") {
  runs::Seal s;
  s.number = 7;
  s.run_id = 1'700'000'000'000'000;
  s.incarnation = 3;
  s.reason = "stopped\nsafely";
  s.before = std::string(64, 'a');
  s.differs = {"nodes/jet.wal: is missing, seal 2 has it"};
  s.files = {{"log.lcm", 812, std::string(64, '0'), true}, {"nodes/a b.wal", 0, std::string(64, 'f'), false}};
  const std::string text = runs::encode_seal(s);
  const runs::Seal back = runs::decode_seal(text);
  CHECK(back.number == 7);
  CHECK(back.run_id == s.run_id);
  CHECK(back.incarnation == 3);
  CHECK(back.reason == "stopped?safely");
  CHECK(back.before == s.before);
  CHECK(back.differs == s.differs);
  REQUIRE(back.files.size() == 2);
  CHECK(back.files[1].path == "nodes/a b.wal");
  CHECK(back.files[0].anew);
  CHECK(back.files[0].bytes == 812);
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string other = text;
    other[at] = char(other[at] ^ 1);
    CAPTURE(at);
    CHECK_THROWS_AS(runs::decode_seal(other), std::runtime_error);
    CHECK_THROWS_AS(runs::decode_seal(text.substr(0, at)), std::runtime_error);
  }
}

TEST_CASE("A seal that names a file outside the run folder is refused") {
  for (const char* path : {"/etc/passwd", "../other/log.lcm", "nodes/../../x", ""}) {
    runs::Seal s;
    s.reason = "finished";
    s.files = {{path, 0, std::string(64, '0'), false}};
    CAPTURE(path);
    CHECK_THROWS_AS(runs::decode_seal(runs::encode_seal(s)), std::runtime_error);
  }
}

}  // namespace
}  // namespace firn::test
