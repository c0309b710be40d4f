#include "runs/bundle/crate.h"

#include <algorithm>
#include <array>
#include <set>

#include "config/labs.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "runs/bundle/bundle.h"
#include "runs/folder/documents.h"
#include "runs/folder/list.h"
#include "runs/folder/seal_check.h"
#include "runs/folder/verdict.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;
using CrateJson = nlohmann::ordered_json;

struct Format {
  std::string_view ending, type;
};
constexpr std::array kFormats{Format{".json", "application/json"}, Format{".jsonl", "application/jsonl"},
                              Format{".toml", "application/toml"}, Format{".csv", "text/csv"},
                              Format{".html", "text/html"},        Format{".seal", "text/plain"},
                              Format{".diff", "text/x-diff"},      Format{".out", "text/plain"},
                              Format{".npy", "application/x-npy"}, Format{".png", "image/png"},
                              Format{".jpg", "image/jpeg"},        Format{".h5", "application/x-hdf5"}};

std::string_view format_of(const std::string& path) {
  const auto at = std::ranges::find_if(kFormats, [&](const Format& f) { return path.ends_with(f.ending); });
  return at == kFormats.end() ? "application/octet-stream" : at->type;
}

std::string_view described(const std::string& path) {
  if (path == RunPaths::kExperiment) return "The experiment with every key resolved.";
  if (path == RunPaths::kProvenance)
    return "Program, platform, fingerprint of results, inputs, what was printed.";
  if (path == RunPaths::kResult) return "End, verdict and errors of the last map.";
  if (path == RunPaths::kNotes) return "Notes and tags, a line of JSON each.";
  if (path == RunPaths::kMetrics) return "Errors, volume and time of each layer.";
  if (path == RunPaths::kReport) return "The report, one page.";
  if (path == RunPaths::kSourcesDiff) return "Difference of the program's sources from its commit.";
  if (path.starts_with(RunPaths::kLog)) return "Every message of the print: an LCM log, or its index.";
  if (path.starts_with(RunPaths::kSeals)) return "Length and SHA-256 of every file at one moment.";
  if (path.starts_with(RunPaths::kInputs)) return "An input of the print, named by its SHA-256.";
  if (RunPaths::is_wal(path)) return "Write-ahead file of a node: what it received and what it sent.";
  return "";
}

CrateJson reference(const std::string& id) { return {{"@id", id}}; }

class Graph {
 public:
  void add(CrateJson entity) {
    if (ids_.insert(entity.at("@id").get<std::string>()).second) graph_.push_back(std::move(entity));
  }
  CrateJson take() { return std::move(graph_); }

 private:
  CrateJson graph_ = CrateJson::array();
  std::set<std::string> ids_;
};

std::string person(Graph& graph, const std::string& name) {
  const std::string id = "#person-" + uri_path(name);
  graph.add({{"@id", id}, {"@type", "Person"}, {"name", name}});
  return id;
}

// The program that printed, with all that decides its results.
std::string program(Graph& graph, const ProvenanceDocument& p) {
  const std::string commit = p.text("commit"), id = "#firn-" + uri_path(commit);
  CrateJson values = CrateJson::array();
  for (const auto& [key, name] :
       {std::pair("sources", "SHA-256 of sources and compiler flags"),
        std::pair("platform", "libraries and processor"), std::pair("kernel", "kernel")})
    if (const std::string value = p.text(key); !value.empty()) {
      const std::string of = id + "-" + key;
      graph.add(
          {{"@id", of}, {"@type", "PropertyValue"}, {"propertyID", key}, {"name", name}, {"value", value}});
      values.push_back(reference(of));
    }
  if (!p.results.empty()) {
    const std::string of = id + "-results";
    graph.add({{"@id", of},
               {"@type", "PropertyValue"},
               {"propertyID", "results"},
               {"name", "fingerprint of results: digest of each library function's values"},
               {"value", CrateJson(fingerprint_texts(p.results)).dump()}});
    values.push_back(reference(of));
  }
  graph.add({{"@id", id},
             {"@type", "SoftwareApplication"},
             {"name", "Firn"},
             {"softwareVersion", p.text("version").empty() ? commit : p.text("version")},
             {"identifier", commit},
             {"additionalProperty", values}});
  return id;
}

CrateJson property(Graph& graph, const std::string& run, const std::string& key, CrateJson value,
                   const char* unit) {
  const std::string id = "#" + uri_path(run) + "-" + key;
  CrateJson entity{{"@id", id},
                   {"@type", "PropertyValue"},
                   {"propertyID", key},
                   {"name", key},
                   {"value", std::move(value)}};
  if (*unit) entity["unitText"] = unit;
  graph.add(std::move(entity));
  return reference(id);
}

CrateJson values_of(Graph& graph, const std::string& run, const RunEntry& e) {
  CrateJson values = CrateJson::array();
  const auto add = [&](const std::string& key, CrateJson value, const char* unit = "") {
    values.push_back(property(graph, run, key, std::move(value), unit));
  };
  for (const MetaEntry& m : e.meta.values)
    std::visit([&](const auto& value) { add("meta." + m.key, value); }, m.value);
  add("lab", e.lab);
  add("scheme", e.scheme);
  add("outcome", e.outcome);
  if (!e.result) return values;
  add("layers", e.result->layers);
  if (e.result->error) {
    add("rms_um", e.result->error->rms_um, "um");
    add("mean_um", e.result->error->mean_um, "um");
  }
  if (e.result->overspill_percent) add("overspill_percent", *e.result->overspill_percent, "%");
  return values;
}

