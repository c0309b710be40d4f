#include "cli/print_run.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "cli/user_config.h"
#include "config/device_kinds.h"
#include "config/labs.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/inputs/check_print.h"
#include "print/interrupt.h"
#include "print/live/launcher.h"
#include "print/live/row_rehearsal.h"
#include "print/operator/page_token.h"
#include "print/process/bus_port.h"
#include "print/progress.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/folder_watch.h"
#include "runs/folder/pack.h"
#include "runtime/result_fingerprint.h"

namespace firn {
namespace {

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

PrintSummary carry_out_print(const Product& product, const runs::RunFolder& run, const Experiment& e,
                             const PrintOptions& options, bool resume, const runs::RunLock& lock) {
  PrintSummary s;
  s.folder = run.path().string();
  s.scheme = e.control.scheme;
  s.words = lab_words(e.lab.kind);
  PrintProgress progress(e.control.scheme, s.words);
  progress.foretell(options.foretold_layer_s, e.run.time_scale);
  const auto began = std::chrono::steady_clock::now();
  int last_layer = 0;
  const auto note = [&](const std::string& text) { progress.note(text); };
  progress.note("run folder " + s.folder);
  const auto on_layer = [&](const layer_metrics_t& m) {
    progress.layer(m);
    s.cells_guessed = m.cells_guessed;
    s.rows_lost += m.rows_lost;
    s.droplets = m.drops_total;
    last_layer = m.layer;
    s.node_s = double(m.header.utime_us) * 1e-6;
  };
  const auto on_warning = [&](const fault_t& f) {
    const std::string by = f.node + ": ";
    progress.note("warning: " + (f.text.starts_with(by) ? "" : by) + f.text);
  };
  const auto with = [&](auto o) {
    o.lock = &lock;
    o.resume = resume;
    o.orders = orders_with_resume(options);
    o.note = note;
    o.unsealed = options.unsealed;
    o.faults = parse_lab_faults(options.faults, e);
    o.tolerance_um = options.tolerance_um;
    o.progress = on_layer;
    o.warned = on_warning;
    return o;
  };
  if (options.bus == "in-process") {
    LabRunOptions o = with(LabRunOptions{});
    const InterruptGuard guard;
    o.interrupted = InterruptGuard::raised;
    const LabRunReport report = run_in_lab(product, run, o);
    s.result = report.result;
    s.folder = report.folder.string();
  } else {
    LaunchOptions o = with(LaunchOptions{});
    o.bus_url = options.bus;
    o.record = options.record;
    if (page_wanted(options)) o.page_token = new_page_token();
    o.page_is_public = options.is_public;
    if (!o.page_token.empty()) o.page_people = people_table();
    o.on_page = [&](const std::string& address) { progress.note(page_text(address, o.page_token)); };
    const LaunchReport report = launch(product, run, o);
    s.result = report.result;
    s.folder = report.folder.string();
  }
  s.deleted = s.folder.empty();
  if (s.deleted) s.folder = run.path().string();
  progress.done();
  s.result.layers = std::max(s.result.layers, last_layer);  // a print that was stopped has no end of its own
  s.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return s;
}

void check_request(const Product& product, const Experiment& e, const Blobs& inputs,
                   const PrintOptions& options) {
  check_bus(options.bus);
  check_print(e, options.bus);
  check_inputs(product, e, inputs);
}

runs::RunFolder make_run_folder(const Experiment& e, const Blobs& inputs, const PrintOptions& options) try {
  runs::RunFolder run = runs::RunFolder::create(options.runs, e, inputs, runs::own_command_line(),
                                                result_fingerprint(), options.meta_values);
  if (!options.bringup_state.empty())
    write_file_atomically(run.path() / "bringup.json", options.bringup_state);
  return run;
} catch (const UsageError&) {
  throw;
} catch (const std::runtime_error& error) {
  const std::string storage = runs::storage_trouble(error);
  throw UsageError(storage.empty() ? error.what() : storage);
}

void slow_to_rows(Experiment& e, const PrintOptions& options) {
  const bool keeps_rows = e.laser_profiler.read == drivers::ProfileRead::kMemory || has_point_scan(e);
  if (options.bus == "in-process" || prints_paths(e) || keeps_rows) return;
  const double period_s = row_period_s(e, e.process.scan_speed_mm_s);
  if (const std::string slower = fit_scan_speed(e, slowest_row_s(period_s)); !slower.empty())
    fmt::print(stderr, "{}\n", slower);
}

PrintSummary print_experiment(const Product& product, const Experiment& asked, const Blobs& inputs,
                              const PrintOptions& options) {
  Experiment e = asked;
  check_request(product, e, inputs, options);
  slow_to_rows(e, options);
  const runs::RunFolder run = make_run_folder(e, inputs, options);
  const runs::RunLock lock(run.path(), runs::RunUse::kPrint);
  return carry_out_print(product, run, e, options, false, lock);
}

// The records of a run take a sixth of the room when they are packed, and nothing needs them plain but a
// resume.
void pack_print(const PrintSummary& print, const PrintOptions& options) try {
  if (print.deleted || options.plain) return;
  const InterruptGuard guard;
  JobProgress progress("packing");
  const runs::PackWatch watch{
      [&](double fraction, const std::string& file) { progress.show(fraction, file); },
      InterruptGuard::raised};
  const bool interrupted = runs::pack_run(print.folder, watch).interrupted;
  progress.done();
  if (interrupted)
    fmt::print(stderr, "{}: was not packed to its end; firn runs pack does it\n", print.folder);
} catch (const std::exception& error) {
  fmt::print(stderr, "the run folder stays plain: {}\n", error.what());
}

}  // namespace firn
