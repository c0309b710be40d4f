// Version 1 of the interface for programs: the requests below /api/v1 that docs/openapi.json describes and
// that later versions keep. The page's own requests, without a version, may change with the page.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace firn::page {

struct ApiRoute {
  std::string_view method, path;  ///< {run} and the like stand for any word
};
inline constexpr std::array kApiV1{
    ApiRoute{"GET", "/api/v1/runs"},
    ApiRoute{"GET", "/api/v1/runs/{run}"},
    ApiRoute{"GET", "/api/v1/runs/{run}/audit"},
    ApiRoute{"GET", "/api/v1/runs/{run}/exchanges"},
    ApiRoute{"GET", "/api/v1/runs/{run}/lamp"},
    ApiRoute{"GET", "/api/v1/runs/{run}/thumbnail"},
    ApiRoute{"GET", "/api/v1/runs/{run}/layers/{layer}/{surface}"},
    ApiRoute{"GET", "/api/v1/runs/{run}/events"},
    ApiRoute{"POST", "/api/v1/runs/{run}/acknowledge"},
    ApiRoute{"POST", "/api/v1/runs/{run}/resume"},
};

/// Returns the target of the page's own request that a request of version 1 stands for; any other target as
/// it is; nothing for a request below /api/v1 that is none of the above.
std::optional<std::string> without_version(std::string_view method, std::string_view target);

/// Returns true for "/ws?run=RUN" and for "/api/v1/runs/RUN/events", which is the same for programs.
bool is_websocket_target(std::string_view target);
/// Returns the run that such a target names; "live": it names none.
std::string websocket_run(std::string_view target);

/// Returns numbers of the runs in the list as Prometheus reads them (text exposition format 0.0.4): runs by
/// outcome; of each print that goes on its layer and its last RMS error.
/// @param list {"runs": [...]} of RunSet::list()
std::string metrics_text(const std::string& list);

}  // namespace firn::page
