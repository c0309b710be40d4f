// The rows that the page shows of one print: state, layers, events, instruments, estimates. Lengths in um,
// times in s of node time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/grid/outline.h"
#include "firn/page_protocol.h"

namespace firn::page {

struct LayerRow {
  int n = 0;  ///< layers deposited so far; 0: the bare substrate
  double t_s = 0.0;
  double rms_um = 0.0, mean_um = 0.0, max_um = 0.0;  ///< about the target; max: of the absolute error
  OutlineStats outline;                              ///< of the measured map; NaN: not known
  std::int64_t droplets = 0;                         ///< of this layer; 0: the lab counts none
  std::optional<double> predicted_rms_um;            ///< by the model, before the layer was printed
  double decide_ms = 0.0;                            ///< node time; 0: a print in simulated time takes none
};

struct EventRow {
  std::int64_t n = 0;  ///< counts from 1
  double t_s = 0.0;
  Weight weight = Weight::kInfo;
  std::string source;  ///< node, "operator", "print"
  std::string words;
  std::string cause, remedy, manual;  ///< empty: there is none
  std::optional<double> value, limit;
  std::string unit;
};

struct InstrumentRow {
  std::string name, kind, state, words;
  bool real = false;
  std::string link;       ///< its port
  std::string last_text;  ///< the last exchange; empty: none yet
  double last_t_s = 0.0;
  int faults = 0;
  std::vector<std::tuple<std::string, std::string, std::string>> details;  ///< label, value, unit
};

struct EstimateRow {
  double t_s = 0.0;
  std::string name;
  double value = 0.0, sd = 0.0;
  std::string unit;
};

struct DoubtRow {
  std::string words, question;
};

struct StateRow {
  double t_s = 0.0;
  Phase phase = Phase::kStarting;
  std::string words;
  int layer = 0, layers = 0;  ///< printed or being printed; expected of the whole print, 0 = unknown
  std::optional<double> eta_s;
  std::optional<double> link_s, surface_s, instruments_s, controller_s;  ///< ages
  bool paused = false, stopping = false;                                 ///< asked for
  std::optional<DoubtRow> doubt;
  std::vector<std::tuple<std::string, double, double>> temperatures;  ///< place, degC, set degC
  std::optional<EstimateRow> flow;                                    ///< of the first valve
  std::string interval;                                               ///< of the ice lab: "path 3 of 17"
};

struct EndRow {
  std::string outcome = {}, words = {}, cause = {}, remedy = {}, manual = {};
  bool whole = false;        ///< all layers are printed
  bool by_operator = false;  ///< a safe stop that the operator asked for
  // The verdict of result.json in the words of every command; empty until it is there.
  std::string verdict = {};
  std::optional<bool> within = {};  ///< the tolerance was kept
  std::string facts = {};           ///< lines
};

}  // namespace firn::page
