// Answers gives the page's files, the list of runs, their facts, maps, small pictures, notes, reports and
// audits to HTTP requests, and resumes a run for one.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "page/access.h"
#include "page/run_set.h"
#include "page/server.h"
#include "page/thumbnail.h"
#include "page/thumbnails.h"
#include "page/view_json.h"

namespace firn::page {

struct WebRequest {
  std::string method, target, type, if_none_match, body;
  Person person;      ///< whose it is
  Person by_header;   ///< the same without cookies, for requests that change something
  bool gzip = false;  ///< the browser unpacks it
};

struct WebReply {
  int status = 200;
  std::string type = "application/json", body;
  std::string etag;     ///< not empty: the browser may keep the body and ask by this tag
  bool packed = false;  ///< the body is gzip
  bool report = false;  ///< a page of its own, with styles inside, that may run nothing
};

/// Returns names and values of the headers that keep foreign content out of a reply.
std::vector<std::pair<std::string, std::string>> safety_headers(const WebReply& reply);

inline constexpr std::string_view kNoToken =
    "the token is missing or wrong: it stands in the address that the terminal shows";

WebReply refusal(int status, const std::string& why);

/// Returns the reader as a frame tells of him.
Reader reader_of(const Person& person, const Person& by_header);
/// Returns why somebody may not command: he has no token, or is an observer.
std::string no_command_words(const Person& person);

class Answers {
 public:
  Answers(const Product& product, const ServerOptions& options, RunSet& runs, Access& access)
      : product_(product),
        options_(options),
        runs_(runs),
        access_(access),
        thumbnails_(std::make_shared<Thumbnails>(
            [&product](const std::filesystem::path& run) { return thumbnail_png(product, run); })) {}

  /// @param parts of the target; the run that they name has been opened, if there is one
  /// @param now_s of a steady clock
  WebReply answer(const WebRequest& request, const std::vector<std::string>& parts, double now_s);

  /// Returns the run that must be open for the answer; empty: none.
  static std::string wanted_run(const std::vector<std::string>& parts);
  /// Returns the work of an answer that takes seconds, from any thread: the list of runs, a report of
  /// runs, the last exchanges of a run's instruments, the hours of its lamp, its audit, its small picture;
  /// nothing: the answer is no such one.
  std::function<WebReply()> slow_answer(const WebRequest& request,
                                        const std::vector<std::string>& parts) const;
  /// Returns the work of a request to resume a run, which starts a process with the calling thread's
  /// priority; nothing: the request is no such one.
  std::function<WebReply()> resume(const WebRequest& request, const std::vector<std::string>& parts) const;
  /// Returns true if this page may resume runs: somebody may command, and it is not part of a print.
  bool may_resume() const { return options_.live.empty() && access_.has_commands(); }

 private:
  WebReply answer_api(const WebRequest& request, const std::vector<std::string>& parts, double now_s);
  WebReply take_notes(const WebRequest& request, const std::string& id);
  WebReply acknowledge(const WebRequest& request, const std::string& id);
  Person commander(const WebRequest& request, const std::string& token) const;

  const Product& product_;
  const ServerOptions& options_;
  RunSet& runs_;
  Access& access_;
  std::shared_ptr<Thumbnails> thumbnails_;
};

}  // namespace firn::page
