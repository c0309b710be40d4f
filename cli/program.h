// run_program is main() of a program with these commands and this product.
#pragma once

#include <span>

#include "cli/command.h"
#include "print/labs/product.h"

namespace firn {

/// Data goes to stdout, progress and errors to stderr. @returns an exit code (files/exit_codes.h)
int run_program(std::span<const Command> commands, const Product& product, int argc, char** argv);

}  // namespace firn
