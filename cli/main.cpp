// firn: every command, every lab.
#include "cli/commands.h"
#include "cli/program.h"
#include "print/labs/full_product.h"

int main(int argc, char** argv) {
  return firn::run_program(firn::all_commands(), firn::full_product(), argc, argv);
}
