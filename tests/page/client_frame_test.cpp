#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "page/client_frame.h"
#include "page/web_rules.h"

using namespace firn;
using namespace firn::page;
using Catch::Contains;

TEST_CASE("each command of the page is an order of firn ctl") {
  const std::pair<std::string, std::string> words[] = {{"pause", "pause"},
                                                       {"continue", "continue"},
                                                       {"stop_after_layer", "finish-layer"},
                                                       {"safe_stop", "stop"},
                                                       {"accept_doubt", "accept-doubt"}};
  for (const auto& [command, word] : words) {
    const auto f =
        parse_client_frame(R"({"type":"command","id":7,"token":"t","command":")" + command + "\"}");
    CHECK(f.kind == ClientFrame::Kind::kCommand);
    CHECK(f.id == 7);
    CHECK(f.token == "t");
    CHECK(f.words == std::vector{word});
  }
  const auto set = parse_client_frame(
      R"({"type":"command","id":1,"command":"set","key":"control.max_layers","value":"40"})");
  CHECK(set.words == std::vector<std::string>{"set", "control.max_layers=40"});
  CHECK(set.token.empty());
}

TEST_CASE("a frame follows a surface, asks for one layer, or ends the maps") {
  const auto newest = parse_client_frame(R"({"type":"follow","surface":"error"})");
  CHECK(newest.surface == Surface::kError);
  CHECK_FALSE(newest.layer);
  const auto one = parse_client_frame(R"({"type":"follow","surface":"truth","layer":12})");
  CHECK(one.surface == Surface::kTruth);
  CHECK(one.layer == 12);
  CHECK_FALSE(parse_client_frame(R"({"type":"follow","surface":null})").surface);
}

TEST_CASE("a frame that is no request of the page is refused by its member") {
  const std::pair<const char*, const char*> bad[] = {
      {"", "JSON object"},
      {"[]", "JSON object"},
      {"{", "JSON object"},
      {R"({"type":"dance"})", "type"},
      {R"({"type":7})", "type"},
      {R"({"type":"ping","id":-1})", "id"},
      {R"({"type":"ping","id":1.5})", "id"},
      {R"({"type":"ping","id":18446744073709551615})", "id"},
      {R"({"type":"follow","surface":"sky"})", "surface"},
      {R"({"type":"follow","surface":"error","layer":1e9})", "layer"},
      {R"({"type":"command","id":1,"command":"format"})", "command"},
      {R"({"type":"command","id":1,"command":"set","key":"a"})", "value"},
      {R"({"type":"command","id":1,"command":"set","key":"a=b","value":"1"})", "key"},
      {R"({"type":"command","id":1,"command":"set","key":"a","value":"1\n2 stop"})", "one line"},
      {R"({"type":"command","id":1,"command":"pause","token":{}})", "token"},
      {R"({"a":[[[[[[[[1]]]]]]]]})", "nested"},
  };
  for (const auto& [text, word] : bad) {
    INFO(text);
    CHECK_THROWS_WITH(parse_client_frame(text), Contains(word));
  }
  CHECK_THROWS_WITH(parse_client_frame(std::string(kMaxFrameBytes + 1, ' ')), Contains("at most 4096"));
}

TEST_CASE("random bytes and random damage of frames are read or refused, and nothing else") {
  RandomStream random(11, Purpose::kTest);
  const std::string whole =
      R"({"type":"command","id":3,"token":"abc","command":"set","key":"control.smf.kp","value":"1.5"})";
  int read = 0;
  for (int n = 0; n < 20000; ++n) {
    std::string text = whole;
    for (std::uint64_t k = random.below(4); k > 0; --k)
      text[random.below(text.size())] = char(random.below(256));
    try {
      parse_client_frame(text);
      ++read;
    } catch (const std::invalid_argument&) {
    }
  }
  CHECK(read > 4000);  // those without damage, at least
}

TEST_CASE("a browser's additions to notes and tags are read, and limited") {
  const NoteRequest read = parse_note_request(
      "{\"token\":\"t\",\"author\":\"Ada\",\"note\":\"one\\ntwo\",\"add_tags\":[\"H\xc3\xb6he\"],\"remove_"
      "tags\":[\"a\",\"b\"]}");
  CHECK(read.token == "t");
  CHECK(read.author == "Ada");
  CHECK(read.note == "one\ntwo");
  CHECK(read.add_tags == std::vector<std::string>{"H\xc3\xb6he"});
  CHECK(read.remove_tags == std::vector<std::string>{"a", "b"});
  CHECK(parse_note_request("{}").note.empty());
  CHECK_THROWS_WITH(parse_note_request(R"({"add_tags":[1]})"), Contains("add_tags"));
  CHECK_THROWS_WITH(parse_note_request(R"({"remove_tags":"x"})"), Contains("remove_tags"));
  CHECK_THROWS_WITH(parse_note_request(R"({"note":5})"), Contains("note"));
  CHECK_THROWS_WITH(parse_note_request(R"({"add_tags":[")" + std::string(65, 'x') + R"("]})"),
                    Contains("64 bytes"));
}

