// Who may watch and who may command: people with tokens of their own, a proxy that names them, over HTTP and
// WebSocket alike.
#include "page/access.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "tests/page/served_run.h"
#include "tests/page/web_client.h"

namespace firn::page {
namespace {

using Catch::Contains;
using nlohmann::json;
using test::Served;
using test::TempFolder;
using test::WebClient;

struct Table {
  TempFolder folder;
  std::filesystem::path file = folder.path() / "people";
  std::vector<PersonRow> people;
  std::string observer = add_person(people, "Olga Ober", Role::kObserver);
  std::string operating = add_person(people, "Otto", Role::kOperator);
  std::string proxy = add_person(people, "nginx", Role::kProxy);

  Table() {
    people.push_back({"Petra", Role::kOperator, ""});
    people.push_back({"Paul", Role::kObserver, ""});
    write_people(file, people);
  }
};

ServerOptions options_with(const Table& table) {
  ServerOptions o;
  o.token = "start";
  o.people = table.file;
  return o;
}

std::string bearer(const std::string& token) { return "Bearer " + token; }

}  // namespace

TEST_CASE("a token tells the person, and each role what it may do") {
  const Table table;
  const ServerOptions options = options_with(table);
  Access access(options);
  const auto check = [&](const Person& p, bool reads, bool commands, const std::string& name) {
    INFO(name);
    CHECK(p.reads == reads);
    CHECK(p.commands == commands);
    CHECK(p.name == name);
  };
  check(access.of_token("start"), true, true, "");
  check(access.of_token(table.observer), true, false, "Olga Ober");
  check(access.of_token(table.operating), true, true, "Otto");
  check(access.of_token(table.proxy), false, false, "");  // a proxy alone is nobody
  check(access.of_token(""), false, false, "");
  check(access.of_token(table.operating.substr(1)), false, false, "");
  check(access.of({"", "firn-8750=" + table.operating, ""}), true, true, "Otto");
  check(access.by_header({"", "firn-8750=" + table.operating, ""}), false, false, "");
}

TEST_CASE("a header names a person by the token of a proxy alone") {
  const Table table;
  const ServerOptions options = options_with(table);
  Access access(options);
  CHECK(access.by_header({bearer(table.proxy), "", "Petra"}).commands);
  CHECK(access.by_header({bearer(table.proxy), "", "Petra"}).name == "Petra");
  CHECK(access.by_header({bearer(table.proxy), "", "Paul"}).reads);
  CHECK_FALSE(access.by_header({bearer(table.proxy), "", "Paul"}).commands);
  for (const char* unknown : {"", "Nobody", "nginx", "petra"})
    CHECK_FALSE(access.by_header({bearer(table.proxy), "", unknown}).reads);
  for (const std::string& token : {std::string("start"), table.observer})
    CHECK(access.by_header({bearer(token), "", "Petra"}).name != "Petra");
  CHECK_FALSE(access.of({"", "", "Petra"}).reads);
}

TEST_CASE("whoever is taken out of the table may nothing more, and a damaged table gives nobody rights") {
  Table table;
  const ServerOptions options = options_with(table);
  Access access(options);
  REQUIRE(access.of_token(table.operating).commands);
  const auto rewrite = [&](const auto& write) {
    const auto before = std::filesystem::last_write_time(table.file);
    write();
    std::filesystem::last_write_time(table.file, before + std::chrono::seconds(1));
  };
  std::erase_if(table.people, [](const PersonRow& p) { return p.name == "Otto"; });
  rewrite([&] { write_people(table.file, table.people); });
  CHECK_FALSE(access.of_token(table.operating).reads);
  CHECK(access.of_token(table.observer).reads);
  rewrite([&] { write_file_atomically(table.file, "Olga"); });
  CHECK_FALSE(access.of_token(table.observer).reads);
  std::filesystem::remove(table.file);
  CHECK_FALSE(access.of_token(table.observer).reads);
  CHECK(access.of_token("start").commands);
}

TEST_CASE("a table with a mistake is refused by file, line and requirement") {
  const TempFolder folder;
  const std::filesystem::path file = folder.path() / "people";
  const auto refused = [&](const std::string& text, const std::string& why) {
    write_file_atomically(file, text);
    ::chmod(file.c_str(), 0600);
    INFO(text);
    CHECK_THROWS_WITH(read_people(file), Contains(why) && Contains(file.string()));
  };
  refused("# who\nKim\n", ":2: must be NAME:ROLE:SHA256");
  refused("Kim:admin:-\n", ":1: 'admin': a role is observer, operator or proxy");
  refused("Kim:operator:abc\n", "64 hexadecimal digits");
  refused(":operator:-\n", "no name");
  refused("p:proxy:-\n", "a proxy needs a token");
  refused("Kim:operator:-\nKim:observer:-\n", ":2: Kim stands there twice");
  refused(std::string(61, 'k') + ":operator:-\n", "at most 60 bytes");
  write_file_atomically(file, "Kim:operator:-\n");
  ::chmod(file.c_str(), 0666);
  CHECK_THROWS_WITH(read_people(file), Contains("chmod 600"));
  CHECK_THROWS_WITH(read_people(folder.path() / "none"), Contains("none"));
}

TEST_CASE("a written table is for its owner alone and is read as it was") {
  const Table table;
  struct stat found {};
  REQUIRE(::stat(table.file.c_str(), &found) == 0);
  CHECK((found.st_mode & 0777) == 0600);
  const auto read = read_people(table.file);
  REQUIRE(read.size() == table.people.size());
  for (std::size_t n = 0; n < read.size(); ++n) {
    CHECK(read[n].name == table.people[n].name);
    CHECK(read[n].role == table.people[n].role);
    CHECK(read[n].token_sha256 == table.people[n].token_sha256);
  }
  CHECK_THAT(read_file(table.file), !Contains(table.operating));
}

TEST_CASE("an observer reads over HTTP and WebSocket, and is refused every change by his name over both") {
  const Table table;
  Served s([&](ServerOptions& o) { o.people = table.file; });
  const std::string run = "/api/runs/" + s.id;
  CHECK(WebClient(s.address, table.observer).get(run).status == 200);
  const std::vector<std::string> as_json{"Content-Type: application/json"};
  for (const char* what : {"/notes", "/resume", "/acknowledge"}) {
    const std::string alarm = what == std::string("/acknowledge") ? ",\"alarm\":\"x\"" : "";
    for (const std::string& token : {std::string(), table.observer}) {
      const auto reply =
          WebClient(s.address, table.observer)
              .request("POST", run + what, as_json, "{\"token\":\"" + token + "\"" + alarm + "}");
      INFO(what << ": " << reply.body);
      CHECK(reply.status == 403);
      CHECK_THAT(reply.body, Contains("Olga Ober is an observer"));
    }
  }
  WebClient c(s.address, table.observer);
  REQUIRE(c.open("/api/v1/runs/" + s.id + "/events") == 101);
  const json hello = json::parse(c.next_of("hello", 5.0).value_or("{}"));
  CHECK(hello["you"]["name"] == "Olga Ober");
  CHECK(hello["you"]["commands"] == false);
  for (const std::string& token : {std::string(), table.observer}) {
    c.send(json{{"type", "command"}, {"id", 1}, {"token", token}, {"command", "safe_stop"}}.dump());
    const json answer = json::parse(c.next_of("answer", 5.0).value_or("{}"));
    CHECK(answer["ok"] == false);
    CHECK_THAT(answer["error"].get<std::string>(), Contains("Olga Ober is an observer"));
  }
  CHECK(WebClient(s.address, table.observer)
            .open("/command?run=" + s.id, {"Sec-WebSocket-Protocol: firn, " + table.observer}) == 404);
}

TEST_CASE("an operator commands by his token in the request, and his name goes into the notes") {
  const Table table;
  Served s([&](ServerOptions& o) { o.people = table.file; });
  WebClient c(s.address, table.operating);
  REQUIRE(c.open("/ws?run=" + s.id) == 101);
  c.send(R"({"type":"command","id":2,"command":"pause"})");
  const json answer = json::parse(c.next_of("answer", 5.0).value_or("{}"));
  CHECK_THAT(answer["error"].get<std::string>(), Contains("is not running"));  // he was let through
  const auto kept = WebClient(s.address, table.operating)
                        .request("POST", "/api/runs/" + s.id + "/notes", {"Content-Type: application/json"},
                                 R"({"note":"looks fine","author":"Somebody Else"})");
  REQUIRE(kept.status == 200);
  CHECK(json::parse(kept.body)["notes"][0]["author"] == "Otto");
  const auto proxied =
      WebClient(s.address, table.proxy)
          .request("POST", "/api/runs/" + s.id + "/notes",
                   {"Content-Type: application/json", "X-Forwarded-User: Petra"}, R"({"note":"by proxy"})");
  REQUIRE(proxied.status == 200);
  CHECK(json::parse(proxied.body)["notes"][1]["author"] == "Petra");
}

}  // namespace firn::page
