#include "tests/bench/case_bench.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <span>
#include <thread>

#include "cli/make_study.h"
#include "files/digest.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "runtime/build_info.h"

namespace firn::bench {
namespace {

using Json = nlohmann::json;

double cpu_s(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

class CaseWork : public StudyWork {
 public:
  CaseWork(const Cases& cases, int threads) : cases_(cases), threads_(threads) {
    name = cases.name;
    noun = "case";
    kinds = cases.kinds;
    seeds = cases.seeds;
    for (std::size_t s = 0; s < seeds.size(); ++s)
      for (std::size_t k = 0; k < kinds.size(); ++k) {
        const std::string all =
            name + "\n" + cases.settings + "\n" + kinds[k] + "\nseed " + std::to_string(seeds[s]);
        cells.push_back({k, 0, s, sha256_hex(std::as_bytes(std::span(all)))});
      }
  }

  StudyPrint make(const StudyCell& cell) const override {
    const clockid_t clock = cases_.one_by_one ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_THREAD_CPUTIME_ID;
    const double began = cpu_s(clock);
    StudyPrint print;
    try {
      print.document = cases_.make(cell.arm, seeds[cell.seed], threads_);
      print.finished = true;
      print.outcome = "made";
    } catch (const std::exception& error) {
      print.outcome = "error";
      print.reason = error.what();
    }
    print.cpu_s = cpu_s(clock) - began;
    return print;
  }

 private:
  const Cases& cases_;
  int threads_;
};

}  // namespace

std::string text_of(const std::vector<double>& numbers) { return Json(numbers).dump(); }

std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  for (const Json& n : Json::parse(text))
    numbers.push_back(n.is_null() ? std::numeric_limits<double>::quiet_NaN() : n.get<double>());
  return numbers;
}

CaseBench::CaseBench(const std::string& name, const std::string& about)
    : name_(name), app_(std::make_unique<CLI::App>(about)), options_(*app_, full_product(), run_) {
  options_.option("-o,--output", study.output, "folder of the results: the same command goes on from it");
  declare_study(options_, study, "cases");
}

CaseBench::~CaseBench() = default;

std::optional<int> CaseBench::parse(int argc, char** argv) {
  program_ = std::filesystem::absolute(argv[0]).string();
  if (argc == 2 && std::string(argv[1]) == "--version") {  // asked of other computers
    std::puts(build_name().c_str());
    return kOk;
  }
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app_->exit(error);
  }
  return std::nullopt;
}

std::optional<std::vector<CaseBench::Result>> CaseBench::results(const Cases& cases,
                                                                 const std::vector<std::string>& words,
                                                                 int& code) const try {
  const int all = std::max(1, int(std::thread::hardware_concurrency()));
  StudyOptions how = study;
  if (cases.one_by_one) how.threads = 1;
  const CaseWork work(cases, study.threads > 0 ? study.threads : all);
  StudyCall call;
  if (!study.on.empty()) {
    call.words = {program_};
    call.words.insert(call.words.end(), words.begin(), words.end());
    call.words.insert(call.words.end(), {"-o", std::filesystem::absolute(study.output).string()});
  }
  const StudyEnd end = make_study(how, work, call);
  code = end.code;
  if (!end.journal) return std::nullopt;
  std::vector<Result> results(work.cells.size());
  for (const StudyCell& cell : work.cells) {
    const StudyPrint& print = *end.journal->find(cell.digest);
    results[cell.arm * cases.seeds.size() + cell.seed] = {print.finished, print.document, print.reason,
                                                          print.cpu_s};
  }
  return results;
} catch (const UsageError& error) {
  std::fprintf(stderr, "%s: %s\n", name_.c_str(), error.what());
  code = kUsage;
  return std::nullopt;
}

}  // namespace firn::bench
