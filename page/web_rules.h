// The rules by which the page's server refuses foreign requests: only a page of its own may speak to it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace firn::page {

/// Returns the authorities under which the page is reached: "127.0.0.1:8750", "localhost:8750", "[::1]:8750",
/// the bound address, further names.
std::vector<std::string> own_authorities(const std::string& bind, int port,
                                         const std::vector<std::string>& hosts);

/// Returns true if a Host header names this page. A name that an attacker's DNS points here is refused.
bool host_allowed(std::string_view host, const std::vector<std::string>& own);

/// Returns true if an Origin header is this page's, or absent, as from a program that is no browser.
bool origin_allowed(std::string_view origin, const std::vector<std::string>& own);

/// Says which of the two is not this page's, and how a proxy's name becomes one of its own; empty: both are.
std::string foreign_words(std::string_view host, std::string_view origin,
                          const std::vector<std::string>& own);

/// Returns the parts of "/api/runs/ID/layers/3/measured" with %XX decoded; empty: no such path, or one that
/// leads out of its folder.
std::vector<std::string> path_parts(std::string_view target);

/// Returns the values of a key in "/x?key=A&key=B" with %XX decoded; empty: one that no path may
/// hold.
std::vector<std::string> query_values(std::string_view target, std::string_view key);
/// Returns the first value of a key with %XX decoded, whatever it holds; empty: there is none.
std::string query_text(std::string_view target, std::string_view key);
/// Returns the value of the key "run"; "live": there is none.
std::string run_of(std::string_view target);

/// Returns the words of a header's list, "firn, 0123": what a browser puts into Sec-WebSocket-Protocol.
std::vector<std::string_view> list_words(std::string_view header);

/// Returns the token of "Bearer TOKEN"; empty: the header shows none.
std::string_view bearer_token(std::string_view authorization);
/// Returns the tokens of cookies whose name begins with "firn-"; the page's own has its port there, since
/// cookies are of all ports.
std::vector<std::string_view> cookie_tokens(std::string_view cookies);

}  // namespace firn::page
