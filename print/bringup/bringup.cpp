#include "print/bringup/bringup.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "config/assumptions.h"
#include "config/device_kinds.h"
#include "config/devices.h"
#include "config/fields.h"
#include "config/labs.h"
#include "drivers/link/driver_event.h"
#include "files/digest.h"
#include "files/json.h"
#include "files/text_file.h"
#include "firn/enums.h"
#include "print/device/device_session.h"
#include "print/device/device_verbs.h"
#include "print/folder/taking_part.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSafeWithin_s = 15.0;
constexpr BringupRow kLink{0, "", "the instrument answers at its port, and is ready", "[devices]"};
constexpr BringupRow kEmergencyStop{
    27, "", "the hardware emergency stop cuts motor and lamp power without software", "wiring"};

std::vector<std::string> instruments(const Experiment& e) {
  std::vector<std::string> names;
  for (const LabProcess& p : lab_of(e).processes)
    if (port_defaults(p.node) && takes_part(e, p.node)) names.emplace_back(p.node);
  return names;
}

}  // namespace

std::string number_text(double value) { return fmt::format("{:.6g}", value); }

bool BringupLab::has(std::string_view node) const {
  const auto all = instruments(e);
  return std::ranges::find(all, node) != all.end();
}

std::unique_ptr<RawLine> BringupLab::line(const std::string& node) const {
  auto line = std::make_unique<RawLine>(address_(node));
  if (!line->is_open()) throw BringupStop("the port of " + node + " does not open: " + line->trouble());
  return line;
}

std::string BringupLab::drive(const std::string& node, const std::string& verb,
                              const std::vector<double>& values, double within_s) {
  const DeviceVerb& v = device_verb(node, verb);
  Experiment own = e;
  if (v.asks) own.stage.home_at_start = OnOff::kOff;
  std::string said;
  DeviceSession::Sinks sinks;
  sinks.note = [&](const std::string& text) { said = text; };
  const auto makers = taking_part(product, e);
  const auto maker =
      std::ranges::find_if(makers, [&](const NamedMaker& m) { return info(m.id).name == node; });
  if (maker == makers.end()) return "the lab has no " + node;
  DeviceSession session(maker->id, maker->make(dump(own), {}), address_(node), sinks);
  const auto stopped = [this] { return interrupted(); };
  if (!session.run_until([&] { return session.safe(); }, v.asks ? kSafeWithin_s : within_s, stopped)) {
    session.stop("bring-up");
    return said.empty() ? "it does not become safe" : said;
  }
  std::string why;
  if (v.order) {
    const DeviceCall call{own, node, verb, values};
    session.command([&](const OrderStamp& stamp) { return v.order(call, stamp); }, verb);
    if (!session.run_until([&] { return session.answer().has_value(); }, within_s, stopped))
      why = "it is not over in " + std::to_string(int(within_s)) + " s";
    else if (Outcome(session.answer()->outcome) != Outcome::kDone)
      why = std::string(drivers::name(Outcome(session.answer()->outcome))) + ": " + session.answer()->text;
    else if (verb == "serial")
      identities[node] = session.answer()->text;
  }
  if (!session.stop("bring-up") && why.empty()) why = "it did not confirm that it is safe";
  return why;
}

std::vector<PlannedRow> planned_rows(const Experiment& e) {
  std::vector<PlannedRow> all;
  const auto names = instruments(e);
  for (const std::string& node : names) all.push_back({&kLink, node});
  for (const auto rows : {stage_rows(), inkjet_rows(), camera_rows(), gas_rows(), ice_rows()})
    for (const BringupRow& row : rows)
      for (const std::string& node : names)
        if ((node == row.node || (row.node == "valve_a" && node == "valve_b") ||
             (row.node == "jet" && node == "jet_b")) &&
            !is_python_driver(e, node) && !(node == "stage" && has_grbl_stage(e)) &&
            !(node == "laser_profiler" && has_point_scan(e)) && (!row.wanted || row.wanted(e, node)))
          all.push_back({&row, node});
  if (has_grbl_stage(e) && std::ranges::find(names, "stage") != names.end())
    for (const BringupRow& row : grbl_rows())
      if (!row.wanted || row.wanted(e, "stage")) all.push_back({&row, "stage"});
  if (has_point_scan(e) && std::ranges::find(names, "laser_profiler") != names.end())
    for (const BringupRow& row : point_scan_rows()) all.push_back({&row, "laser_profiler"});
  for (const BringupRow& row : python_rows())  // of the class, not of a maker's protocol
    for (const std::string& node : names)
      if (is_python_driver(e, node) && (!row.wanted || row.wanted(e, node))) all.push_back({&row, node});
  all.push_back({&kEmergencyStop, "all"});
  return all;
}

std::string port_of(const Experiment& e, const std::string& node) {
  if (node == "all") return real_ports(e).empty() ? "sim:" : "real";
  const auto outside = outside_ports(e);
  const auto at = outside.find(node);
  return at == outside.end() ? "sim:" : to_text(at->second);
}

BringupResult carry_out(const PlannedRow& planned, BringupLab& lab) {
  const BringupRow& row = *planned.row;
  BringupResult r{row.id, planned.node, std::string(row.what), "open", row.id == 0 || row.check != nullptr};
  r.port = port_of(lab.e, planned.node);
  const std::int64_t begin = monotonic_us();
  if (!r.automatic) {
    const auto answer = lab.ask(row.id, r.what + ": is it so?");
    if (answer) r.state = *answer ? "ok" : "failed";
    r.measured = answer ? *answer ? "seen by a person" : "not so" : "";
    r.mend = "stands at: " + std::string(row.table);
    return r;
  }
  try {
    const BringupFinding f = row.id == 0 ? check_link(lab, planned.node) : row.check(lab, planned.node);
    r.state = f.ok ? "ok" : f.mend == "needs a person" ? "open" : "failed";
    r.measured = f.measured;
    r.limit = f.limit;
    if (!f.ok) r.mend = f.mend;
    if (row.id == 0 && f.ok && !is_python_driver(lab.e, planned.node)) lab.drive(planned.node, "serial");
  } catch (const BringupStop& stop) {
    r.state = "failed";
    r.measured = stop.what();
    r.mend = "mend this first, then run the row again";
  }
  r.seconds = double(monotonic_us() - begin) * 1e-6;
  return r;
}

