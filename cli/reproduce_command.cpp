// run_reproduce sets every table and figure of the papers beside the values computed here.
#include "cli/reproduce_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <optional>
#include <span>
#include <thread>

#include "cli/commands.h"
#include "cli/make_study.h"
#include "cli/option_set.h"
#include "config/fields.h"
#include "files/digest.h"
#include "files/exit_codes.h"
#include "files/mesh/mesh_file.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "report/draw/style.h"
#include "runs/folder/run_folder.h"
#include "studies/reproduce/part_record.h"

namespace firn {
namespace {

using namespace std::chrono_literals;

std::string full_name(const ReproducePart& part) { return std::string(part.paper) + "." + part.name; }

// "a.b" stands at the front of "a.b" and of "a.b.c", not of "a.bc".
bool leads(std::string_view front, std::string_view id) {
  return id.starts_with(front) && (id.size() == front.size() || id[front.size()] == '.');
}

bool wants_row(const std::string& only, const std::string& id) {
  return leads(only, id) || leads(only, std::string_view(id).substr(id.find('.') + 1));
}

// A part also runs when only one of its rows is wanted.
bool wants_part(const std::string& only, const ReproducePart& part) {
  const std::string id = full_name(part);
  return wants_row(only, id) || leads(id, only) || leads(part.name, only);
}

/// Progress over the parts that are computed.
class ReproduceProgress {
 public:
  explicit ReproduceProgress(std::vector<ReproducePart> parts)
      : parts_(std::move(parts)), line_({2s, 200ms, 5s}) {}
  ~ReproduceProgress() { line_.erase(); }
  void show(std::size_t part, double fraction, std::string_view doing) {
    if (!line_.due()) return;
    double done_s = fraction * parts_[part].seconds;
    double all_s = 0.0;
    for (std::size_t n = 0; n < parts_.size(); ++n) {
      all_s += parts_[n].seconds;
      if (n < part) done_s += parts_[n].seconds;
    }
    // The parts' stated seconds until enough is known, then in this machine's measure.
    const double pace = done_s > 1 ? line_.elapsed_s() / done_s : 1.0;
    line_.show(fmt::format("reproduce  part {}/{} {}: {} {:.0f} %  ETA {:.0f} s", part + 1, parts_.size(),
                           full_name(parts_[part]), doing, 100 * fraction,
                           std::max(0.0, all_s - done_s) * pace));
  }

 private:
  std::vector<ReproducePart> parts_;
  ProgressLine line_;
};

class Collector : public Reproduction {
 public:
  Collector(PartResult& result, const ReproduceOptions& options, ReproduceProgress& progress,
            std::size_t number)
      : result_(result), options_(options), progress_(progress), number_(number) {}
  void row(ReproduceRow row) override {
    check_id(row.id);
    const auto refuse = [&](const std::string& why) {
      throw std::logic_error("the row '" + row.id + "' " + why);
    };
    if (is_none(row.printed.value) && is_none(row.derived.value))
      refuse("has no printed and no derived value: a self-check is no row");
    if (!is_none(row.printed.value) && row.printed.place.empty())
      refuse("names no place of its printed value");
    if (!is_none(row.derived.value) && (row.derived.by.empty() || row.derived.how.empty()))
      refuse("does not say who derived its value and how");
    if (!row.compared_with_printed && !row.compared_with_derived && row.unidentifiable_for.empty())
      refuse("is neither compared nor said to be not identifiable");
    result_.rows.push_back(std::move(row));
  }
  void beside(BesideRow row) override {
    check_id(row.id);
    result_.beside.push_back(std::move(row));
  }
  void picture(ReproducePicture picture) override { result_.pictures.push_back(std::move(picture)); }
  void note(std::string text) override { result_.notes.push_back(std::move(text)); }
  void progress(double fraction, std::string_view doing) override {
    progress_.show(number_, std::clamp(fraction, 0.0, 1.0), doing);
  }
  bool quick() const override { return options_.quick; }
  std::string mesh() const override { return options_.mesh; }
  int threads() const override {
    return options_.threads > 0 ? options_.threads : int(std::max(1u, std::thread::hardware_concurrency()));
  }

