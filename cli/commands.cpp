#include "cli/commands.h"

namespace firn {
namespace {

// In the reader's order. A new command is one row here, one in cli/commands.h, its cli/<name>_command.cpp
// and a line in cli/CMakeLists.txt.
constexpr Command kCommands[] = {
    {"demo", "prints a cylinder under each scheme, replays the runs, writes a report", declare_demo},
    {"print", "prints an experiment, live or in one process; resumes", declare_print},
    {"preview", "shows a print before it begins: part, layers, droplets, time, what does not fit",
     declare_preview},
    {"ctl", "commands a running print: pause, continue, finish-layer, stop, accept-doubt, set", declare_ctl},
    {"attach", "shows a print that runs in another process; keys command it", declare_attach},
    {"view", "shows runs in a browser: state, surface, causes, instruments; commands a running print",
     declare_view},
    {"runs", "lists, finds, packs and removes run folders", declare_runs},
    {"host", "runs the processes that another computer's print has here; started by ssh", declare_host},
    {"help", "shows a page of the documents, or where a topic is found", declare_help},
    {"slice", "slices meshes into deposition paths with scaffold, fills and G-code", declare_slice},
    {"plan", "plans certified minimum-time trajectories along paths", declare_plan},
    {"replay", "replays a run bit for bit, or names the first divergence", declare_replay},
    {"spy", "watches a live print: lcm-spy with Firn's types, height map and layer error", declare_spy},
    {"doctor", "what this machine lacks for live prints, and the mend", declare_doctor},
    {"bringup", "checks real instruments row by row before the first print", declare_bringup},
    {"device", "speaks to one instrument: who is it, is it safe, move, expose, with every byte",
     declare_device},
    {"cassette", "holds what an instrument once said against the driver of today", declare_cassette},
    {"droplets", "measures droplets, satellites, velocity and angle in strobe pictures", declare_droplets},
    {"calibrate", "measures where tools stand, when they act and what valves give; levels the table",
     declare_calibrate},
    {"audit", "checks a run's droplets against the world's own record", declare_audit},
    {"identify", "h1, h2, h3 with intervals from a run; the spacing of droplets from prints of squares",
     declare_identify},
    {"tune", "tunes configuration keys from the logs of prints, or gains for a disturbance", declare_tune},
    {"report", "writes one self-contained page for any number of runs", declare_report},
    {"export", "writes runs as HDF5, NumPy arrays, MCAP or CSV", declare_export},
    {"import", "makes a run of a layer-wise record that others made", declare_import},
    {"reproduce", "sets every table and figure of the papers beside ours", declare_reproduce},
    {"decide", "decides one layer on any surface, with a proof of how good it is", declare_decide},
    {"compare", "compares schemes over parts and seeds: which is better, by how much, how sure",
     declare_compare},
    {"log", "describes, verifies, prints and repairs logs and write-ahead files", declare_log},
    {"config", "checks, resolves and documents experiment files", declare_config},
    {"completion", "writes completion for bash, zsh and fish, and pages of the manual", declare_completion},
    {"dataflow", "writes docs/dataflow.md: who sends what to whom", declare_dataflow},
};

}  // namespace

std::span<const Command> all_commands() { return kCommands; }

}  // namespace firn
