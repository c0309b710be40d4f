// run_completion writes the program's words for a shell, which then completes them, or its pages of the
// manual.
#include <cstdio>
#include <filesystem>
#include <string>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

struct CompletionOptions {
  std::string form;
  std::string folder;
};

int run_completion(const CommandTree& program, const CompletionOptions& options) {
  if (options.form != "man") {
    if (!options.folder.empty())
      throw UsageError("-o: only pages of the manual are files; a script is printed");
    std::fputs(completion_script(program, options.form).c_str(), stdout);
    return kOk;
  }
  if (options.folder.empty())
    throw UsageError("firn completion man: name the folder of the pages, -o FOLDER");
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) throw UsageError(options.folder + ": cannot be made: " + error.message());
  for (const ManPage& page : man_pages(program, build_version()))
    write_file_atomically(std::filesystem::path(options.folder) / (page.name + ".1"), page.roff);
  return kOk;
}

}  // namespace

void declare_completion(OptionSet& options) {
  auto& o = options.calls(run_completion);
  options
      .option("FORM", o.form, "bash, zsh, fish: the script for this shell, printed; man: pages of the manual")
      .required()
      .one_of({"bash", "zsh", "fish", "man"});
  options.option("-o,--output", o.folder, "folder for the pages of the manual");
}

}  // namespace firn
