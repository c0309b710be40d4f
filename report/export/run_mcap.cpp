#include "report/export/run_mcap.h"

#include <array>
#include <set>
#include <utility>
#include <vector>

#include "files/record/output_target.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "report/export/foxglove.h"
#include "report/export/member_texts.h"
#include "runs/read/run_log.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using schema::Kind;
using schema::Type;

const Type* nested(const schema::Member& m) { return Schema::builtin().find(m.type); }

// The JSON schema of a message as to_json() writes it.
std::string json_schema(const Type& type) {
  std::string properties;
  for (const schema::Member& m : type.members) {
    const MemberText about = member_text(type.name, m.name);
    std::string one;
    if (m.kind == Kind::kStruct) {
      const Type* inner = nested(m);
      one = inner ? json_schema(*inner) : "{\"type\":\"object\"}";
    } else {
      const char* name = m.kind == Kind::kString                             ? "string"
                         : m.kind == Kind::kFloat || m.kind == Kind::kDouble ? "number"
                                                                             : "integer";
      one =
          std::string("{\"type\":\"") + name + "\"" +
          (about.text.empty() || !m.dimensions.empty() ? "" : ",\"description\":" + json_string(about.text)) +
          "}";
    }
    if (!m.dimensions.empty()) {
      one = "{\"type\":\"array\",\"items\":" + one;
      one += (about.text.empty() ? "" : ",\"description\":" + json_string(about.text)) + "}";
    }
    properties += (properties.empty() ? "" : ",") + json_string(m.name) + ":" + one;
  }
  return "{\"title\":" + json_string(type.package + "." + type.name) +
         ",\"description\":" + json_string(type_text(type.name)) + ",\"type\":\"object\",\"properties\":{" +
         properties + "}}";
}

// The .lcm text of a type and of those that it holds.
void add_text(const Type& type, std::set<std::string>& done, std::string& text) {
  if (!done.insert(type.name).second) return;
  std::string own = "struct " + type.name + " {\n";
  for (const schema::Member& m : type.members) {
    if (m.kind == Kind::kStruct)
      if (const Type* inner = nested(m)) add_text(*inner, done, text);
    own += "  " + m.type + " " + m.name;
    for (const schema::Dimension& d : m.dimensions) own += "[" + d.text + "]";
    own += ";\n";
  }
  text += own + "}\n";
}

std::string lcm_text(const Type& type) {
  std::set<std::string> done;
  std::string text;
  add_text(type, done, text);
  return "package " + type.package + ";\n" + text;
}

}  // namespace

McapExport::McapExport(const fs::path& file)
    : target_(record::output_target(file)), part_(target_.string() + ".part"), writer_(part_.path()) {}

McapExport::~McapExport() {
  if (!finished_) part_.remove();
}

std::uint64_t McapExport::add(const fs::path& run, const std::string& prefix,
                              const std::function<void(double)>& progress) {
  const runs::RunTexts texts = runs::read_texts(run);
  writer_.attachment(prefix + RunPaths::kExperiment, "application/toml", texts.experiment_toml);
  writer_.attachment(prefix + RunPaths::kProvenance, "application/json", texts.provenance_json);
  writer_.attachment(prefix + RunPaths::kResult, "application/json", texts.result_json);
  const fs::path notes = RunPaths(run).notes_path();
  if (fs::exists(notes)) writer_.attachment(prefix + RunPaths::kNotes, "application/jsonl", read_file(notes));
  std::map<std::int64_t, std::array<std::uint16_t, 2>> schemas;  // by fingerprint: JSON, LCM
  std::map<std::pair<std::string, std::int64_t>, std::array<std::uint16_t, 2>> topics;
  std::vector<FieldPlace> places;
  std::optional<FoxgloveLog> last_stop;  // a safe stop is repeated until all instruments are safe
  const auto use = [&](const record::Event& e, const Type& type) {
    places.resize(type.fields.size());
    if (const auto error = check(type, e.data, places))
      throw runs::bad_message(
          run, e, error->path + ": byte " + std::to_string(error->offset) + ": " + error->message);
    if (!schemas.contains(type.fingerprint)) {
      const std::string name = type.package + "." + type.name;
      schemas[type.fingerprint] = {writer_.add_schema(name, "jsonschema", json_schema(type)),
                                   writer_.add_schema(name, "lcm", lcm_text(type))};
    }
    const auto key = std::pair(std::string(e.channel), type.fingerprint);
    if (!topics.contains(key)) {
      const ChannelInfo* info = find_channel(e.channel);
      const std::map<std::string, std::string> about{{"meaning", info ? std::string(info->meaning) : ""}};
      const auto& of = schemas[type.fingerprint];
      topics[key] = {writer_.add_channel(of[0], "/" + prefix + key.first, "json", about),
                     writer_.add_channel(of[1], "/" + prefix + "lcm/" + key.first, "lcm", about)};
    }
    const auto& [json, lcm] = topics[key];
    const auto time_ns = std::uint64_t(std::max<std::int64_t>(e.utime_us, 0)) * 1000;
    writer_.message(json, std::uint32_t(e.eventnum), time_ns, to_json(type, e.data, {0, true}));
    writer_.message(lcm, std::uint32_t(e.eventnum), time_ns,
                    {reinterpret_cast<const char*>(e.data.data()), e.data.size()});
    if (const auto grid = foxglove_grid(type, e.data, places, time_ns))
      known(kFoxgloveGrid, prefix + "foxglove/" + std::string(e.channel), e, time_ns, *grid);
    const auto log = foxglove_log(type, e.data);
    if (!log || (type.name == "safe_stop_t" && std::exchange(last_stop, log) == log)) return;
    known(kFoxgloveLog, prefix + "foxglove/LOG", e, time_ns, log_json(*log, time_ns));
  };
  return runs::each_message(run, use, progress);
}

void McapExport::known(std::string_view schema, const std::string& topic, const record::Event& e,
                       std::uint64_t time_ns, const std::string& json) {
  const std::string name(schema);
  if (!known_schemas_.contains(name))
    known_schemas_[name] = writer_.add_schema(name, "jsonschema", foxglove_schema(schema));
  if (!known_topics_.contains(topic))
    known_topics_[topic] = writer_.add_channel(known_schemas_[name], "/" + topic, "json", {});
  writer_.message(known_topics_[topic], std::uint32_t(e.eventnum), time_ns, json);
}

void McapExport::finish() {
  writer_.close();
  std::error_code error;
  fs::rename(part_.path(), target_, error);
  if (error) throw WriteError(target_.string() + ": " + error.message());
  finished_ = true;
}

}  // namespace firn::report
