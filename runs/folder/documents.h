// ProvenanceDocument and RunResult hold the JSON documents of a run folder, read with every type checked.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/grid/outline.h"
#include "runtime/fingerprint.h"

namespace firn::runs {

/// provenance.json. Keys that an older program did not write are empty.
struct ProvenanceDocument {
  std::optional<std::int64_t> run_id;
  std::vector<std::pair<std::string, std::string>>
      texts;  ///< keys with a text, a number or an object, as text
  std::vector<std::string> command_line;
  Fingerprint results;  ///< of the process that began the print; empty: an older program
  bool has_inputs = false;
  std::vector<std::pair<std::string, std::string>> inputs;  ///< role, SHA-256

  std::string text(std::string_view key) const;  ///< "" = not there
};

/// Error of the last measured map against its target, over the part [um].
struct MapError {
  double mean_um = 0.0, rms_um = 0.0, std_um = 0.0;
  double rms_inside_um = 0.0, rms_rim_um = 0.0;  ///< 0: not told
};

/// The printed part: its name and the box around it.
struct PrintedPart {
  std::string name;  ///< "cylinder", "mesh gear.stl"
  std::array<double, 3> size_mm{};
};

/// Use of an instrument in a print.
struct InstrumentUse {
  std::string port;         ///< "simulated", or its address
  double hours = 0.0;       ///< at work, of node time; of a lamp: its commanded exposures
  double volume_mm3 = 0.0;  ///< that it deposited
};

/// Ink and instruments that a print used.
struct PrintUse {
  std::int64_t amount = 0;  ///< droplets, pulses or switches
  double volume_mm3 = 0.0;  ///< by the model of a droplet or a pulse, else by the maps
  std::string depositing;   ///< node of the instrument that deposited
  std::map<std::string, InstrumentUse> instruments;  ///< by node
};

/// result.json: the end of a print and its verdict, as every command, the page and the report show it.
struct RunResult {
  std::string
      outcome;     ///< "finished", "ended early", "stopped safely", "waits for operator", "out of tolerance"
  int status = 0;  ///< exit status of the print
  int layers = 0;
  std::string reason;
  std::optional<MapError> error = {};       ///< none: no map was measured, or an older program printed
  std::optional<double> tolerance_um = {};  ///< of error.rms_um; none: towards no target, or as above
  // Computed at the end from the records of the run (print/run_facts.h); none: an older program printed.
  std::optional<PrintedPart> part = {};
  std::optional<double> overspill_percent = {};  ///< of the last map: volume beside the part over the part's
  std::optional<OutlineStats> outline = {};      ///< of the last map; none: also in a lab of paths
  std::optional<PrintUse> use = {};              ///< none: an older program printed
  std::string audit = {};  ///< "clean", "2 violations: layer 3 ..."; of the records, without their seal
};

/// Returns true if some of the layers are not printed.
bool can_go_on(const RunResult& result);
/// Returns whether the last map was within tolerance; nothing of a print that can go on or was not judged.
std::optional<bool> within_tolerance(const RunResult& result);

/// @param name of the file, for errors
/// @throws std::invalid_argument naming file and byte, or file, key and what must stand there: no JSON, a
/// value of another type or beyond its limits, an input whose digest is not 64 hexadecimal digits
ProvenanceDocument parse_provenance(std::string_view text, const std::string& name);
std::string result_text(const RunResult& result);
/// @throws std::invalid_argument as above; outcome, status, layers and reason are required
RunResult parse_result(std::string_view text, const std::string& name);

}  // namespace firn::runs
