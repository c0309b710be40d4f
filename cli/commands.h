// The commands of firn: all_commands lists them in the order of the help text; declare_NAME declares the
// arguments of firn NAME and the function that carries it out.
#pragma once

#include <span>

#include "cli/command.h"

namespace firn {

void declare_attach(OptionSet& options);
void declare_audit(OptionSet& options);
void declare_bringup(OptionSet& options);
void declare_bundle(OptionSet& options);
void declare_calibrate(OptionSet& options);
void declare_cassette(OptionSet& options);
void declare_compare(OptionSet& options);
void declare_completion(OptionSet& options);
void declare_config(OptionSet& options);
void declare_ctl(OptionSet& options);
void declare_dataflow(OptionSet& options);
void declare_decide(OptionSet& options);
void declare_demo(OptionSet& options);
void declare_device(OptionSet& options);
void declare_doctor(OptionSet& options);
void declare_droplets(OptionSet& options);
void declare_export(OptionSet& options);
void declare_help(OptionSet& options);
void declare_host(OptionSet& options);
void declare_identify(OptionSet& options);
void declare_import(OptionSet& options);
void declare_key(OptionSet& options);
void declare_log(OptionSet& options);
void declare_people(OptionSet& options);
void declare_plan(OptionSet& options);
void declare_preview(OptionSet& options);
void declare_print(OptionSet& options);
void declare_queue(OptionSet& options);
void declare_replay(OptionSet& options);
void declare_report(OptionSet& options);
void declare_repro(OptionSet& options);
void declare_reproduce(OptionSet& options);
void declare_runs(OptionSet& options);
void declare_say(OptionSet& options);
void declare_slice(OptionSet& options);
void declare_spy(OptionSet& options);
void declare_tune(OptionSet& options);
void declare_view(OptionSet& options);

std::span<const Command> all_commands();

}  // namespace firn
