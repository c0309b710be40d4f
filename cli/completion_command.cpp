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
  std::string output;  ///< file of a script, "": standard output; folder of the pages
};

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw UsageError(folder.string() + ": cannot be made: " + error.message());
}

int run_completion(const CommandTree& program, const CompletionOptions& options) {
  const std::filesystem::path output = options.output;
  if (options.form == "man") {
    if (output.empty()) throw UsageError("firn completion man: name the folder of the pages, -o FOLDER");
    make_folder(output);
    for (const ManPage& page : man_pages(program, build_version()))
      write_file_atomically(output / (page.name + ".1"), page.roff);
    return kOk;
  }
  const std::string script = completion_script(program, options.form);
  if (output.empty()) {
    std::fputs(script.c_str(), stdout);
    return kOk;
  }
  if (output.has_parent_path()) make_folder(output.parent_path());
  write_file_atomically(output, script);
  return kOk;
}

}  // namespace

void declare_completion(OptionSet& options) {
  auto& o = options.calls(run_completion);
  options.option("FORM", o.form, "bash, zsh, fish: the script for this shell; man: pages of the manual")
      .required()
      .one_of({"bash", "zsh", "fish", "man"});
  options.option("-o,--output", o.output, "file of the script, folder of the pages; folders are made");
}

}  // namespace firn
