// ProcessArgs holds the command line that the launcher gives every process of a run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/process.h"

namespace firn {

struct ProcessArgs {
  ProcessOptions options;  ///< without `head`
  std::string bus_url;
  std::vector<std::pair<std::string, std::string>> blobs;  ///< role, sha256 of DIR/inputs/<sha256>
};

/// "--run DIR --bus URL --node NAME --control-fd N --epoch-ns E --offset-us O --time-scale S --incarnation I
///  --run-id R [--faults LOSS,DUPLICATE,REORDER,DELAY,DELAY_S,SEED] [--blob ROLE=SHA256]…
///  [--port NAME=ADDRESS]…"
/// @throws std::invalid_argument naming the argument and its requirement
ProcessArgs parse_process_args(const std::vector<std::string>& args);
/// The arguments for parse_process_args.
std::vector<std::string> to_arguments(const ProcessArgs& args);

/// Returns the bytes of a file. @throws std::runtime_error naming the file
std::string read_text_file(const std::filesystem::path& path);
/// The blobs of `args`, read from the run folder. @throws std::runtime_error naming the file
Blobs read_blobs(const ProcessArgs& args);

}  // namespace firn
