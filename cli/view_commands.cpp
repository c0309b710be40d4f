#include "cli/commands.h"
#include "cli/view_command.h"

namespace firn {
namespace {

constexpr Command kCommands[] = {
    {"view", "shows runs in a browser: state, surface, causes, instruments; commands a running print",
     declare_view},
};

}  // namespace

std::span<const Command> commands() { return kCommands; }

}  // namespace firn
