#include "cli/print_run.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "cli/print_show.h"
#include "config/labs.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "lcmtypes/told_heights.h"
#include "print/exit_codes.h"
#include "print/folder/folder_watch.h"
#include "print/folder/lab_lock.h"
#include "print/folder/run_pack.h"
#include "print/inputs/check_print.h"
#include "print/interrupt.h"
#include "print/live/bus_port.h"
#include "print/live/launcher.h"
#include "print/live/row_rehearsal.h"
#include "print/operator/page_token.h"
#include "print/progress.h"
#include "print/simulated/lab_run.h"

namespace firn {
namespace {

// The records of a run take a sixth of the room when they are packed, and nothing needs them plain but a
// resume.
void pack_after(const std::string& folder, const Experiment& e, PrintProgress& progress) try {
  const LabLock held(RunFolder::open(folder), e, "", LabLock::Heirs::kNobody);
  pack_records(folder);
} catch (const std::exception& error) {
  progress.note(std::string("the run folder stays plain: ") + error.what());
}

// The page is there for people: by default where one has a terminal, and its program is built.
bool page_wanted(const PrintOptions& o) {
  if (o.page || o.no_page || o.json) return o.page;
  return ::isatty(STDERR_FILENO) &&
         std::filesystem::exists(std::filesystem::read_symlink("/proc/self/exe").parent_path() / "page");
}

// The token is for who sits at the terminal, and does not go into files.
std::string page_text(const std::string& address, const std::string& token) {
  return "page: " + address +
         (::isatty(STDERR_FILENO) ? "#token=" + token
                                  : " (to watch; firn view RUN gives an address for commands)");
}

}  // namespace

std::vector<OperatorOrder> orders_with_resume(const PrintOptions& options) {
  std::vector<OperatorOrder> orders;
  if (options.accept_doubt) orders.push_back({new_order_id(), OperatorVerb::kAcceptDoubt, {}, {}});
  if (options.resume.empty()) return orders;
  for (const std::string& assignment : options.overrides)
    orders.push_back(parse_order(std::vector<std::string>{"set", assignment}));
  return orders;
}

PrintSummary carry_out_print(const RunFolder& run, const Experiment& e, const PrintOptions& options,
                             bool resume) {
  PrintSummary s;
  s.folder = run.path().string();
  s.scheme = e.control.scheme;
  s.words = print_lab(e).words;
  s.tolerance_asked = options.tolerance_um > 0.0;
  s.tolerance_um = s.tolerance_asked ? options.tolerance_um : usual_tolerance_um(e);
  PrintProgress progress(e.control.scheme);
  const auto began = std::chrono::steady_clock::now();
  int last_layer = 0;
  const auto note = [&](const std::string& text) { progress.note(text); };
  progress.note("run folder " + s.folder);
  const auto on_layer = [&](const layer_metrics_t& m) {
    progress.layer(m);
    s.measured = heights_told(m);
    s.mean_error_um = m.mean_error_mm * 1e3;
    s.rms_um = m.rms_mm * 1e3;
    s.std_um = m.std_mm * 1e3;
    s.rms_inside_um = m.rms_inside_mm * 1e3;
    s.rms_rim_um = m.rms_rim_mm * 1e3;
    s.cells_guessed = m.cells_guessed;
    s.rows_lost += m.rows_lost;
    s.droplets = m.drops_total;
    last_layer = m.layer;
    s.node_s = double(m.header.utime_us) * 1e-6;
  };
  const auto on_warning = [&](const fault_t& f) { progress.note("warning: " + f.node + ": " + f.text); };
  const auto with = [&](auto o) {
    o.resume = resume;
    o.orders = orders_with_resume(options);
    o.note = note;
    o.unsealed = options.unsealed;
    o.faults = parse_lab_faults(options.faults, e);
    o.progress = on_layer;
    o.warned = on_warning;
    return o;
  };
  if (options.bus == "in-process") {
    LabRunOptions o = with(LabRunOptions{});
    const InterruptGuard guard;
    o.interrupted = InterruptGuard::raised;
    const LabRunReport report = run_in_lab(run, o);
    s.result = report.result;
    s.folder = report.folder.string();
  } else {
    LaunchOptions o = with(LaunchOptions{});
    o.bus_url = options.bus;
    o.record = options.record;
    if (page_wanted(options)) o.page_token = new_page_token();
    o.on_page = [&](const std::string& address) { progress.note(page_text(address, o.page_token)); };
    const LaunchReport report = launch(run, o);
    s.result = report.result;
    s.folder = report.folder.string();
  }
  s.deleted = s.folder.empty();
  if (!s.deleted && !options.plain) pack_after(s.folder, e, progress);
  if (s.deleted) s.folder = run.path().string();
  progress.done();
  s.result.layers = std::max(s.result.layers, last_layer);  // a print that was stopped has no end of its own
  s.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return s;
}

void check_request(const Experiment& e, const Blobs& inputs, const PrintOptions& options) {
  check_bus(options.bus);
  check_print(e, options.bus);
  check_inputs(e, inputs);
}

RunFolder make_run_folder(const Experiment& e, const Blobs& inputs, const PrintOptions& options) try {
  RunFolder run = RunFolder::create(options.runs, e, inputs, own_command_line());
  if (!options.bringup_state.empty())
    write_file_atomically(run.path() / "bringup.json", options.bringup_state);
  return run;
} catch (const UsageError&) {
  throw;
} catch (const std::runtime_error& error) {
  const std::string storage = storage_trouble(error);
  throw UsageError(storage.empty() ? error.what() : storage);
}

void slow_to_rows(Experiment& e, const PrintOptions& options) {
  const bool keeps_rows = e.laser_profiler.read == drivers::ProfileRead::kMemory;
  if (options.bus == "in-process" || prints_paths(e) || keeps_rows) return;
  const double period_s = row_period_s(e, e.process.scan_speed_mm_s);
  if (const std::string slower = fit_scan_speed(e, slowest_row_s(period_s)); !slower.empty())
    fmt::print(stderr, "{}\n", slower);
}

PrintSummary print_experiment(const Experiment& asked, const Blobs& inputs, const PrintOptions& options) {
  Experiment e = asked;
  check_request(e, inputs, options);
  slow_to_rows(e, options);
  return carry_out_print(make_run_folder(e, inputs, options), e, options, false);
}

}  // namespace firn
