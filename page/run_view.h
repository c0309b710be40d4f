// RunView computes the rows that the page shows from the messages of a print: the same from a live print and
// from a recorded one. It is pure: no clock, no file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/grid/outline.h"
#include "page/view_data.h"

namespace firn::page {

/// Facts of a run that no message holds.
struct ViewFacts {
  double time_scale = 1.0;                   ///< node time over wall time
  std::map<std::string, std::string> ports;  ///< of the instruments, by node: "simulated", or an address
  std::set<std::string> real;                ///< nodes of instruments that are no simulation
  /// Settings of an instrument that the page shows: label, value, unit; by node.
  std::map<std::string, std::vector<std::tuple<std::string, std::string, std::string>>> details;
  std::map<int, std::string> limits;  ///< by code of an interlock: "process.min_measured_fraction 0.8"
  bool platen = false;                ///< the heater is a platen
};

/// Rows that are new since the last call.
struct NewRows {
  std::vector<LayerRow> layers;
  std::vector<EventRow> events;
  std::vector<InstrumentRow> instruments;
  std::vector<EstimateRow> estimates;
  std::vector<std::pair<std::string, std::string>> settings;  ///< key, value: the operator changed it
  bool state = false;                                         ///< it is another one
  bool ended = false;                                         ///< end() is there now
};

class RunView {
 public:
  explicit RunView(ViewFacts facts);

  /// Channels that take() reads.
  static std::set<std::string, std::less<>> channels();

  /// @param now_s when it came, by any steady clock; messages of earlier incarnations count too
  void take(std::string_view channel, std::span<const std::byte> message, double now_s);
  /// Takes that the print runs: something came from it.
  void alive(double now_s) { alive_s_ = now_s; }
  /// Takes the last bytes that crossed an instrument's port.
  void exchanged(const std::string& node, const std::string& text);
  /// Takes a prediction of a layer's RMS [um], and the outline of its measured map.
  void predicted(int layer, double rms_um);
  void outline(int layer, const OutlineStats& stats);
  /// Takes the end that the run folder holds, or that nobody prints it any more.
  void over(const std::string& outcome, const std::string& reason);
  /// Takes verdict and facts of the result that the run folder holds.
  void judged(const std::string& verdict, std::optional<bool> within, const std::string& facts);
  /// Takes that the print goes on after an end: it was resumed.
  void resumed();

  StateRow state(double now_s) const;
  const std::map<int, LayerRow>& layers() const { return layers_; }
  const std::deque<EventRow>& events() const { return events_; }
  const std::map<std::string, InstrumentRow>& instruments() const { return instruments_; }
  const std::vector<EstimateRow>& estimates() const { return estimates_; }
  const std::optional<EndRow>& end() const { return end_; }
  int layers_expected() const { return layers_expected_; }

  NewRows take_new();

 private:
  template <class Message>
  bool decode(std::span<const std::byte> bytes, Message& m) {
    if (m.decode(bytes.data(), 0, int(bytes.size())) != int(bytes.size())) return false;
    at_time(m.header.utime_us);
    return true;
  }
  void at_time(std::int64_t utime_us);
  void on_command(std::string_view channel, std::span<const std::byte> bytes);
  void on_measurement(std::string_view channel, std::span<const std::byte> bytes);
  void on_line_plan(std::span<const std::byte> bytes);
  void decided(int decision, const std::string& reason);
  void on_exposure(std::span<const std::byte> bytes);
  void on_operator(std::span<const std::byte> bytes);
  void on_fault(std::span<const std::byte> bytes);
  void on_instrument(std::string_view channel, std::span<const std::byte> bytes);
  void on_estimate(std::string_view channel, std::span<const std::byte> bytes);
  void on_stop(std::string_view channel, std::span<const std::byte> bytes);
  void on_metrics(std::span<const std::byte> bytes);
  void doubt(int layer, const std::string& where, std::int64_t droplets);
  void set_phase(Phase phase, std::string words);
  EventRow& event(Weight weight, std::string source, std::string words);
  InstrumentRow& instrument(const std::string& node);
  /// Puts a row before the others, or in the place of the one with this label.
  static void put_detail(InstrumentRow&, const std::string& label, const std::string& value,
                         const std::string& unit);

  ViewFacts facts_;
  double now_s_ = 0.0;          // of the message at hand
  std::int64_t utime_us_ = 0;   // of the message at hand
  std::int64_t newest_us_ = 0;  // of all messages
  double newest_s_ = 0.0;       // when it came
  std::optional<double> alive_s_;
  std::optional<std::int64_t> surface_us_, instruments_us_, controller_us_;
  Phase phase_ = Phase::kStarting, before_pause_ = Phase::kStarting;
  std::string words_ = "the print begins", words_before_;
  int layer_ = 0, layers_expected_ = 0;
  int first_layer_ = -1;  // with metrics, of this incarnation
  double first_s_ = 0.0;  // node time of it
  bool paused_ = false, stopping_ = false, operator_stopped_ = false;
  std::optional<int> doubt_layer_;
  std::string doubt_words_;
  double lamp_open_s_ = 0.0;  // by the commands of this print
  int exposures_ = 0;
  std::vector<std::tuple<std::string, double, double>> temperatures_;
  std::optional<EstimateRow> flow_;
  std::string interval_;
  struct PathPlace {
    int layer = 0, index = 0, count = 0;
    bool measures = false;
  };
  std::map<std::int64_t, PathPlace> paths_;  // of the last batches
  std::map<int, LayerRow> layers_;
  std::map<int, double> predicted_;
  std::map<int, OutlineStats> outlines_;
  std::deque<EventRow> events_;
  std::int64_t events_count_ = 0, events_told_ = 0;
  std::map<std::string, InstrumentRow> instruments_;
  std::vector<EstimateRow> estimates_;
  std::optional<EndRow> end_;
  EndRow last_stop_;  // the first fault that stopped the lab; no words: none
  NewRows new_;
  std::set<std::string> changed_instruments_;
  std::set<int> changed_layers_;
};

}  // namespace firn::page
