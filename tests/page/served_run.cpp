#include "tests/page/served_run.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <future>

#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/run_folder.h"
#include "tests/support/tiny_print.h"

namespace firn::test {

std::string print_into(const std::filesystem::path& runs) {
  const Experiment e = tiny_print("page");
  const runs::RunFolder run = runs::RunFolder::create(runs, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  o.note = [](const std::string&) {};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  return run.path().filename();
}

Served::Served(const std::function<void(page::ServerOptions&)>& change) {
  id = print_into(place.path() / "runs");
  REQUIRE(::pipe(stop_) == 0);
  options.places = {place.path() / "runs"};
  options.token = "secret";
  options.stop_fd = stop_[0];
  if (change) change(options);
  std::promise<std::string> listening;
  options.listening = [&](const std::string& at) { listening.set_value(at); };
  thread_ = std::thread([this] { page::serve(full_product(), options); });
  address = listening.get_future().get();
}

Served::~Served() {
  if (::write(stop_[1], "x", 1) == 1) thread_.join();
  ::close(stop_[0]);
  ::close(stop_[1]);
}

}  // namespace firn::test
