// run_queue keeps the prints that wait for the same lab, and prints them one after another: each begins only
// when a person has said that the bed is clear.
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/print_command.h"
#include "cli/user_config.h"
#include "config/include.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/interrupt.h"
#include "print/labs/product.h"
#include "print/operator/print_queue.h"
#include "print/process/bus_port.h"
#include "runs/folder/documents.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

enum class QueueAction { kList, kAdd, kRemove, kClear, kStart };

struct QueueOptions {
  QueueAction action = QueueAction::kList;
  std::string runs;     ///< folder of the runs and of the queue
  PrintOptions print;   ///< of kAdd
  std::int64_t id = 0;  ///< of kRemove
  std::string by;       ///< who says so; empty: the user of the configuration, or of the system
  bool first = false;   ///< kAdd: before all others
  bool json = false;
};

constexpr int kLook_ms = 200;  // for the word of another terminal, and for Ctrl-C

std::string person(const QueueOptions& o) {
  if (!o.by.empty()) return o.by;
  const std::string name = read_user_config().name;
  return name.empty() ? runs::user_name() : name;
}

std::string print_words(const QueuedPrint& p) {
  std::string text = p.experiment;
  for (const std::string& s : p.overrides) text += " --set " + s;
  for (const std::string& m : p.meta) text += " --meta " + m;
  return text;
}

int list_queue(const QueueOptions& o) {
  const fs::path file = queue_file(o.runs);
  const PrintQueue queue = read_queue(file);
  if (o.json) {
    nlohmann::ordered_json prints = nlohmann::ordered_json::array();
    for (const QueuedPrint& p : queue.prints)
      prints.push_back({{"id", p.id},
                        {"experiment", p.experiment},
                        {"set", p.overrides},
                        {"meta", p.meta},
                        {"by", p.by},
                        {"added_utc", p.added_utc},
                        {"state", p.state()},
                        {"run", p.run},
                        {"why", p.why}});
    const nlohmann::ordered_json j{
        {"file", file.string()}, {"bed_cleared_by", queue.cleared_by}, {"prints", prints}};
    fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    return kOk;
  }
  for (const QueuedPrint& p : queue.prints)
    fmt::print("{:>4}  {}  ({}{}, added by {})\n", p.id, print_words(p), p.state(),
               p.why.empty() ? p.why : ": " + p.why, p.by);
  if (queue.prints.empty()) fmt::print("{}: no print waits\n", file.string());
  if (!queue.cleared_by.empty())
    fmt::print("the bed is clear, says {} ({})\n", queue.cleared_by, queue.cleared_utc);
  return kOk;
}

/// Changes the queue under its lock. @param change returns true if there is something to save
/// @returns the same
bool change_queue(const QueueOptions& o, const std::function<bool(PrintQueue&)>& change) {
  QueueChange held(queue_file(o.runs));
  if (!change(held.queue)) return false;
  held.save();
  return true;
}

int add_to_queue(const Product& product, const QueueOptions& o) {
  const fs::path experiment = fs::absolute(o.print.experiment);
  std::vector<std::string> overrides = o.print.overrides;
  for (const std::string& assignment : o.print.meta) overrides.push_back("meta." + assignment);
  const Experiment e = load_experiment(experiment, overrides);  // a mistake is told now, not at night
  make_inputs(product, e, experiment.parent_path());
  check_bus(o.print.bus);
  require_meta(load_meta(experiment, overrides));
  QueuedPrint p;
  p.experiment = experiment.string();
  p.digest = experiment_digest(experiment);
  p.overrides = o.print.overrides;
  p.meta = o.print.meta;
  p.accept_bringup = o.print.accept_bringup;
  p.bus = o.print.bus;
  p.tolerance_um = o.print.tolerance_um;
  p.by = person(o);
  std::int64_t id = 0;
  change_queue(o, [&](PrintQueue& q) { return (id = q.add(p, o.first)) > 0; });
  if (o.json) return list_queue(o);
  fmt::print("{}: {}\n", id, print_words(p));
  return kOk;
}

