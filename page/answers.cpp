#include "page/answers.h"

#include <optional>
#include <stdexcept>

#include "core/options/number.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "page/api_v1.h"
#include "page/bundle.h"
#include "page/client_frame.h"
#include "page/resume.h"
#include "page/view_json.h"
#include "page/web_rules.h"
#include "print/folder/run_report.h"
#include "print/import/imported_run.h"
#include "replay/audit_run.h"
#include "report/run/differing_parameters.h"
#include "report/run/report_page.h"
#include "runs/find/query.h"
#include "runs/folder/config_change.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/running.h"
#include "runs/read/run_reader.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxReported = 6;

WebReply page_of(std::string html) {
  WebReply r;
  r.type = "text/html; charset=utf-8";
  r.body = std::move(html);
  r.report = true;
  return r;
}

WebReply nothing() {
  WebReply r;
  r.status = 204;
  return r;
}

WebReply no_run(const std::string& id) {
  return refusal(
      404, "there is no run '" + id.substr(0, 100) + "', or several have this name: /api/runs has addresses");
}

WebReply give(const WebRequest& request, const Asset& asset) {
  WebReply r;
  r.type = std::string(asset.type);
  r.etag = std::string(asset.etag);
  if (request.if_none_match == asset.etag) {
    r.status = 304;
    return r;
  }
  r.packed = request.gzip;
  r.body = r.packed ? std::string(reinterpret_cast<const char*>(asset.gzip.data()), asset.gzip.size())
                    : plain(asset);
  return r;
}

WebReply exchanges(const fs::path& folder) try {
  runs::RunReader files(folder, {});
  files.poll([](auto...) {});
  WebReply r;
  r.body = exchanges_json(files.take_exchanges());
  return r;
} catch (const std::exception& e) {
  return refusal(500, e.what());
}

WebReply lamp(const std::function<runs::LampSum()>& work) {
  WebReply r;
  r.body = lamp_json(work());
  return r;
}

// As firn report does. The seals are left to it, which also replays and audits.
WebReply report(const Product& product, const std::vector<fs::path>& folders) try {
  std::vector<report::ReportRun> runs;
  std::vector<Experiment> experiments;
  for (const fs::path& folder : folders) {
    runs.push_back({run_data(product, folder), "", ""});
    runs.back().data.provenance.emplace_back("seal", "not looked at by the page; firn report does");
    const std::string file = folder.string() + ": recorded configuration";
    experiments.push_back(parse_recorded_experiment(runs::recorded_config(folder), file));
  }
  return page_of(report::report_page(runs, report::differing_parameters(experiments)));
} catch (const std::exception& e) {
  return refusal(409, std::string("there is no report yet: ") + e.what());
}

// As firn audit does.
WebReply audit(const fs::path& folder) try {
  if (runs::printing_process(folder))
    return refusal(409, "the run is being printed: it can be audited once it is over");
  const runs::RunLock still(folder, runs::RunUse::kRead);
  refuse_imported(folder, "the audit");
  const replay::AuditVerdict verdict = replay::audit_run(folder);
  WebReply r;
  r.body = nlohmann::ordered_json{{"clean", verdict.clean()}, {"text", replay::to_text(verdict)}}.dump(
      -1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return r;
} catch (const std::exception& e) {
  return refusal(409, e.what());
}

// A browser that has the picture as it is gets none; a run without a map has none, which is no error.
WebReply thumbnail(Thumbnails& thumbnails, const fs::path& folder, const std::string& known_tag) try {
  if (runs::printing_process(folder)) return nothing();
  WebReply r;
  r.type = "image/png";
  r.etag = '"' + Thumbnails::last_change(folder) + '"';
  if (known_tag == r.etag) {
    r.status = 304;
    return r;
  }
  r.body = thumbnails.get(folder);
  return r.body.empty() ? nothing() : r;
} catch (const std::exception& e) {
  return refusal(500, e.what());
}

WebReply resumed(const fs::path& program, const fs::path& folder) try {
  if (const std::string why = resume_refusal(folder); !why.empty()) return refusal(409, why);
  const auto pid = resume_detached(program, folder);
  using Json = nlohmann::ordered_json;
  WebReply r;
  r.body = Json{{"ok", true}, {"pid", pid ? Json(*pid) : Json(nullptr)}}.dump();
  return r;
} catch (const std::exception& e) {
  return refusal(409, e.what());
}

std::optional<int> layer_of(const std::string& text) { return whole_number(text, 0, 9'999'999); }

}  // namespace