std::string description(const RunEntry& e) {
  if (!e.result) return e.outcome;
  const std::string verdict = verdict_words(*e.result, lab_words(e.lab));
  const std::string part = e.result->part ? part_words(*e.result->part) + "; " : "";
  return part + (verdict.empty() ? end_words(*e.result) : verdict);
}

void add_run(Graph& graph, const CrateRun& run) {
  const std::string id = "./" + uri_path(run.name) + "/";
  const ProvenanceDocument p = parse_provenance(read_file(RunPaths(run.folder).provenance_path()),
                                                RunPaths(run.folder).provenance_path().string());
  const RunEntry e = run_entry(run.folder);
  CrateJson parts = CrateJson::array(), comments = CrateJson::array();
  for (const CrateFile& f : run.files) parts.push_back(reference(id + uri_path(f.path)));
  int number = 0;
  for (const NoteEntry& n : e.notes.notes()) {
    const std::string of = "#" + uri_path(run.name) + "-note-" + std::to_string(++number);
    CrateJson comment{{"@id", of}, {"@type", "Comment"}, {"text", n.text}};
    if (!n.time_utc.empty()) comment["dateCreated"] = n.time_utc;
    if (!n.author.empty()) comment["author"] = reference(person(graph, n.author));
    graph.add(std::move(comment));
    comments.push_back(reference(of));
  }
  CrateJson dataset{{"@id", id},
                    {"@type", "Dataset"},
                    {"name", run.name},
                    {"identifier", p.text("run_id")},
                    {"description", description(e)},
                    {"dateCreated", p.text("started_utc")},
                    {"hasPart", parts},
                    {"variableMeasured", values_of(graph, run.name, e)}};
  const std::string who = meta_text(e.meta.values, "operator");
  if (!who.empty()) dataset["author"] = reference(person(graph, who));
  std::string tags;
  for (const std::string& tag : e.notes.tags()) tags += (tags.empty() ? "" : ",") + tag;
  if (!tags.empty()) dataset["keywords"] = tags;
  if (!comments.empty()) dataset["comment"] = comments;
  graph.add(std::move(dataset));
  CrateJson print{{"@id", "#print-" + uri_path(run.name)},
                  {"@type", "CreateAction"},
                  {"name", "print of " + run.name},
                  {"startTime", p.text("started_utc")},
                  {"instrument", reference(program(graph, p))},
                  {"result", reference(id)}};
  if (!who.empty()) print["agent"] = reference(person(graph, who));
  graph.add(std::move(print));
  for (const CrateFile& f : run.files) {
    CrateJson file{{"@id", id + uri_path(f.path)},
                   {"@type", "File"},
                   {"name", fs::path(f.path).filename().string()},
                   {"encodingFormat", format_of(f.path)},
                   {"contentSize", std::to_string(f.bytes)},
                   {"sha256", f.sha256}};
    if (const auto text = described(f.path); !text.empty()) file["description"] = text;
    graph.add(std::move(file));
  }
}

}  // namespace

std::string uri_path(std::string_view path) {
  constexpr std::string_view kHex = "0123456789ABCDEF", kPlain = "-._~/";
  std::string out;
  for (const char c : path) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    const auto byte = static_cast<unsigned char>(c);
    if (letter || kPlain.find(c) != kPlain.npos)
      out += c;
    else
      out += {'%', kHex[byte >> 4], kHex[byte & 15]};
  }
  return out;
}

std::string crate_metadata(const std::string& name, const std::vector<CrateRun>& runs,
                           const std::string& created_utc, const std::string& license) {
  Graph graph;
  CrateJson parts = CrateJson::array();
  for (const CrateRun& run : runs) parts.push_back(reference("./" + uri_path(run.name) + "/"));
  graph.add({{"@id", kCrateMetadata},
             {"@type", "CreativeWork"},
             {"about", reference("./")},
             {"conformsTo", reference("https://w3id.org/ro/crate/1.1")},
             {"dateCreated", created_utc},
             {"sdPublisher", reference("#firn")}});
  graph.add({{"@id", "#firn"}, {"@type", "Organization"}, {"name", "Firn"}});
  graph.add({{"@id", "./"},
             {"@type", "Dataset"},
             {"name", name},
             {"description",
              "Prints recorded by Firn: each with its configuration, its records, its result and its seals. "
              "firn repro checks, replays and prints them again."},
             {"datePublished", created_utc.substr(0, 10)},
             {"license", license.empty() ? "not stated" : license},
             {"hasPart", parts}});
  for (const CrateRun& run : runs) add_run(graph, run);
  return CrateJson{{"@context", "https://w3id.org/ro/crate/1.1/context"}, {"@graph", graph.take()}}.dump(
             2, ' ', false, CrateJson::error_handler_t::replace) +
         "\n";
}

}  // namespace firn::runs
