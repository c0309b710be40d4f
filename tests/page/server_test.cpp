#include <catch2/catch.hpp>

#include <unistd.h>

#include <cstring>

#include "core/grid/random.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "page/event_words.h"
#include "page/run_set.h"
#include "page/server.h"
#include "print/labs/full_product.h"
#include "runs/folder/address.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/verdict.h"
#include "tests/page/served_run.h"
#include "tests/page/web_client.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;
using firn::test::print_into;
using firn::test::Served;
using firn::test::WebClient;
using nlohmann::json;

namespace {

json hello(const Served& s, WebClient& client) {
  REQUIRE(client.open("/ws?run=" + s.id) == 101);
  const auto text = client.next_of("hello", 5.0);
  REQUIRE(text);
  return json::parse(*text);
}

template <class T>
T at(const std::string& frame, std::size_t offset) {
  T value;
  std::memcpy(&value, frame.data() + offset, sizeof value);
  return value;
}

}  // namespace

TEST_CASE("the list of runs has the error of a finished run when it is first asked for") {
  const test::TempFolder place;
  const std::string name = print_into(place.path());
  const auto result = runs::RunFolder::open(place.path() / name).result();
  REQUIRE(result);
  REQUIRE(result->error);
  const json listed = json::parse(page::RunSet({place.path()}, {}).list()()).at("runs").at(0);
  CHECK(listed.at("rms_um") == result->error->rms_um);
  CHECK(listed.at("mean_um") == result->error->mean_um);
  CHECK(listed.at("layers") == result->layers);
  CHECK(listed.at("part") == part_words(*result->part));
  CHECK(listed.at("verdict") == verdict_words(*result, LabWords{}));
  CHECK(listed.at("within") == *within_tolerance(*result));
  CHECK(listed.at("audit") == "clean");
  CHECK(listed.at("overspill_percent") == *result->overspill_percent);
  CHECK(listed.at("height_unit") == "um");
}

TEST_CASE("the page's files come compressed, with a tag, and only to a page of this origin") {
  Served s;
  WebClient c(s.address);
  const auto page = c.request("GET", "/", {"Accept-Encoding: gzip"});
  CHECK(page.status == 200);
  CHECK_THAT(page.head, Contains("Content-Encoding: gzip") && Contains("default-src 'self'"));
  const std::size_t tag = page.head.find("ETag: ") + 6;
  const std::string etag = page.head.substr(tag, page.head.find("\r\n", tag) - tag);
  CHECK(c.request("GET", "/", {"If-None-Match: " + etag}).status == 304);
  CHECK_THAT(c.get("/").body, Contains("<!doctype html>", Catch::CaseSensitive::No));
  const std::string manual = c.get("/manual/safety.html").body;
  CHECK_THAT(manual, Contains("id=\"the-stop\"") && Contains("id=\"deposit-at-most-once\""));
  for (const page::InterlockWords& row : page::interlocks())
    CHECK_THAT(manual, Contains("<tr id=\"interlock-" + std::to_string(row.code) + "\">"));
  CHECK(c.get("/nothing").status == 404);
  CHECK(c.get("/../etc/passwd").status == 404);
  CHECK(c.request("GET", "/", {"Host: evil.example"}).status == 403);
  CHECK(c.request("GET", "/", {"Origin: http://evil.example"}).status == 403);
  CHECK(WebClient(s.address).open("/ws?run=" + s.id, {"Origin: http://evil.example"}) == 403);
  CHECK(WebClient(s.address).open("/ws?run=" + s.id, {"Host: evil.example:8750"}) == 403);
  CHECK(c.request("POST", "/", {}, "x").status == 405);
}