int remove_from_queue(const QueueOptions& o) {
  if (!change_queue(o, [&](PrintQueue& q) { return q.remove(o.id); }))
    throw UsageError(
        fmt::format("{}: has no print {}; firn queue list shows them", queue_file(o.runs).string(), o.id));
  return o.json ? list_queue(o) : kOk;
}

int say_clear(const QueueOptions& o) {
  const std::string by = person(o);
  change_queue(o, [&](PrintQueue& q) {
    q.clear(by);
    return true;
  });
  if (o.json) return list_queue(o);
  fmt::print("the bed is clear, says {}: the next print may begin\n", by);
  return kOk;
}

// A print that was stopped goes on by a person's hand, and leaves the queue when it has ended.
void drop_finished(const QueueOptions& o) {
  const PrintQueue queue = read_queue(queue_file(o.runs));
  if (queue.prints.empty() || queue.prints.front().run.empty() || !fs::exists(queue.prints.front().run))
    return;
  const auto result = runs::RunFolder::open(queue.prints.front().run).result();
  if (!result || runs::can_go_on(*result)) return;
  change_queue(o, [&](PrintQueue& q) { return q.remove(queue.prints.front().id); });
}

/// Returns who says that the bed is clear; empty: Ctrl-C, or the answer was no.
std::string bed_is_clear(const QueueOptions& o, const QueuedPrint& next) {
  const bool terminal = ::isatty(STDIN_FILENO) != 0;
  if (std::string by = read_queue(queue_file(o.runs)).cleared_by; !by.empty()) return by;
  fmt::print(stderr, "next: {}: {}\nis the bed clear? {}firn queue clear in another terminal says so\n",
             next.id, print_words(next), terminal ? "y and Enter, or " : "");
  const InterruptGuard guard;
  while (!InterruptGuard::raised()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, terminal ? 1 : 0, kLook_ms) > 0) {
      std::string answer;
      if (!std::getline(std::cin, answer)) return "";
      return answer == "y" || answer == "yes" ? person(o) : "";
    }
    if (std::string by = read_queue(queue_file(o.runs)).cleared_by; !by.empty()) return by;
  }
  return "";
}

[[noreturn]] void refuse_unfinished(const QueuedPrint& p) {
  if (p.run.empty())
    throw UsageError(
        fmt::format("{}: {} began at {}, and this program ended before it did: see firn runs; firn queue "
                    "remove {} takes it "
                    "off the queue",
                    p.id, print_words(p), p.began_utc, p.id));
  throw UsageError(
      fmt::format("{}: {} was stopped: {}; firn print --resume {} goes on, or firn queue remove {} takes it "
                  "off the queue",
                  p.id, print_words(p), p.why, p.run, p.id));
}

/// Returns the run folders that are not known. A new one tells that a print has begun: droplets may lie on
/// the bed.
std::vector<fs::path> folders_beside(const fs::path& runs, const std::vector<fs::path>& known) {
  std::vector<fs::path> others;
  std::error_code none;
  for (const fs::directory_entry& e : fs::directory_iterator(runs, none))
    if (e.is_directory() && std::ranges::find(known, e.path()) == known.end()) others.push_back(e.path());
  return others;
}

