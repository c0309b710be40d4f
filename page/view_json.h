// Writes the rows of a RunView as the JSON frames of the page's protocol.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "page/run_view.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_meta.h"
#include "runs/read/run_digest.h"
#include "runs/read/run_reader.h"

namespace firn {
struct Product;
}

namespace firn::page {

/// Who reads a frame, and his rights.
struct Reader {
  std::string name;         ///< empty: not known
  bool commands = false;    ///< may command, as his request shows
  bool needs_token = true;  ///< each command shows a token: the request has shown none that counts
};

/// Facts of a run for its first frame.
struct HelloFacts {
  std::string id, label;
  const std::map<std::string, std::string>* texts = nullptr;  ///< of the provenance
  const Product* product = nullptr;
  const Experiment* experiment = nullptr;
  std::string trouble;  ///< of the experiment; empty: it could be read
  std::optional<GridSpec> grid;
  bool live = false;
  bool may_resume = false;  ///< the page may, once the run is over
  runs::RunNotes notes;
  runs::RunMeta meta;
  Reader reader;
};

/// Returns {"host", "meta", "tags", "notes", "acknowledged"} of a run, as its list and its first frame have
/// them.
nlohmann::ordered_json about_json(const runs::RunMeta& meta, const runs::RunNotes& notes);

std::string hello_frame(const HelloFacts& facts, const RunView& view, double now_s);
std::string state_frame(const StateRow& state);
std::string acknowledged_frame(const runs::RunNotes& notes);
/// Appends a frame for each row.
void add_frames(const NewRows& rows, const std::optional<EndRow>& end, std::vector<std::string>& frames);
/// @param words of the order's effect; empty: none
std::string answer_frame(std::optional<std::int64_t> id, bool ok, const std::string& error,
                         const std::string& words);
std::string error_frame(const std::string& error);
std::string exchanges_json(const std::vector<runs::Exchange>& exchanges);
std::string lamp_json(const runs::LampSum& sum);
std::string pong_frame(std::int64_t id, double t_s);

}  // namespace firn::page