TEST_CASE("a recorded run is greeted with its facts, layers and end, and gives each map") {
  Served s;
  WebClient c(s.address);
  const json greeting = hello(s, c);
  CHECK(greeting["protocol"] == 1);
  CHECK(greeting["run"]["label"] == s.id);
  CHECK(greeting["run"]["id"] == runs::address_of(s.place.path() / "runs" / s.id).text());
  CHECK(greeting["run"]["lab"] == "inkjet");
  CHECK(greeting["run"]["lab_words"] == "droplets on a stage");
  CHECK(greeting["run"]["deposition"] == "droplets");
  CHECK(greeting["run"]["live"] == false);
  CHECK(greeting["run"]["grid"]["nx"] == 9);
  CHECK(greeting["end"]["outcome"] == "finished");
  const runs::RunResult result = runs::RunFolder::open(s.place.path() / "runs" / s.id).result().value();
  CHECK(greeting["end"]["verdict"] == verdict_words(result, LabWords{}));
  std::string facts;
  for (const json& line : greeting["end"]["facts"]) facts += line.get<std::string>() + "\n";
  CHECK(facts == result_lines(result, LabWords{}));
  CHECK(greeting["run"]["amount"] == "droplets");
  CHECK(greeting["commands"]["allowed"].empty());
  const int layers = greeting["layers"].back()["n"];
  CHECK(int(greeting["layers"].size()) == layers + 1);
  CHECK(greeting["layers"].back()["predicted_rms_um"].is_number());
  CHECK_THAT(WebClient(s.address).get("/api/runs").body, Contains(s.id));
  for (const char* surface : {"measured", "target", "error", "planned", "predicted", "truth"}) {
    INFO(surface);
    const bool planned = std::string(surface) == "planned";
    const int n = planned ? layers - 1 : layers;
    const auto map =
        WebClient(s.address).get("/api/runs/" + s.id + "/layers/" + std::to_string(n) + "/" + surface);
    REQUIRE(map.status == 200);
    REQUIRE(map.body.size() == 32 + 9 * 8 * 4);
    CHECK(map.body.starts_with("FMAP"));
    CHECK(at<std::uint32_t>(map.body, 8) == std::uint32_t(n));
    CHECK(at<std::uint32_t>(map.body, 12) == 9);
    CHECK(at<std::uint32_t>(map.body, 16) == 8);
    CHECK(at<std::uint32_t>(map.body, 20) == (planned ? 1u : 0u));
  }
  CHECK(WebClient(s.address).get("/api/runs/" + s.id + "/layers/999/measured").status == 204);
  CHECK(WebClient(s.address).get("/api/runs/" + s.id + "/layers/1/nothing").status == 404);
  CHECK(WebClient(s.address).get("/api/runs/none/layers/1/measured").status == 404);
}

TEST_CASE("the last bytes on each instrument's line are read when they are asked for") {
  Served s;
  const auto reply = WebClient(s.address).get("/api/runs/" + s.id + "/exchanges");
  REQUIRE(reply.status == 200);
  std::map<std::string, std::string> said;
  const json body = json::parse(reply.body);
  for (const json& one : body["exchanges"]) said[one["name"]] = one["text"];
  for (const char* name : {"stage", "jet", "lamp", "laser_profiler"}) {
    INFO(name << ": " << said[name]);
    CHECK_THAT(said[name], Contains("sent ") && Contains(" | received "));
  }
  CHECK(WebClient(s.address).get("/api/runs/none/exchanges").status == 404);
}

TEST_CASE("the error is the measured surface less the target, on the part's cells alone") {
  Served s;
  const std::string base = "/api/runs/" + s.id + "/layers/2/";
  const auto measured = WebClient(s.address).get(base + "measured").body;
  const auto target = WebClient(s.address).get(base + "target").body;
  const auto error = WebClient(s.address).get(base + "error").body;
  int cells = 0;
  for (std::size_t k = 0; k < 72; ++k) {
    const float e = at<float>(error, 32 + 4 * k), t = at<float>(target, 32 + 4 * k);
    CHECK((e != e || t == t));
    if (e != e) continue;
    CHECK(e == Approx(at<float>(measured, 32 + 4 * k) - t).margin(1e-2));
    ++cells;
  }
  CHECK(cells > 30);
}

TEST_CASE("a tab follows a surface, asks for layers, and is told what is not there") {
  Served s;
  WebClient c(s.address);
  const json greeting = hello(s, c);
  c.send(R"({"type":"follow","surface":"measured"})");
  const auto newest = c.next_map(5.0);
  REQUIRE(newest);
  CHECK(at<std::uint32_t>(*newest, 8) == greeting["layers"].back()["n"].get<std::uint32_t>());
  c.send(R"({"type":"follow","surface":"error","layer":1})");
  const auto one = c.next_map(5.0);
  REQUIRE(one);
  CHECK(at<std::uint16_t>(*one, 6) == 2);
  CHECK(at<std::uint32_t>(*one, 8) == 1);
  c.send(R"({"type":"follow","surface":"error","layer":500})");
  CHECK_THAT(c.next_of("answer", 5.0).value_or(""), Contains("layer 500"));
  c.send(R"({"type":"ping","id":4})");
  CHECK_THAT(c.next_of("pong", 5.0).value_or(""), Contains("\"id\":4"));
  c.send("nonsense");
  CHECK_THAT(c.next_of("error", 5.0).value_or(""), Contains("JSON"));
  c.send_frame(2, "binary");
  CHECK_THAT(c.next_of("error", 5.0).value_or(""), Contains("must be text"));
  WebClient other(s.address);
  CHECK(other.open("/ws?run=none") == 101);
  CHECK_THAT(other.next_of("error", 5.0).value_or(""), Contains("no run 'none'"));
}

