// run_attach shows the progress of a print that runs in another process, and hands keys to it.
#include "cli/commands.h"

#include <fmt/core.h>
#include <poll.h>

#include <sstream>
#include <string>

#include "cli/option_set.h"
#include "cli/print_show.h"
#include "config/labs.h"
#include "files/exit_codes.h"
#include "print/interrupt.h"
#include "print/operator/key_reader.h"
#include "print/operator/operator_client.h"
#include "print/operator/operator_desk.h"
#include "print/progress.h"
#include "runs/folder/address.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/verdict.h"

namespace firn {
namespace {

struct AttachOptions {
  std::string run;  ///< run folder
};

constexpr int kLook_ms = 200;  // for Ctrl-C

void send_keys(KeyReader& keys, OperatorClient& client, PrintProgress& progress) {
  while (const auto key = keys.next())
    if (const KeyPress pressed = keys.press(*key); pressed.order)
      client.send(*pressed.order);
    else
      progress.note(pressed.hint);
}

// As the print's own terminal shows it.
void show_result(const runs::RunFolder& run, const LabWords& words) {
  if (const auto result = run.result())
    fmt::print("{}\n{}{}", end_words(*result), result_lines(*result, words),
               last_line(*result, words, run.path().string()));
}

/// Returns the exit code of the print when it ends. Ctrl-C leaves the print running.
/// @throws UsageError: a run that is not running
int run_attach(const AttachOptions& options) {
  const runs::RunFolder run = runs::RunFolder::open(runs::folder_of(options.run));
  OperatorClient client(run.path());
  client.say("attach");
  const InterruptGuard guard;
  KeyReader keys;
  const LabWords& words = lab_words(lab_kind_in(run.experiment_toml()));
  PrintProgress progress(run.path().filename().string(), words);
  while (!InterruptGuard::raised()) {
    pollfd fds[] = {{client.fd(), POLLIN, 0}, {keys.fd(), POLLIN, 0}};
    ::poll(fds, 2, kLook_ms);
    send_keys(keys, client, progress);
    while (const auto line = client.next(0.0)) {
      std::istringstream in(*line);
      std::string kind, rest;
      in >> kind >> std::ws;
      if (kind == "layer") {
        if (const auto metrics = parse_layer_line(*line)) progress.layer(*metrics);
      } else if (kind == "end") {
        int status = kFailed;
        in >> status >> std::ws;
        std::getline(in, rest);
        progress.note(options.run + ": " + rest);
        const bool over =
            client.await_end(InterruptGuard::raised, [&](const std::string& text) { progress.note(text); });
        if (over) show_result(run, words);
        return status;
      } else {
        std::getline(in, rest);
        progress.note(rest);
      }
    }
    if (client.closed()) {
      progress.note(options.run + ": the print is gone; firn print --resume goes on with it");
      return kFailed;
    }
  }
  progress.note("the print goes on; firn attach " + options.run + " shows it again");
  return kOk;
}

}  // namespace

void declare_attach(OptionSet& options) {
  auto& o = options.calls(run_attach);
  options.option("RUN", o.run, "folder or number of a running print").required();
}

}  // namespace firn