 private:
  void check_id(const std::string& id) const {
    const std::string front = full_name(result_.part);
    if (!leads(front, id) || id.size() == front.size())
      throw std::logic_error("the row '" + id + "' of part " + front + " must be called " + front +
                             ".<name>");
  }

  PartResult& result_;
  const ReproduceOptions& options_;
  ReproduceProgress& progress_;
  std::size_t number_;
};

std::vector<ReproducePart> chosen(const ReproduceOptions& options, const std::vector<ReproducePart>& parts) {
  std::vector<std::string_view> papers;
  for (const ReproducePart& p : parts)
    if (std::ranges::find(papers, p.paper) == papers.end()) papers.push_back(p.paper);
  if (!options.paper.empty() && std::ranges::find(papers, options.paper) == papers.end())
    throw UsageError("unknown paper '" + options.paper + "'; there are " +
                     fmt::format("{}", fmt::join(papers, ", ")));
  std::vector<ReproducePart> wanted;
  for (const ReproducePart& p : parts)
    if (options.paper.empty() || options.paper == p.paper) wanted.push_back(p);
  for (const std::string& only : options.only)
    if (std::ranges::none_of(wanted, [&](const ReproducePart& p) { return wants_part(only, p); })) {
      std::vector<std::string> names;
      for (const ReproducePart& p : wanted) names.push_back(full_name(p));
      throw UsageError("--only " + only + " is no part or row; parts are " +
                       fmt::format("{}", fmt::join(names, ", ")));
    }
  if (!options.only.empty())
    std::erase_if(wanted, [&](const ReproducePart& p) {
      return std::ranges::none_of(options.only, [&](const std::string& only) { return wants_part(only, p); });
    });
  return wanted;
}

double process_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

std::string part_digest(const ReproducePart& part, const ReproduceOptions& options) {
  std::string all = full_name(part) + (options.quick ? "\nquick" : "");
  if (!options.mesh.empty()) {
    const std::string mesh = read_file(options.mesh);
    all += "\n" + sha256_hex(std::as_bytes(std::span(mesh)));
  }
  return sha256_hex(std::as_bytes(std::span(all)));
}

// The wanted parts as the work of a study: each is computed once.
class ReproduceWork : public StudyWork {
 public:
  ReproduceWork(const ReproduceOptions& options, std::vector<ReproducePart> wanted)
      : options_(options), wanted_(std::move(wanted)) {
    name = "reproduce";
    noun = "part";
    for (std::size_t n = 0; n < wanted_.size(); ++n) {
      kinds.push_back(full_name(wanted_[n]));
      seconds.push_back(wanted_[n].seconds);
      cells.push_back({n, 0, 0, part_digest(wanted_[n], options)});
    }
  }

  StudyPrint make(const StudyCell& cell) const override {
    PartResult result;
    result.part = wanted_[cell.arm];
    const std::size_t number = made_++;
    const double began = process_cpu_s();
    progress_->show(number, 0.0, "starting");
    try {
      Collector to(result, options_, *progress_, number);
      wanted_[cell.arm].run(to);
    } catch (const std::exception& e) {
      result.rows.clear();
      result.beside.clear();
      result.error = e.what();  // the other parts may still tell something
    }
    StudyPrint print{result.error.empty(),
                     result.error.empty() ? "computed" : "error",
                     result.error,
                     {},
                     process_cpu_s() - began};
    print.document = part_record(result);
    return print;
  }

  bool tells_progress(const std::vector<const StudyCell*>& to_make) const override {
    std::vector<ReproducePart> parts_to_make;
    for (const StudyCell* cell : to_make) parts_to_make.push_back(wanted_[cell->arm]);
    progress_.emplace(std::move(parts_to_make));
    return true;
  }

  std::vector<PartResult> results(const StudyJournal& journal) const {
    progress_.reset();
    std::vector<PartResult> all;
    for (const StudyCell& cell : cells)
      all.push_back(part_of(journal.find(cell.digest)->document, wanted_[cell.arm]));
    return all;
  }