TEST_CASE("nobody reads a run without the token, unless the page is public") {
  Served s;
  for (const char* target : {"/api/runs", "/api/report?run=x", "/api/runs/x/lamp"})
    CHECK(WebClient(s.address, "").get(target).status == 401);
  CHECK(WebClient(s.address, "").get("/api/runs/" + s.id).status == 401);
  CHECK(WebClient(s.address, "").open("/ws?run=" + s.id) == 401);
  CHECK(WebClient(s.address, "wrong").get("/api/runs").status == 401);
  CHECK(WebClient(s.address, "").request("GET", "/api/runs", {"Cookie: a=b; firn-8750=secret"}).status ==
        200);
  CHECK(WebClient(s.address, "").request("GET", "/api/runs", {"Cookie: firn-8750=secre"}).status == 401);
  CHECK(WebClient(s.address, "").get("/").status == 200);  // the page itself tells nothing
  s.options.is_public = true;
  CHECK(WebClient(s.address, "").get("/api/runs/" + s.id).status == 200);
}

TEST_CASE("a command without the token is refused, and with it by a run that nobody prints") {
  Served s;
  WebClient c(s.address, "");
  REQUIRE(c.open("/ws?run=" + s.id, {"Cookie: firn-8750=secret"}) == 101);
  for (const char* token : {"", "Secret", "secre", "secret "}) {
    c.send(json{{"type", "command"}, {"id", 1}, {"token", token}, {"command", "pause"}}.dump());
    const json answer = json::parse(c.next_of("answer", 5.0).value_or("{}"));
    CHECK(answer["ok"] == false);
    CHECK_THAT(answer["error"].get<std::string>(), Contains("token"));
  }
  c.send(R"({"type":"command","id":2,"token":"secret","command":"pause"})");
  const json answer = json::parse(c.next_of("answer", 5.0).value_or("{}"));
  CHECK(answer["id"] == 2);
  CHECK(answer["ok"] == false);
  CHECK_THAT(answer["error"].get<std::string>(), Contains("is not running"));
}

TEST_CASE("a line for commands opens with the token alone, and obeys commands alone") {
  Served s;
  const std::string target = "/command?run=" + s.id;
  CHECK(WebClient(s.address, "").open(target, {"Sec-WebSocket-Protocol: firn"}) == 401);
  for (const char* protocols : {"firn, wrong", "secret, firn", "firn, secret, x"}) {
    INFO(protocols);
    CHECK(WebClient(s.address).open(target, {std::string("Sec-WebSocket-Protocol: ") + protocols}) == 404);
  }
  const std::vector<std::string> right{"Sec-WebSocket-Protocol: firn, secret"};
  CHECK(WebClient(s.address).open("/command?run=none", right) == 404);
  CHECK(WebClient(s.address).open(target, {right[0], "Origin: http://evil.example"}) == 403);
  WebClient line(s.address);
  REQUIRE(line.open(target, right) == 101);
  line.send(R"({"type":"ping","id":1})");
  CHECK_THAT(line.next_of("error", 5.0).value_or(""), Contains("only commands"));
  line.send(R"({"type":"command","id":2,"command":"pause"})");
  const json answer = json::parse(line.next_of("answer", 5.0).value_or("{}"));
  CHECK(answer["id"] == 2);
  CHECK_THAT(answer["error"].get<std::string>(), Contains("is not running"));
}

TEST_CASE("runs are reported on one page that may run nothing") {
  Served s;
  const auto page = WebClient(s.address).get("/api/report?run=" + s.id + "&run=" + s.id);
  CHECK(page.status == 200);
  CHECK_THAT(page.head, Contains("sandbox; default-src 'none'"));
  CHECK_THAT(page.body, Contains("<!doctype html>", Catch::CaseSensitive::No) && Contains(s.id));
  for (const char* target : {"/api/report", "/api/report?run=none", "/api/report?run=..%2fx"}) {
    INFO(target);
    CHECK(WebClient(s.address).get(target).status == 404);
  }
}