TEST_CASE("a secret is equal to itself alone") {
  CHECK(same_secret("abc", "abc"));
  CHECK_FALSE(same_secret("abc", "abd"));
  CHECK_FALSE(same_secret("abc", "ab"));
  CHECK_FALSE(same_secret("", "a"));
}

TEST_CASE("a name that foreign DNS points at this machine is no Host of the page") {
  const auto own = own_authorities("127.0.0.1", 8750, {"Lab.example.org"});
  for (const char* host :
       {"127.0.0.1:8750", "localhost:8750", "LOCALHOST:8750", "[::1]:8750", "lab.example.org"})
    CHECK(host_allowed(host, own));
  for (const char* host :
       {"evil.example:8750", "127.0.0.1", "127.0.0.1:80", "", "localhost:8750.evil.example"})
    CHECK_FALSE(host_allowed(host, own));
  CHECK(origin_allowed("", own));
  CHECK(origin_allowed("http://127.0.0.1:8750", own));
  CHECK(origin_allowed("https://lab.example.org", own));
  for (const char* origin : {"null", "http://evil.example", "http://127.0.0.1:8751", "file://127.0.0.1:8750"})
    CHECK_FALSE(origin_allowed(origin, own));
}

TEST_CASE("a foreign Host or Origin is named with the option that makes it the page's own") {
  const auto own = own_authorities("127.0.0.1", 8750, {});
  CHECK(foreign_words("127.0.0.1:8750", "http://localhost:8750", own).empty());
  CHECK(foreign_words("127.0.0.1:8750", "", own).empty());
  CHECK(foreign_words("127.0.0.1:8750", "https://lab.example.org", own) ==
        "Origin https://lab.example.org is not this page's: behind a proxy start it with --host "
        "lab.example.org");
  CHECK(foreign_words("lab.example.org:8080", "", own) ==
        "Host lab.example.org:8080 is not this page's: behind a proxy start it with --host "
        "lab.example.org:8080");
  CHECK(foreign_words("", "", own) ==
        "Host (none) is not this page's: behind a proxy start it with --host (none)");
  CHECK(foreign_words("a\tb<\x80", "", own).find('\t') == std::string::npos);
}

TEST_CASE("no path leads out of its folder") {
  CHECK(path_parts("/api/runs/a%20b?x=1") == std::vector<std::string>{"api", "runs", "a b"});
  CHECK(path_parts("/") == std::vector<std::string>{""});
  for (const char* target :
       {"", "api", "/..", "/a/../b", "/%2e%2e/x", "/a%2fb", "/a%00", "/%zz", "/%4", "/1/2/3/4/5/6/7/8/9"})
    CHECK(path_parts(target).empty());
}

TEST_CASE("values of a query and words of a header's list are found") {
  CHECK(query_values("/ws?run=a%20b&x=1&run=c", "run") == std::vector<std::string>{"a b", "c"});
  CHECK(query_values("/ws?run=..%2fx&run=", "run") == std::vector<std::string>{"", ""});
  CHECK(query_values("/ws?runs=a&x", "run").empty());
  CHECK(query_values("/ws", "run").empty());
  CHECK(list_words(" firn,0123 ,, ") == std::vector<std::string_view>{"firn", "0123"});
  CHECK(list_words("").empty());
}

TEST_CASE("the token is shown by a header or by a cookie of the page, and by nothing else") {
  using Words = std::vector<std::string_view>;
  CHECK(bearer_token("Bearer t0k") == "t0k");
  CHECK(cookie_tokens("firn-8750=t0k") == Words{"t0k"});
  CHECK(cookie_tokens("a=1;  firn-=t0k; b=2") == Words{"t0k"});
  CHECK(cookie_tokens("firn-1=old; firn-2=t0k") == Words{"old", "t0k"});
  for (const char* cookies : {"", ";", "firn-8750", "xfirn-1=t0k", "t0k", "a=firn-1=t0k", ";;;=;"})
    CHECK(cookie_tokens(cookies).empty());
  for (const char* header : {"", "Bearer", "Bearer ", "bearer t0k", "Basic t0k"})
    CHECK(bearer_token(header).empty());
}
