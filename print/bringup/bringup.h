// bringup checks, row by row, the assumptions of the drivers about real instruments
// (docs/devices/HARDWARE_CHECKLIST.md): the rows that a program can check by itself, with the measurement,
// and those that a person must look at.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "files/port_address.h"
#include "print/bringup/raw_line.h"
#include "print/labs/product.h"

namespace firn {

struct BringupFinding {
  bool ok = false;
  std::string measured, limit;
  std::string mend = {};  ///< the remedy when it is not ok
};

/// The lab as a row may use it. Between rows every port is closed.
class BringupLab {
 public:
  using Address = std::function<PortAddress(const std::string& node)>;
  /// Asks a person; nothing: nobody is there.
  using Ask = std::function<std::optional<bool>(int row, const std::string& question)>;

  BringupLab(const Product& of, const Experiment& experiment, Address address, Ask ask,
             std::function<bool()> interrupted)
      : product(of),
        e(experiment),
        address_(std::move(address)),
        ask_(std::move(ask)),
        interrupted_(std::move(interrupted)) {}

  /// A new connection past the driver. @throws BringupStop: the port does not open
  std::unique_ptr<RawLine> line(const std::string& node) const;
  /// Runs an order, or with none just the beginning, through the instrument's own driver.
  /// @returns "" when it ended as it should, else the reason
  std::string drive(const std::string& node, const std::string& verb, const std::vector<double>& values = {},
                    double within_s = 60.0);
  std::optional<bool> ask(int row, const std::string& question) const { return ask_(row, question); }
  bool interrupted() const { return interrupted_ && interrupted_(); }
  PortAddress address(const std::string& node) const { return address_(node); }
  bool has(std::string_view node) const;

  const Product& product;
  const Experiment& e;
  std::map<std::string, std::string> identities = {};  ///< with serial numbers, as the instruments told
  /// Of the one pulse that rows 2, 20 and 21 share.
  struct OnePulse {
    std::int64_t triggers = 0;
    double encoder_mm = 0.0, expected_mm = 0.0;
  };
  std::optional<OnePulse> one_pulse = {};

 private:
  Address address_;
  Ask ask_;
  std::function<bool()> interrupted_;
};

/// A row cannot be carried out. The text says why.
class BringupStop : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct BringupRow {
  int id = 0;             ///< of the checklist; 0: the link
  std::string_view node;  ///< "valve_a" stands for both valves
  std::string_view what;
  std::string_view table;  ///< where the assumption stands, which is corrected when it is otherwise
  /// nullptr: a person looks.
  BringupFinding (*check)(BringupLab&, const std::string& node) = nullptr;
  bool (*wanted)(const Experiment&, std::string_view node) = nullptr;  ///< nullptr: always
};

/// Returns a measured number with six significant digits.
std::string number_text(double value);

std::span<const BringupRow> stage_rows();
std::span<const BringupRow> inkjet_rows();  ///< jet, profiler, lamp
std::span<const BringupRow> camera_rows();
std::span<const BringupRow> gas_rows();
std::span<const BringupRow> ice_rows();         ///< robot, valves, laser, heater
std::span<const BringupRow> grbl_rows();        ///< of a stage that is a GRBL board
std::span<const BringupRow> point_scan_rows();  ///< of a point laser that the stage moves
std::span<const BringupRow> python_rows();      ///< of every instrument that a class in Python drives
/// The settings of a jet; nullptr: the node is none.
const drivers::JetConfig* jet_of(const Experiment& experiment, std::string_view node);
/// The link row of every instrument: who answers at its port.
BringupFinding check_link(BringupLab& lab, const std::string& node);

struct BringupResult {
  int id = 0;
  std::string node, what, state;  ///< "ok", "failed", "open" (a person has not looked)
  bool automatic = false;
  std::string measured = {}, limit = {}, mend = {};
  double seconds = 0.0;
  std::string port = {};  ///< at which the row was carried out, port_of()
};

struct BringupState {
  std::string configuration;  ///< SHA-256 of the instruments' keys
  std::map<std::string, std::string> identities;
  std::vector<BringupResult> rows;
};

/// Returns all rows of a lab's instruments, in the order in which they are checked.
struct PlannedRow {
  const BringupRow* row;
  std::string node;
};
std::vector<PlannedRow> planned_rows(const Experiment& experiment);

/// SHA-256 of the keys of the lab's instruments: their tables, caps and offsets.
std::string bringup_configuration(const Experiment& experiment);

/// Returns the port of a node as text, "sim:" of a simulated one; of "all": "real" where any instrument is.
std::string port_of(const Experiment& experiment, const std::string& node);

/// Opens every real port of the lab at this computer once, and closes it again: within 2 s where all answer,
/// at most 4 s. Returns node, address and cause of those that do not open, separated by "; "; empty: all
/// open.
std::string closed_ports(const Experiment& experiment);

/// Asks every real instrument who it is, all at once, and holds it against the bring-up's: another instrument
/// at the same port, or one that does not say, is refused by name. Nothing moves.
/// @param folder of the experiment file, for driver classes in Python
/// @param accepted "all", or NODE:identity @returns why the print may not begin; empty: it may
std::string identity_refusal(const Product& product, const Experiment& experiment,
                             const std::filesystem::path& folder, const BringupState& state,
                             const std::string& file, const std::vector<std::string>& accepted,
                             const std::function<bool()>& interrupted);

/// Carries out one row.
BringupResult carry_out(const PlannedRow& row, BringupLab& lab);

/// Returns, by instrument, the keys that hold assumptions about it: {"stage": [{key, value, mark}, …]}.
nlohmann::ordered_json assumptions_json(const Experiment& experiment, std::span<const std::string> nodes);

/// Returns rows as they stand in the result file and in the command's answer.
nlohmann::ordered_json to_json(std::span<const BringupResult> rows);

/// Returns the state in the text of a result file, or in the JSON that firn bringup prints.
/// @throws std::invalid_argument: it is none
BringupState bringup_state_in(const std::string& text);

/// LAB.bringup.json beside LAB.toml.
std::string bringup_file(const std::string& lab);
/// @throws std::invalid_argument naming the file: damaged
std::optional<BringupState> read_bringup(const std::string& file);
void write_bringup(const std::string& file, const BringupState& state);

/// Why a print on these real ports may not begin; empty: it may. A row counts for the port at which it was
/// carried out: neither a simulation nor another instrument vouches for this one. @param accepted numbers of
/// rows, or "all"
std::string bringup_refusal(const Experiment& experiment, const std::optional<BringupState>& state,
                            const std::string& file, const std::vector<std::string>& accepted);

}  // namespace firn