WebReply refusal(int status, const std::string& why) {
  WebReply r;
  r.status = status;
  r.body = error_frame(why);
  return r;
}

Reader reader_of(const Person& person, const Person& by_header) {
  return {person.name, person.commands, !by_header.commands && (person.commands || person.name.empty())};
}

std::string no_command_words(const Person& person) {
  if (!person.reads || person.name.empty()) return std::string(kNoToken);
  return person.name + " is an observer: only an operator may do this";
}

std::vector<std::pair<std::string, std::string>> safety_headers(const WebReply& reply) {
  return {
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Content-Security-Policy",
       reply.report ? "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
                    : "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
                      "form-action 'none'; frame-ancestors 'none'"}};
}

std::string Answers::wanted_run(const std::vector<std::string>& parts) {
  const bool of_run = parts.size() >= 3 && parts[0] == "api" && parts[1] == "runs";
  return of_run && (parts.size() == 3 || parts[3] == "layers" || parts[3] == "acknowledge") ? parts[2] : "";
}

std::function<WebReply()> Answers::slow_answer(const WebRequest& request,
                                               const std::vector<std::string>& parts) const {
  if (request.method != "GET") return nullptr;
  if (request.target == "/metrics")
    return [work = runs_.list()] {
      WebReply r;
      r.type = "text/plain; version=0.0.4; charset=utf-8";
      r.body = metrics_text(work());
      return r;
    };
  if (parts.size() == 2 && parts[0] == "api" && parts[1] == "runs")
    return [work = runs_.list(query_text(request.target, "where"))] {
      WebReply r;
      try {
        r.body = work();
      } catch (const runs::QueryError& e) {
        // A condition that is not finished yet is no failure of a request.
        r.body = nlohmann::ordered_json{{"runs", nlohmann::ordered_json::array()}, {"error", e.what()}}.dump(
            -1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
      } catch (const std::exception& e) {
        return refusal(500, e.what());
      }
      return r;
    };
  const std::string wanted =
      parts.size() == 4 && parts[0] == "api" && parts[1] == "runs" ? parts[3] : std::string();
  if (wanted == "exchanges" || wanted == "lamp" || wanted == "audit" || wanted == "thumbnail") {
    const auto folder = runs_.find(parts[2]);
    if (!folder) return nullptr;
    if (wanted == "audit") return [at = *folder] { return audit(at); };
    if (wanted == "thumbnail")
      return [kept = thumbnails_, at = *folder, tag = request.if_none_match] {
        return thumbnail(*kept, at, tag);
      };
    if (wanted == "lamp") return [work = runs_.lamp_before(*folder)] { return lamp(work); };
    return [at = *folder] { return exchanges(at); };
  }
  if (!request.target.starts_with("/api/report?")) return nullptr;
  std::vector<fs::path> folders;
  for (const std::string& id : query_values(request.target, "run")) {
    const auto folder = runs_.find(id);
    if (!folder || folders.size() == kMaxReported) return nullptr;
    folders.push_back(*folder);
  }
  if (folders.empty()) return nullptr;
  return [&product = product_, folders] { return report(product, folders); };
}

std::function<WebReply()> Answers::resume(const WebRequest& request,
                                          const std::vector<std::string>& parts) const {
  if (request.method != "POST" || parts.size() != 4 || parts[0] != "api" || parts[1] != "runs" ||
      parts[3] != "resume")
    return nullptr;
  const auto refused = [](int status, const std::string& why) {
    return [=] { return refusal(status, why); };
  };
  if (!request.type.starts_with("application/json"))
    return refused(415, "Content-Type must be application/json");
  try {
    const Person person = commander(request, parse_token(request.body));
    if (!person.commands) return refused(403, no_command_words(person));
  } catch (const std::invalid_argument& e) {
    return refused(400, e.what());
  }
  if (!may_resume())
    return refused(409,
                   "this page is part of a print: firn view, or firn print --resume, resumes another run");
  const auto folder = runs_.find(parts[2]);
  if (!folder) return [id = parts[2]] { return no_run(id); };
  return [program = options_.firn.empty() ? firn_beside() : options_.firn, at = *folder] {
    return resumed(program, at);
  };
}

WebReply Answers::answer(const WebRequest& request, const std::vector<std::string>& parts, double now_s) try {
  if (parts.size() >= 2 && parts[0] == "api") return answer_api(request, parts, now_s);
  if (request.method != "GET" && request.method != "HEAD") return refusal(405, "only GET");
  std::string path;
  for (const std::string& part : parts) path += "/" + part;
  const Asset* asset = find_asset(path == "/" ? "/index.html" : path);
  return asset ? give(request, *asset) : refusal(404, "there is no such page");
} catch (const std::exception& e) {
  return refusal(500, e.what());
}

WebReply Answers::answer_api(const WebRequest& request, const std::vector<std::string>& parts, double now_s) {
  if (parts.size() == 4 && parts[3] == "notes" && request.method == "POST")
    return take_notes(request, parts[2]);
  if (parts.size() == 4 && parts[3] == "acknowledge" && request.method == "POST")
    return acknowledge(request, parts[2]);
  if (request.method != "GET") return refusal(405, "only GET, and POST of notes, acknowledge and resume");
  if (parts[1] != "runs") return refusal(404, "there is no such run");
  WebReply r;
  if (parts.size() == 4 && parts[3] == "report") {
    const auto folder = runs_.find(parts[2]);
    if (!folder || !fs::is_regular_file(RunPaths(*folder).report_path()))
      return refusal(404, "there is no report: firn report RUN writes one");
    return page_of(read_file(RunPaths(*folder).report_path()));
  }
  if (parts.size() == 4 && parts[3] == "events")
    return runs_.find(parts[2]) ? refusal(426, "this is a WebSocket: the request must be an upgrade to it")
                                : no_run(parts[2]);
  const auto run = runs_.opened(parts[2]);
  if (!run && parts[2] == kLiveRun) return nothing();
  if (!run) return no_run(parts[2]);
  if (parts.size() == 3) {
    r.body = run->hello(now_s, runs_.label(run->folder()), may_resume(),
                        reader_of(request.person, request.by_header));
    return r;
  }
  const auto surface = parts.size() == 6 && parts[3] == "layers" ? surface_of(parts[5]) : std::nullopt;
  const auto layer = surface ? layer_of(parts[4]) : std::nullopt;
  if (!layer) return refusal(404, "the run has no such map");
  const auto map = run->map({*surface, *layer});
  if (!map) return nothing();
  r.type = "application/octet-stream";
  r.body.assign(reinterpret_cast<const char*>(map->data()), map->size());
  return r;
}

Person Answers::commander(const WebRequest& request, const std::string& token) const {
  return token.empty() ? request.by_header : access_.of_token(token);
}

WebReply Answers::acknowledge(const WebRequest& request, const std::string& id) try {
  if (!request.type.starts_with("application/json"))
    return refusal(415, "Content-Type must be application/json");
  const auto run = runs_.opened(id);
  if (!run) return no_run(id);
  const AckRequest asked = parse_ack_request(request.body);
  const Person person = commander(request, asked.token);
  if (!person.commands) return refusal(403, no_command_words(person));
  const std::string& author = person.name.empty() ? asked.author : person.name;
  if (author.empty()) return refusal(400, "author: an alarm is acknowledged by name");
  if (!run->has_alarm(asked.alarm)) return refusal(409, "alarm: the run has no such alarm");
  runs::add_notes(run->folder(), {{runs::NoteEntry::Kind::kAck, asked.alarm, author, {}, {}}});
  WebReply r;
  r.body = acknowledged_frame(runs::read_notes(run->folder()));
  return r;
} catch (const UsageError& e) {
  return refusal(400, e.what());
} catch (const std::invalid_argument& e) {
  return refusal(400, e.what());
}

WebReply Answers::take_notes(const WebRequest& request, const std::string& id) try {
  if (!request.type.starts_with("application/json"))
    return refusal(415, "Content-Type must be application/json");
  const NoteRequest asked = parse_note_request(request.body);
  const Person person = commander(request, asked.token);
  if (!person.commands) return refusal(403, no_command_words(person));
  const auto folder = runs_.find(id);
  if (!folder) return no_run(id);
  const std::string& author = person.name.empty() ? asked.author : person.name;
  using Kind = runs::NoteEntry::Kind;
  std::vector<runs::NoteEntry> entries;
  for (const std::string& tag : asked.remove_tags) entries.push_back({Kind::kUntag, tag, author, {}, {}});
  for (const std::string& tag : asked.add_tags) entries.push_back({Kind::kTag, tag, author, {}, {}});
  if (!asked.note.empty()) entries.push_back({Kind::kNote, asked.note, author, {}, {}});
  runs::add_notes(*folder, std::move(entries));
  WebReply r;
  r.body = about_json({}, runs::read_notes(*folder))
               .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return r;
} catch (const UsageError& e) {
  return refusal(400, e.what());
} catch (const std::invalid_argument& e) {
  return refusal(400, e.what());
}

}  // namespace firn::page
