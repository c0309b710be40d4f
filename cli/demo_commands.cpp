#include "cli/commands.h"
#include "cli/demo_command.h"

namespace firn {
namespace {

constexpr Command kCommands[] = {
    {"demo", "prints a cylinder under each scheme, replays the runs, writes a report", declare_demo},
};

}  // namespace

std::span<const Command> commands() { return kCommands; }

}  // namespace firn
