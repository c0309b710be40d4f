#include "cli/attach_command.h"

#include <poll.h>

#include <cstdio>
#include <sstream>

#include "cli/option_set.h"
#include "print/exit_codes.h"
#include "print/folder/run_folder.h"
#include "print/interrupt.h"
#include "print/operator/key_reader.h"
#include "print/operator/operator_client.h"
#include "print/operator/operator_desk.h"
#include "print/progress.h"

namespace firn {
namespace {

constexpr int kLook_ms = 200;  // for Ctrl-C

void send_keys(KeyReader& keys, OperatorClient& client, PrintProgress& progress) {
  while (const auto key = keys.next())
    if (const auto order = KeyReader::order_of(*key))
      client.send(*order);
    else
      progress.note(std::string(KeyReader::kHelp));
}

}  // namespace

int run_attach(const AttachOptions& options) {
  const RunFolder run = RunFolder::open(options.run);
  OperatorClient client(options.run);
  client.say("attach");
  const InterruptGuard guard;
  KeyReader keys;
  PrintProgress progress(run.path().filename().string());
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

void declare_attach(OptionSet& options) {
  auto& o = options.calls(run_attach);
  options.option("RUN", o.run, "folder of a running print").required();
}

}  // namespace firn
