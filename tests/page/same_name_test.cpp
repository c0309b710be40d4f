// Two prints whose folders have one name: each order reaches its own.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <future>
#include <map>
#include <string>
#include <thread>

#include "core/grid/random.h"
#include "files/json.h"
#include "page/server.h"
#include "print/labs/full_product.h"
#include "runs/folder/address.h"
#include "tests/page/web_client.h"
#include "tests/print/lone_desk.h"
#include "tests/support/long_cases.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using firn::test::WebClient;
using nlohmann::json;

namespace {

const std::vector<std::string> kToken{"Sec-WebSocket-Protocol: firn, secret"};

/// A page that shows the runs of two places.
class Page {
 public:
  explicit Page(std::vector<std::filesystem::path> places) {
    REQUIRE(::pipe(stop_) == 0);
    options_.places = std::move(places);
    options_.token = "secret";
    options_.stop_fd = stop_[0];
    std::promise<std::string> listening;
    options_.listening = [&](const std::string& at) { listening.set_value(at); };
    thread_ = std::thread([this] { page::serve(full_product(), options_); });
    address = listening.get_future().get();
  }
  ~Page() {
    REQUIRE(::write(stop_[1], "x", 1) == 1);
    thread_.join();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }
  json order(const std::string& run, const std::string& command) const {
    WebClient line(address);
    REQUIRE(line.open("/command?run=" + run, kToken) == 101);
    line.send(json{{"type", "command"}, {"id", 1}, {"command", command}}.dump());
    return json::parse(line.next_of("answer", 10.0).value_or("{}"));
  }

  std::string address;

 private:
  page::ServerOptions options_;
  int stop_[2];
  std::thread thread_;
};

/// Two labs' prints that began in one second, on two pages.
struct TwoPrints {
  test::TempFolder folder;
  std::filesystem::path a = folder.path() / "a" / "20261128T120000Z-part",
                        b = folder.path() / "b" / a.filename();
  test::LoneDesk first{a, 77}, second{b, 78};
  Page page{{a.parent_path(), b.parent_path()}}, other{{b.parent_path(), a.parent_path()}};
};

}  // namespace

TEST_CASE("two folders of one name are shown apart, and found by number and place alone") {
  const TwoPrints prints;
  const json runs = json::parse(WebClient(prints.page.address).get("/api/runs").body)["runs"];
  REQUIRE(runs.size() == 2);
  std::map<std::string, std::string> labels;
  for (const json& run : runs) labels[run["id"]] = run["label"];
  const std::string name = prints.a.filename();
  INFO(json(labels).dump());
  CHECK(labels == std::map<std::string, std::string>{
                      {runs::address_of(prints.a).text(), name + " in " + prints.a.parent_path().string()},
                      {runs::address_of(prints.b).text(), name + " in " + prints.b.parent_path().string()}});
  CHECK(WebClient(prints.page.address).get("/api/runs/" + name).status == 404);
  CHECK(WebClient(prints.page.address).open("/command?run=" + name, kToken) == 404);
}

TEST_CASE("an order from either of two pages reaches the print whose address it has") {
  TwoPrints prints;
  std::size_t at_first = 0, at_second = 0;
  for (const std::size_t n : test::long_cases(1000, 100)) {
    RandomStream random(n, Purpose::kTest);
    const bool first = random.below(2) == 0;
    const Page& page = random.below(2) ? prints.page : prints.other;
    (first ? at_first : at_second) += 1;
    CHECK(page.order(runs::address_of(first ? prints.a : prints.b).text(), "pause")["ok"] == true);
    CHECK(prints.first.orders().size() == at_first);
    CHECK(prints.second.orders().size() == at_second);
  }
  CHECK(prints.page.order(runs::address_of(prints.b).text(), "safe_stop")["ok"] == true);
  CHECK(prints.first.orders().size() == at_first);
  CHECK(prints.second.orders().back() == "stop");
}

TEST_CASE("a line for commands whose folder another run has taken obeys nothing") {
  TwoPrints prints;
  WebClient line(prints.page.address);
  REQUIRE(line.open("/command?run=" + runs::address_of(prints.b).text(), kToken) == 101);
  std::filesystem::rename(prints.a, prints.folder.path() / "c");
  std::filesystem::rename(prints.b, prints.a);
  std::filesystem::rename(prints.folder.path() / "c", prints.b);
  line.send(R"({"type":"command","id":1,"command":"safe_stop"})");
  const json answer = json::parse(line.next_of("answer", 10.0).value_or("{}"));
  CHECK(answer["ok"] == false);
  CHECK(answer["error"] == "this print is run 77; the order is for run 78");
  CHECK(prints.first.orders().empty());
}
