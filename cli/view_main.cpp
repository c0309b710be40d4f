// firn-view: the command view alone, for the runs of every lab.
#include "cli/commands.h"
#include "cli/program.h"
#include "print/labs/full_product.h"

namespace {

constexpr firn::Command kCommands[] = {
    {"view", "shows runs in a browser: state, surface, causes, instruments; commands a running print",
     firn::declare_view},
};

}  // namespace

int main(int argc, char** argv) { return firn::run_program(kCommands, firn::full_product(), argc, argv); }
