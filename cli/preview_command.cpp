#include "cli/preview_command.h"

#include <cstdio>
#include <filesystem>

#include "cli/option_set.h"
#include "config/include.h"
#include "files/text_file.h"
#include "print/exit_codes.h"
#include "print/labs/print_labs.h"
#include "print/preview/print_preview.h"

namespace firn {

int run_preview(const PreviewOptions& options) {
  const std::filesystem::path file = options.experiment;
  Experiment e = load_experiment(file, options.overrides);
  const Blobs inputs = make_inputs(e, file.parent_path());
  complete_experiment(e, inputs);
  const PrintPreview p = preview_print(e, inputs, file.parent_path());
  if (!options.output.empty()) write_file_atomically(options.output, preview_svg(p));
  std::fputs((options.json ? preview_json(p) : preview_text(p)).c_str(), stdout);
  return p.outside.empty() ? kOk : kFailed;
}

void declare_preview(OptionSet& options) {
  auto& o = options.calls(run_preview);
  options.option("EXPERIMENT", o.experiment, "experiment file").required();
  options.override_option(o.overrides);
  options.option("-o,--output", o.output, "picture of the finished part, an SVG file");
  options.json_flag(o.json);
}

}  // namespace firn
