// Measures the search among many runs, whose folders are synthetic: build/bench/run_search [RUNS]
// Processor time of: the index of all, a query with an index that is up to date, the list of the page.
#include <sys/resource.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <span>
#include <string>

#include "core/grid/random.h"
#include "core/options/number.h"
#include "files/digest.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "page/run_set.h"
#include "runs/find/run_index.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn::bench {

namespace {

namespace fs = std::filesystem;

// Processor time of this process: other work on the machine does not count.
double seconds_of(const std::function<void()>& work) {
  const auto used = [] {
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return double(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * double(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
  };
  const double before = used();
  work();
  return used() - before;
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

// A run folder with its documents, and records of some kilobytes that stand for the real ones. Not synced to
// the disk, as RunFolder does: ten thousand syncs take minutes.
void make(const fs::path& place, int n, const nlohmann::json& usual) {
  RandomStream random(std::uint64_t(n), Purpose::kTest);
  Experiment e = test::tiny_print("run-" + std::to_string(n), n % 3 ? "mpc" : "smf");
  e.plant.seed = std::uint64_t(n);
  e.control.smf.kp = 0.1 * double(1 + n % 7);
  const RunPaths run(place / ("20261201T000000Z-" + e.run.name));
  fs::create_directories(run.nodes_path());
  nlohmann::json provenance = usual;
  provenance["run_id"] = usual.at("run_id").get<std::int64_t>() + n;
  provenance["name"] = e.run.name;
  provenance["scheme"] = e.control.scheme;
  provenance["meta"] = {{"batch", "2026-" + std::to_string(1 + n % 12)},
                        {"ink", n % 4 ? "TPGDA 5" : "HDDA"},
                        {"sample", "S" + std::to_string(n)}};
  write(run.experiment_path(), dump(e));
  write(run.provenance_path(), provenance.dump(2));
  for (const char* node : {"controller", "scheduler", "stage"})
    write(run.wal_path(node), std::string(4000, 'x'));
  runs::RunResult result{"finished", 0, 53, "the last layer is printed"};
  result.error = runs::MapError{random.normal(), 1.0 + 3.0 * random.uniform(), 1.0, 1.0, 2.0};
  result.tolerance_um = 7.6;
  result.part = runs::PrintedPart{"cuboid", {1.9, 1.6, 0.025}};
  write(run.result_path(), runs::result_text(result));
  if (n % 10 == 0)
    write(run.notes_path(),
          R"({"time_utc":"2026-12-01T00:00:00Z","author":"Ada","host":"lab","kind":"tag","text":"good"})"
          "\n");
}

// The provenance of a run as this program writes it.
nlohmann::json usual_provenance(const fs::path& place) {
  const std::string target(600, 't');
  const auto bytes = std::as_bytes(std::span(target));
  const Blobs inputs{{"target", sha256_hex(bytes), {bytes.begin(), bytes.end()}}};
  const runs::RunFolder run = runs::RunFolder::create(place, test::tiny_print("usual"), inputs, {"bench"});
  return nlohmann::json::parse(read_file(run.provenance_path()));
}

}  // namespace

int search_bench(int argc, char** argv) {
  const int count = argc > 1 ? whole_number<int>(argv[1], 1, 1'000'000).value_or(0) : 10'000;
  if (count == 0) {
    std::fprintf(stderr, "run_search [RUNS in [1, 1000000]]\n");
    return 2;
  }
  const test::TempFolder folder;
  const fs::path place = folder.path() / "runs", file = folder.path() / "runs.sqlite";
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const nlohmann::json usual = usual_provenance(folder.path() / "usual");
  std::printf("%-36s %8.2f s\n", "folders", seconds_of([&] {
                for (int n = 0; n < count; ++n) make(place, n, usual);
              }));
  std::printf("%-36s %8.2f s\n", "index", seconds_of([&] { runs::RunIndex(file).refresh({place}); }));
  std::printf("%-36s %8.1f MB\n", "size of the index", double(fs::file_size(file)) * 1e-6);
  for (const char* text :
       {"rms_um < 2 and meta.ink ~ \"TPGDA\" and outcome = finished",
        "sample-none or tag = good and not has meta.operator", "control.smf.kp >= 0.6 and started >= 2026"}) {
    std::size_t found = 0;
    const double s =
        seconds_of([&] {  // as the command does: it opens the index and compares it with the folders
          runs::RunIndex index(file);
          index.refresh({place});
          found = index.find(runs::parse_query(text), text, {place}).size();
        });
    std::printf("query %8.3f s  %6zu runs: %s\n", s, found, text);
  }
  page::RunSet set({place}, {}, file);
  std::size_t bytes = 0;
  std::printf("%-36s %8.3f s", "list of the page", seconds_of([&] { bytes = set.list()().size(); }));
  std::printf("  %.1f MB\n", double(bytes) * 1e-6);
  return 0;
}

}  // namespace firn::bench

int main(int argc, char** argv) { return firn::bench::search_bench(argc, argv); }
