// run_reproduce sets every table and figure of the papers beside the values computed here.
#include "cli/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <thread>

#include "cli/option_set.h"
#include "config/fields.h"
#include "files/exit_codes.h"
#include "files/mesh/mesh_file.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "report/draw/style.h"
#include "runs/folder/run_folder.h"
#include "studies/reproduce/reproduce.h"

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

/// Progress over all parts.
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

void write_pictures(const std::string& out, const std::vector<PartResult>& results) {
  const std::filesystem::path folder = out;
  for (const PartResult& result : results)
    for (const ReproducePicture& picture : result.pictures)
      write_file_atomically(folder / (std::string(result.part.paper) + "-" + picture.name + ".svg"),
                            report::standalone_svg(picture.svg));
  write_file_atomically(folder / "index.html", reproduce_page(results));
  std::fprintf(stderr, "wrote %s\n", (folder / "index.html").c_str());
}

}  // namespace

std::vector<PartResult> reproduce(const ReproduceOptions& options, const std::vector<ReproducePart>& parts) {
  const std::vector<ReproducePart> wanted = chosen(options, parts);
  std::vector<PartResult> results;
  ReproduceProgress progress(wanted);
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    PartResult& result = results.emplace_back();
    result.part = wanted[n];
    progress.show(n, 0.0, "starting");
    try {
      Collector to(result, options, progress, n);
      wanted[n].run(to);
    } catch (const std::exception& e) {
      result.rows.clear();
      result.beside.clear();
      result.error = e.what();
      continue;  // the other parts may still tell something
    }
    if (options.only.empty()) continue;
    const auto unwanted = [&](const auto& row) {
      return std::ranges::none_of(options.only,
                                  [&](const std::string& only) { return wants_row(only, row.id); });
    };
    std::erase_if(result.rows, unwanted);
    std::erase_if(result.beside, unwanted);
    if (result.rows.empty() && result.beside.empty()) {
      std::string asked = fmt::format("{}", fmt::join(options.only, ", "));
      throw UsageError("part " + full_name(wanted[n]) + " has no row " + asked);
    }
  }
  return results;
}

namespace {

/// @returns 0, or 1 when a row disagrees for no known reason or a part cannot be computed. @throws UsageError
int run_reproduce(const ReproduceOptions& options) {
  if (!options.mesh.empty())  // refused now, not as a row of the table
    for (const MeshFile mesh(options.mesh); const std::string& remark : mesh.data().defects)
      fmt::print(stderr, "warning: {}: {}\n", options.mesh, remark);
  if (std::error_code error; !options.out.empty()) {
    std::filesystem::create_directories(options.out, error);
    if (error) throw UsageError("--out " + options.out + ": " + error.message());
  }
  const std::vector<PartResult> results = reproduce(options, reproduce_parts());
  if (!options.out.empty()) write_pictures(options.out, results);
  std::fputs((options.json ? reproduce_json(results) + "\n" : reproduce_table(results)).c_str(), stdout);
  return all_pass(results) ? kOk : kFailed;
}

}  // namespace

void declare_reproduce(OptionSet& options) {
  auto& o = options.calls(run_reproduce);
  options.option("PAPER", o.paper, "lu, barnett or thompson; default: all");
  options.option("--only", o.only, "parts or rows, by id");
  options.option("-o,--out", o.out, "folder for pictures and index.html");
  options.option("--mesh", o.mesh, "barnett.slicing: a mesh instead of the one made in code");
  options.flag("--quick", o.quick, "fewer repeats: minutes become seconds, statistics become coarse");
  options.thread_option(o.threads);
  options.json_flag(o.json);
}

}  // namespace firn