std::string bringup_configuration(const Experiment& experiment) {
  Experiment e = experiment;
  const auto names = instruments(e);
  std::string text;
  for (const Field& f : fields(e)) {
    const std::string section = f.key.substr(0, f.key.find('.'));
    const bool dialect = std::ranges::any_of(
        names, [&](const std::string& node) { return f.section() == "devices." + node + ".dialect"; });
    const bool kind = std::ranges::any_of(
        names, [&](const std::string& node) { return f.key == "devices." + node + ".kind"; });
    if (kind && device_kind(e, f.section().substr(std::string_view("devices.").size())).empty()) continue;
    if (dialect || kind || std::ranges::find(names, section) != names.end())
      text += f.key + " = " + value_text(f) + "\n";
  }
  return sha256_hex(bytes_of(text));
}

std::string bringup_file(const std::string& lab) {
  return std::filesystem::path(lab).replace_extension(".bringup.json").string();
}

BringupState bringup_state_in(const std::string& text) try {
  const Json j = Json::parse(text);
  BringupState s;
  s.configuration = j.at("configuration").get<std::string>();
  for (const auto& [node, identity] : j.at("identities").items())
    s.identities[node] = identity.get<std::string>();
  for (const Json& row : j.at("rows")) {
    BringupResult r;
    r.id = row.at("row").get<int>();
    r.node = row.at("node").get<std::string>();
    r.what = row.at("what").get<std::string>();
    r.state = row.at("state").get<std::string>();
    r.automatic = row.at("automatic").get<bool>();
    r.measured = row.at("measured").get<std::string>();
    r.limit = row.at("limit").get<std::string>();
    r.mend = row.at("mend").get<std::string>();
    r.seconds = row.at("seconds").get<double>();
    r.port = row.at("port").get<std::string>();
    s.rows.push_back(std::move(r));
  }
  return s;
} catch (const Json::exception& e) {
  throw std::invalid_argument(std::string("is no bring-up result: ") + e.what());
}

std::optional<BringupState> read_bringup(const std::string& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    return bringup_state_in(read_file(file));
  } catch (const std::invalid_argument& e) {
    throw std::invalid_argument(file + ": " + e.what());
  }
}

nlohmann::ordered_json to_json(std::span<const BringupResult> results) {
  Json rows = Json::array();
  for (const BringupResult& r : results)
    rows.push_back({{"row", r.id},
                    {"node", r.node},
                    {"what", r.what},
                    {"state", r.state},
                    {"automatic", r.automatic},
                    {"measured", r.measured},
                    {"limit", r.limit},
                    {"mend", r.mend},
                    {"seconds", r.seconds},
                    {"port", r.port}});
  return rows;
}

nlohmann::ordered_json assumptions_json(const Experiment& e, std::span<const std::string> nodes) {
  Json all = Json::object();
  for (const std::string& node : nodes)
    for (const Assumption& a : assumptions(e, node))
      all[node].push_back({{"key", a.key}, {"value", a.value}, {"mark", std::string(1, a.mark)}});
  return all;
}

void write_bringup(const std::string& file, const BringupState& s) {
  const Json j{{"configuration", s.configuration}, {"identities", s.identities}, {"rows", to_json(s.rows)}};
  write_file_atomically(file, j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::string bringup_refusal(const Experiment& e, const std::optional<BringupState>& state,
                            const std::string& file, const std::vector<std::string>& accepted) {
  const auto real = real_ports(e);
  const auto accepts = [&](const std::string& what) {
    return std::ranges::any_of(accepted, [&](const std::string& a) { return a == "all" || a == what; });
  };
  if (real.empty() || accepts("all")) return {};
  const std::string how = "; run ./firn bringup LAB, or take the risk with --accept-bringup all";
  if (!state) return file + " is missing: the real instruments of this lab have not been brought up" + how;
  if (state->configuration != bringup_configuration(e) && !accepts("configuration"))
    return file + " was made with other settings of the instruments" + how;
  std::string missing;
  int count = 0;
  for (const PlannedRow& planned : planned_rows(e)) {
    if (!real.contains(planned.node) && planned.node != "all") continue;
    const std::string port = port_of(e, planned.node);
    const auto at = std::ranges::find_if(state->rows, [&](const BringupResult& r) {
      return r.id == planned.row->id && r.node == planned.node && r.port == port;
    });
    const std::string id = std::to_string(planned.row->id);
    if ((at != state->rows.end() && at->state == "ok") || accepts(id) || accepts(planned.node + ":" + id))
      continue;
    if (++count <= 5)
      missing += (missing.empty() ? "" : ", ") + planned.node + ":" + id + " (" +
                 std::string(at == state->rows.end() ? "not carried out" : at->state) + ")";
  }
  if (count == 0) return {};
  return file + ": " + std::to_string(count) + (count == 1 ? " row is" : " rows are") +
         " not done: " + missing + (count > 5 ? ", …" : "") +
         "; run ./firn bringup LAB, or take each risk with --accept-bringup NODE:ROW";
}

}  // namespace firn
