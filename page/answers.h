// Answers gives the page's files, the list of runs, their facts, maps, notes and reports to HTTP requests.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "page/run_set.h"
#include "page/server.h"

namespace firn::page {

struct WebRequest {
  std::string method, target, type, if_none_match, body;
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

class Answers {
 public:
  Answers(const Product& product, const ServerOptions& options, RunSet& runs)
      : product_(product), options_(options), runs_(runs) {}

  /// @param parts of the target; the run that they name has been opened, if there is one
  /// @param now_s of a steady clock
  WebReply answer(const WebRequest& request, const std::vector<std::string>& parts, double now_s);

  /// Returns the run that must be open for the answer; empty: none.
  static std::string wanted_run(const std::vector<std::string>& parts);
  /// Returns the work of an answer that takes seconds, from any thread: the list of runs, a report of
  /// runs, the last exchanges of a run's instruments, the hours of its lamp; nothing: the answer is no such
  /// one.
  std::function<WebReply()> slow_answer(const WebRequest& request,
                                        const std::vector<std::string>& parts) const;

 private:
  WebReply answer_api(const WebRequest& request, const std::vector<std::string>& parts, double now_s);
  WebReply take_notes(const WebRequest& request, const std::string& id);

  const Product& product_;
  const ServerOptions& options_;
  RunSet& runs_;
};

}  // namespace firn::page