TEST_CASE("notes are kept in the run's folder, with the token alone") {
  Served s;
  WebClient c(s.address);
  const std::string target = "/api/runs/" + s.id + "/notes";
  const json notes{{"token", "secret"}, {"author", "Ada"}, {"add_tags", {"good"}}, {"note", "try again"}};
  json wrong = notes;
  wrong["token"] = "x";
  const std::vector<std::string> type{"Content-Type: application/json"};
  CHECK(c.request("POST", target, type, wrong.dump()).status == 403);
  CHECK(c.request("POST", target, {"Content-Type: text/plain"}, notes.dump()).status == 415);
  CHECK(c.request("POST", target, type, "{").status == 400);
  CHECK(c.request("POST", "/api/runs/none/notes", type, notes.dump()).status == 404);
  CHECK(c.request("POST", target, type, notes.dump()).status == 200);
  const std::string long_body(100'000, 'x');
  CHECK(WebClient(s.address).request("POST", target, type, long_body).status == 413);
  const json more{{"token", "secret"}, {"add_tags", {"dry"}}, {"remove_tags", {"good"}}, {"note", "dry now"}};
  const json answered = json::parse(c.request("POST", target, type, more.dump()).body);
  CHECK(answered["tags"] == json{"dry"});
  REQUIRE(answered["notes"].size() == 2);
  CHECK(answered["notes"][0]["text"] == "try again");
  CHECK(answered["notes"][0]["author"] == "Ada");
  CHECK(answered["notes"][0]["time_utc"].get<std::string>().ends_with("Z"));
  CHECK(c.request("POST", target, type, json{{"token", "secret"}, {"add_tags", {" "}}}.dump()).status == 400);
  const auto where = [&](const std::string& condition) {
    return json::parse(c.get("/api/runs?where=" + condition).body);
  };
  CHECK(where("tag%20%3D%20dry")["runs"].size() == 1);
  CHECK(where("tag%20%3D%20good")["runs"].empty());
  CHECK_THAT(where("tag%20%3D")["error"].get<std::string>(), Contains("column 6: a value is wanted"));
  const json listed = json::parse(c.get("/api/runs").body)["runs"];
  const auto run =
      std::ranges::find(listed, s.id, [](const json& r) { return r["label"].get<std::string>(); });
  REQUIRE(run != listed.end());
  CHECK((*run)["notes"] == answered["notes"]);
  CHECK((*run)["tags"] == json{"dry"});
}

TEST_CASE("connections beyond the limit, garbage and half requests leave others served") {
  Served s;
  WebClient watcher(s.address), garbler(s.address);
  hello(s, watcher);
  hello(s, garbler);
  std::vector<std::unique_ptr<WebClient>> idle;
  for (int n = 0; n < 400; ++n) idle.push_back(std::make_unique<WebClient>(s.address));
  idle.resize(50);
  RandomStream random(3, Purpose::kTest);
  for (int n = 0; n < 200; ++n) {
    std::string bytes(1 + random.below(300), '\0');
    for (char& b : bytes) b = char(random.below(256));
    WebClient(s.address).send_raw(bytes);
    garbler.send_frame(int(random.below(2)) + 1, bytes.substr(0, 100));
  }
  watcher.send(R"({"type":"ping","id":77})");
  CHECK_THAT(watcher.next_of("pong", 10.0).value_or(""), Contains("77"));
  idle.clear();
  ::usleep(200'000);
  CHECK(WebClient(s.address).get("/").status == 200);
}

TEST_CASE(
    "a newcomer is served at once beside as many idle connections as there may be, and only the oldest go") {
  Served s;
  std::vector<std::unique_ptr<WebClient>> idle;
  for (int n = 0; n < 2 * page::kMaxConnections; ++n) {
    idle.push_back(std::make_unique<WebClient>(s.address));
    if (n % 20 == 0) CHECK(WebClient(s.address).get("/").status == 200);
  }
  CHECK(WebClient(s.address).get("/").status == 200);
  CHECK(idle.front()->get("/").status == 0);
  CHECK(idle.back()->get("/").status == 200);
}

TEST_CASE("the hours of a lamp count the runs before that name its port") {
  Served s;
  WebClient c(s.address);
  const auto lamp = [&](const std::string& id) {
    return json::parse(WebClient(s.address).get("/api/runs/" + id + "/lamp").body);
  };
  double own_h = 0.0;
  const json greeting = hello(s, c);
  for (const json& one : greeting["instruments"])
    for (const json& row : one["details"]) {
      const std::string label = row[0], value = row[1];
      if (label.starts_with("open in this print")) own_h = std::stod(value);
    }
  REQUIRE(own_h > 0.0);
  CHECK(lamp(s.id) == json{{"lamp", "simulated"}, {"earlier_h", 0.0}, {"earlier_runs", 0}});
  std::vector<std::string> later;
  for (int n = 0; n < 2; ++n) later.push_back(print_into(s.place.path() / "runs"));
  CHECK(lamp(later[1])["earlier_runs"] == 2);
  CHECK(lamp(later[1])["earlier_h"].get<double>() == Approx(2.0 * own_h).margin(1e-4));
  CHECK(lamp(s.id)["earlier_runs"] == 0);
  CHECK(WebClient(s.address).get("/api/runs/none/lamp").status == 404);
}

TEST_CASE("a place that is no folder and an address of another machine are named") {
  page::ServerOptions o;
  o.places = {"/no/such/folder"};
  CHECK_THROWS_AS(page::serve(full_product(), o), UsageError);
  o.places = {"/tmp"};
  o.bind = "198.51.100.7";
  CHECK_THROWS_WITH(page::serve(full_product(), o), Contains("198.51.100.7"));
  o.bind = "house";
  CHECK_THROWS_WITH(page::serve(full_product(), o), Contains("--bind house"));
}
