// Audit and resume of a run that is over, by its page.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <string>

#include "files/json.h"
#include "files/text_file.h"
#include "replay/audit_run.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_lock.h"
#include "tests/page/served_run.h"
#include "tests/page/web_client.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;
using firn::test::Served;
using firn::test::WebClient;
using nlohmann::json;

namespace {

const std::string kRight = R"({"token":"secret"})";

/// Says that a print ended before its last layer.
void stop(const std::filesystem::path& run) {
  runs::RunResult result = runs::parse_result(read_file(run / "result.json"), "result.json");
  result.outcome = "stopped safely";
  std::ofstream(run / "result.json") << runs::result_text(result);
}

WebClient::Reply resume(const Served& s, const std::string& body = kRight) {
  return WebClient(s.address, "")
      .request("POST", "/api/runs/" + s.id + "/resume",
               {"Content-Type: application/json", "Cookie: firn-1=secret"}, body);
}

/// A page whose run was stopped, with a stand-in for firn.
class Stopped {
 public:
  explicit Stopped(const std::string& script)
      : served([&](page::ServerOptions& o) { o.firn = folder.file("firn", "#!/bin/sh\n" + script); }) {
    std::filesystem::permissions(folder.path() / "firn", std::filesystem::perms::owner_all);
    stop(served.folder());
  }
  std::string wrote(const std::string& name) const { return read_file(folder.path() / name); }

  test::TempFolder folder;
  Served served;
};

/// A script that notes a fact of its process beside itself.
std::string noting(const std::string& command) { return command + " > \"$(dirname \"$0\")/noted\"\n"; }

}  // namespace

TEST_CASE("a run that is over is audited with the words of firn audit") {
  const Served s;
  const replay::AuditVerdict verdict = replay::audit_run(s.folder());
  const auto reply = WebClient(s.address).get("/api/runs/" + s.id + "/audit");
  REQUIRE(reply.status == 200);
  const json body = json::parse(reply.body);
  CHECK(body["clean"] == verdict.clean());
  CHECK(body["text"] == replay::to_text(verdict));
}

TEST_CASE("the audit names what is not as it was recorded") {
  const Served s;
  std::filesystem::remove(s.folder() / "nodes" / "stage.wal");
  const json body = json::parse(WebClient(s.address).get("/api/runs/" + s.id + "/audit").body);
  CHECK(body["clean"] == false);
  CHECK_THAT(body["text"].get<std::string>(), Contains("nodes/stage.wal is missing"));
}

TEST_CASE("a run that is being printed is not audited") {
  const Served s;
  const runs::RunLock print(s.folder(), runs::RunUse::kPrint);
  const auto reply = WebClient(s.address).get("/api/runs/" + s.id + "/audit");
  CHECK(reply.status == 409);
  CHECK_THAT(reply.body, Contains("is being printed"));
}

TEST_CASE("a run that is being printed is not resumed") {
  const Served s;
  stop(s.folder());
  const runs::RunLock print(s.folder(), runs::RunUse::kPrint);
  const auto reply = resume(s);
  CHECK(reply.status == 409);
  CHECK_THAT(reply.body, Contains("is being printed"));
}

TEST_CASE("a run is resumed by firn print --resume RUN --detach") {
  const Stopped s(noting("echo \"$@\""));
  const auto reply = resume(s.served);
  CHECK(reply.status == 200);
  CHECK(json::parse(reply.body)["ok"] == true);
  CHECK(s.wrote("noted") ==
        "print --resume " + std::filesystem::canonical(s.served.folder()).string() + " --detach\n");
}

TEST_CASE("a resume whose print was over at once names no process") {
  const Stopped s("exit 0\n");
  CHECK(json::parse(resume(s.served).body)["pid"].is_null());
}

TEST_CASE("a print that the page resumes is in a session of its own") {
  const Stopped s(noting("cut -d ' ' -f 1,6 /proc/$$/stat"));
  REQUIRE(resume(s.served).status == 200);
  const std::string noted = s.wrote("noted");
  const std::size_t blank = noted.find(' ');
  CHECK(noted.substr(0, blank) + "\n" == noted.substr(blank + 1));
}

TEST_CASE("a print that the page resumes has no connection of the page") {
  const Stopped s(noting("ls -l /proc/$$/fd"));
  REQUIRE(resume(s.served).status == 200);
  CHECK_THAT(s.wrote("noted"), !Contains("socket:"));
}

TEST_CASE("a resume that fails is answered with the last line of its error") {
  const Stopped s("echo first; echo 'firn print: the stage does not answer' >&2; exit 2\n");
  const auto reply = resume(s.served);
  CHECK(reply.status == 409);
  CHECK(json::parse(reply.body)["error"] == "firn print: the stage does not answer");
}

TEST_CASE("nothing is resumed without the token") {
  const Stopped s(noting("echo begun"));
  for (const std::string body : {"{}", R"({"token":"Secret"})", R"({"token":""})"}) {
    INFO(body);
    CHECK(resume(s.served, body).status == 403);
  }
  CHECK(resume(s.served, "no JSON").status == 400);
  CHECK(WebClient(s.served.address)
            .request("POST", "/api/runs/" + s.served.id + "/resume", {"Content-Type: text/plain"}, kRight)
            .status == 415);
  CHECK_FALSE(std::filesystem::exists(s.folder.path() / "noted"));
}

TEST_CASE("a run whose last layer is printed is not resumed") {
  const Served s;
  const auto reply = resume(s);
  CHECK(reply.status == 409);
  CHECK_THAT(reply.body, Contains("the run is over: finished"));
}

TEST_CASE("a stranger's run with Python code is not resumed by the page") {
  const Stopped s(noting("echo begun"));
  const std::filesystem::path file = s.served.folder() / "experiment.toml";
  std::string text = read_file(file);
  const std::size_t at = text.find("scheme = \"mpc\"");
  REQUIRE(at != std::string::npos);
  text.replace(at, 14, "scheme = \"python:level.py:Level\"");
  std::ofstream(file) << text;
  const auto reply = resume(s.served);
  CHECK(reply.status == 409);
  CHECK_THAT(reply.body, Contains("python:level.py:Level"));
  CHECK_FALSE(std::filesystem::exists(s.folder.path() / "noted"));
}

TEST_CASE("the page of a print resumes no other run") {
  const test::TempFolder folder;
  const std::string live = test::print_into(folder.path());
  const Served s([&](page::ServerOptions& o) { o.live = folder.path() / live; });
  stop(s.folder());
  const auto reply = resume(s);
  CHECK(reply.status == 409);
  CHECK_THAT(reply.body, Contains("part of a print"));
}

TEST_CASE("a page that is part of no print has no live run, which is no error") {
  const Served s;
  CHECK(WebClient(s.address).get("/api/runs/live").status == 204);
  CHECK(WebClient(s.address).get("/api/runs/none").status == 404);
}
