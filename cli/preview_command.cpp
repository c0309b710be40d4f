// run_preview shows a print before it begins: part, cost, and misfits.
#include "cli/commands.h"

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/user_config.h"
#include "config/include.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "print/labs/product.h"
#include "print/preview/print_preview.h"

namespace firn {
namespace {

struct PreviewOptions {
  std::string experiment;
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  std::string output;                  ///< SVG; "" = no picture
  bool json = false;
};

constexpr double kPatience_s = 10.0;  // of the simulated print

/// @returns 0, or 1 where the print would be refused
int run_preview(const Product& product, const PreviewOptions& options) {
  const std::filesystem::path file = options.experiment;
  std::vector<std::string> overrides = options.overrides;
  name_operator(file, overrides);
  Experiment e = load_experiment(file, overrides);
  const Blobs inputs = make_inputs(product, e, file.parent_path());
  complete_experiment(product, e, inputs);
  PrintPreview p = preview_print(e, inputs, file.parent_path());
  if (const auto foretold = foretell(product, e, inputs, kPatience_s)) take_foretold(*foretold, e, p);
  if (!options.output.empty()) write_file_atomically(options.output, preview_svg(p));
  std::fputs((options.json ? preview_json(p) : preview_text(p)).c_str(), stdout);
  return p.outside.empty() ? kOk : kFailed;
}

}  // namespace

void declare_preview(OptionSet& options) {
  auto& o = options.calls(run_preview);
  options.option("EXPERIMENT", o.experiment, "experiment file").required();
  options.override_option(o.overrides);
  options.option("-o,--output", o.output, "picture of the finished part, an SVG file");
  options.json_flag(o.json);
}

}  // namespace firn