 private:
  const ReproduceOptions& options_;
  std::vector<ReproducePart> wanted_;
  mutable std::optional<ReproduceProgress> progress_;  // one part is computed at a time
  mutable std::size_t made_ = 0;
};

// Leaves the rows that --only asks for.
void keep_only(const ReproduceOptions& options, std::vector<PartResult>& results) {
  if (options.only.empty()) return;
  for (PartResult& result : results) {
    if (!result.error.empty()) continue;
    const auto unwanted = [&](const auto& row) {
      return std::ranges::none_of(options.only,
                                  [&](const std::string& only) { return wants_row(only, row.id); });
    };
    std::erase_if(result.rows, unwanted);
    std::erase_if(result.beside, unwanted);
    if (result.rows.empty() && result.beside.empty())
      throw UsageError("part " + full_name(result.part) + " has no row " +
                       fmt::format("{}", fmt::join(options.only, ", ")));
  }
}

// The command of one shard, without its number.
std::vector<std::string> part_words(const ReproduceCall& o) {
  namespace fs = std::filesystem;
  std::vector<std::string> words{fs::read_symlink("/proc/self/exe").string(), "reproduce"};
  if (!o.what.paper.empty()) words.push_back(o.what.paper);
  for (const std::string& only : o.what.only) words.insert(words.end(), {"--only", only});
  if (o.what.quick) words.push_back("--quick");
  if (!o.what.mesh.empty()) words.insert(words.end(), {"--mesh", fs::absolute(o.what.mesh).string()});
  words.insert(words.end(), {"-o", fs::absolute(o.study.output).string()});
  return words;
}

}  // namespace

std::optional<std::vector<PartResult>> reproduce(const ReproduceCall& o,
                                                 const std::vector<ReproducePart>& parts, int& code) {
  const ReproduceWork work(o.what, chosen(o.what, parts));
  StudyOptions one_by_one = o.study;
  one_by_one.threads = 1;
  const StudyEnd end =
      make_study(one_by_one, work, {o.study.on.empty() ? std::vector<std::string>{} : part_words(o)});
  code = end.code;
  if (!end.journal) return std::nullopt;
  std::vector<PartResult> results = work.results(*end.journal);
  keep_only(o.what, results);
  return results;
}

std::vector<PartResult> reproduce(const ReproduceOptions& options, const std::vector<ReproducePart>& parts) {
  int code = kOk;
  return *reproduce(ReproduceCall{options, {}}, parts, code);
}

namespace {

void write_pictures(const std::string& out, const std::vector<PartResult>& results) {
  const std::filesystem::path folder = out;
  for (const PartResult& result : results)
    for (const ReproducePicture& picture : result.pictures)
      write_file_atomically(folder / (std::string(result.part.paper) + "-" + picture.name + ".svg"),
                            report::standalone_svg(picture.svg));
  write_file_atomically(folder / "index.html", reproduce_page(results));
  std::fprintf(stderr, "wrote %s\n", (folder / "index.html").c_str());
}

/// @returns 0, or 1 when a row disagrees for no known reason or a part cannot be computed. @throws UsageError
int run_reproduce(const ReproduceCall& given) {
  ReproduceCall o = given;
  o.what.threads = o.study.threads;
  if (!o.what.mesh.empty())  // refused now, not as a row of the table
    for (const MeshFile mesh(o.what.mesh); const std::string& remark : mesh.data().defects)
      fmt::print(stderr, "warning: {}: {}\n", o.what.mesh, remark);
  int code = kOk;
  const auto results = reproduce(o, reproduce_parts(), code);
  if (!results) return code;
  if (!o.study.output.empty()) write_pictures(o.study.output, *results);
  std::fputs((o.study.json ? reproduce_json(*results) + "\n" : reproduce_table(*results)).c_str(), stdout);
  return all_pass(*results) ? kOk : kFailed;
}

}  // namespace

void declare_reproduce(OptionSet& options) {
  auto& o = options.calls(run_reproduce);
  options.option("PAPER", o.what.paper, "lu, barnett or thompson; default: all");
  options.option("--only", o.what.only, "parts or rows, by id");
  options.option("-o,--out", o.study.output, "folder for pictures, index.html and the results on record");
  options.option("--mesh", o.what.mesh, "barnett.slicing: a mesh instead of the one made in code");
  options.flag("--quick", o.what.quick, "fewer repeats: minutes become seconds, statistics become coarse");
  declare_study(options, o.study, "parts");
  options.json_flag(o.study.json);
}

}  // namespace firn
