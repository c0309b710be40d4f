#include "core/control/forwarding_controller.h"

#include <catch2/catch.hpp>

#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "core/control/layer_bound.h"
#include "core/control/stall_bound.h"

using namespace firn;
using namespace firn::control;

namespace {

class Heard final : public LayerController {
 public:
  explicit Heard(std::vector<std::string>& calls) : calls_(calls) {}
  Decision decide(const Measurement&) override {
    calls_.push_back("decide");
    return {};
  }
  void use_model(const deposition::DropletModel&) override { calls_.push_back("use_model"); }
  void use_models(const deposition::DropletModel&, const deposition::DropletModel&) override {
    calls_.push_back("use_models");
  }
  void use_threads(const ParallelFor&) override { calls_.push_back("use_threads"); }
  void use_options(const ControlOptions&) override { calls_.push_back("use_options"); }

 private:
  std::vector<std::string>& calls_;
};

}  // namespace

TEST_CASE("a scheme in every wrapper hears each call once, and nothing else") {
  Setup setup;
  setup.grid = {4, 3, 0.5, 0.5, 0.0, 0.0};
  setup.target = HeightMap(setup.grid, 0.1);
  setup.mask = Mask(setup.grid, 1);
  const ControlOptions options;
  std::vector<std::string> calls;
  const auto wrapped = with_layer_bound(
      std::make_unique<StallBound>(std::make_unique<Heard>(calls), setup, options), setup, options);
  wrapped->use_model(setup.model);
  wrapped->use_models(setup.model, setup.model);
  wrapped->use_threads(serially);
  wrapped->use_options(options);
  wrapped->decide({HeightMap(setup.grid, 0.0), 0, 0, 0.0});
  CHECK(calls == std::vector<std::string>{"use_model", "use_models", "use_threads", "use_options", "decide"});
}

// A default there would let a wrapper compile that forgets to forward.
TEST_CASE("no function of the interface of schemes has a default") {
  std::ifstream file(FIRN_SOURCE_DIR "/core/control/controller.h");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t begin = text.find("class LayerController {"), end = text.find("};", begin);
  REQUIRE(end != std::string::npos);
  const std::string body = text.substr(begin, end - begin);
  const std::regex any("\\bvirtual\\b"), pure("\\bvirtual [^;{]*\\) = 0;");
  const auto count = [&](const std::regex& r) {
    return std::distance(std::sregex_iterator(body.begin(), body.end(), r), std::sregex_iterator());
  };
  CHECK(count(pure) == 5);
  CHECK(count(any) == count(pure) + 1);  // and the destructor
}