/// Returns the exit code of the print; nothing where it was taken off, or another put before it, while its
/// bed was waited for.
std::optional<int> print_next(const Product& product, const QueueOptions& o, const QueuedPrint& next) {
  if (!next.began_utc.empty()) refuse_unfinished(next);
  if (experiment_digest(next.experiment) != next.digest)
    throw UsageError(
        fmt::format("{}: {} is not as it was when it was queued; firn queue remove {}, and add it again",
                    next.id, next.experiment, next.id));
  const std::string by = bed_is_clear(o, next);
  if (by.empty()) return kInterrupted;
  PrintOptions print;
  print.experiment = next.experiment;
  print.overrides = next.overrides;
  print.meta = next.meta;
  print.meta.push_back("bed_cleared_by=" + by);
  print.accept_bringup = next.accept_bringup;
  print.bus = next.bus;
  print.tolerance_um = next.tolerance_um;
  print.runs = o.runs;
  print.json = o.json;
  const std::vector<fs::path> before = folders_beside(o.runs, {});
  if (!change_queue(o, [&](PrintQueue& q) { return q.begin(next.id); })) return std::nullopt;
  PrintEnd end;
  try {
    end = carry_out(product, print);
  } catch (const std::exception& e) {
    const std::vector<fs::path> begun = folders_beside(o.runs, before);
    change_queue(o, [&](PrintQueue& q) {
      begun.empty() ? q.put_back(next.id, by) : q.end(next.id, begun.front().string(), e.what());
      return true;
    });
    throw;
  }
  std::string why;
  if (end.code != kOk && end.code != kOutOfTolerance) {
    const auto result = runs::RunFolder::open(end.run).result();
    why = result ? for_people(result->reason) : "it did not end";
  }
  change_queue(o, [&](PrintQueue& q) {
    q.end(next.id, end.run, why);
    return true;
  });
  return end.code;
}

int start_queue(const Product& product, const QueueOptions& o) {
  const QueueTurn turn(queue_file(o.runs));
  for (int worst = kOk;;) {
    drop_finished(o);
    const PrintQueue queue = read_queue(queue_file(o.runs));
    if (queue.prints.empty()) {
      fmt::print(stderr, "{}: no print waits\n", queue_file(o.runs).string());
      return worst;
    }
    const std::optional<int> code = print_next(product, o, queue.prints.front());
    if (!code) continue;
    if (*code != kOk && *code != kOutOfTolerance) return *code;
    worst = std::max(worst, *code);
  }
}

/// @throws UsageError: a queue that cannot be read, a print that is refused or must be looked at first
int run_queue(const Product& product, const QueueOptions& o) {
  switch (o.action) {
    case QueueAction::kList:
      return list_queue(o);
    case QueueAction::kAdd:
      return add_to_queue(product, o);
    case QueueAction::kRemove:
      return remove_from_queue(o);
    case QueueAction::kClear:
      return say_clear(o);
    case QueueAction::kStart:
      return start_queue(product, o);
  }
  return kUsage;
}

}  // namespace

void declare_queue(OptionSet& options) {
  const auto with = [&](const char* name, const char* summary, QueueAction action) {
    OptionSet sub = options.subcommand(name, summary);
    auto& o = sub.calls(run_queue);
    o.action = action;
    if (action == QueueAction::kAdd) {
      sub.option("EXPERIMENT", o.print.experiment, "experiment file").required();
      sub.override_option(o.print.overrides);
      sub.option("--meta", o.print.meta, "KEY=VALUE: what is printed, as of firn print").one_value_each();
      sub.option("--bus", o.print.bus, "as of firn print");
      sub.option("--tolerance", o.print.tolerance_um, "UM: as of firn print").above_zero();
      sub.option("--accept-bringup", o.print.accept_bringup, "NODE:ROW or all, as of firn print")
          .one_value_each();
      sub.flag("--first", o.first, "before all that wait");
    }
    if (action == QueueAction::kRemove) sub.option("ID", o.id, "as firn queue list shows it").required();
    if (action == QueueAction::kAdd || action == QueueAction::kClear || action == QueueAction::kStart)
      sub.option("--by", o.by, "name of who says so; default: user.name of your configuration");
    sub.runs_option(o.runs, "folder of the runs, and of the queue: one for each lab");
    sub.json_flag(o.json);
  };
  with("list", "prints that wait, the next one first", QueueAction::kList);
  with("add", "adds a print; mistakes in it are told now", QueueAction::kAdd);
  with("remove", "takes a print off the queue", QueueAction::kRemove);
  with("clear", "says that the bed is clear for the next print", QueueAction::kClear);
  with("start", "prints one after another, each after a person's word that the bed is clear",
       QueueAction::kStart);
  options.require_subcommand();
}

}  // namespace firn
