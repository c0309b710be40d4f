#include "tests/page/page_attack.h"

#include <unistd.h>

#include <memory>
#include <utility>
#include <vector>

#include "core/grid/random.h"
#include "tests/page/web_client.h"

namespace firn::test {
namespace {

constexpr useconds_t kPause_us = 10'000;

std::string noise(RandomStream& random, std::uint32_t most) {
  std::string bytes(1 + random.below(most), '\0');
  for (char& b : bytes) b = char(random.below(256));
  return bytes;
}

}  // namespace

PageAttack::PageAttack(std::string address, Size size, std::uint64_t seed)
    : address_(std::move(address)), thread_([this, size, seed] { run(size, seed); }) {}

PageAttack::~PageAttack() {
  stop_ = true;
  thread_.join();
}

void PageAttack::wait() const {
  while (!sent_) ::usleep(kPause_us);
}

void PageAttack::run(Size size, std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  std::vector<std::unique_ptr<WebClient>> kept;
  for (int n = 0; n < size.deaf && !stop_; ++n) {
    auto& tab = *kept.emplace_back(std::make_unique<WebClient>(address_));
    if (tab.open("/ws") == 101) tab.send(R"({"type":"follow","surface":"measured"})");
  }
  for (int n = 0; n < size.connections && !stop_; ++n) {
    auto& client = *kept.emplace_back(std::make_unique<WebClient>(address_));
    if (n % 2 == 0) client.send_raw(noise(random, 300));
  }
  // The server closes a tab that does not take its answers, and everything once it is killed.
  WebClient tab(address_);
  bool open = tab.open("/ws") == 101;
  for (int n = 0; n < size.frames && !stop_ && open; ++n) {
    tab.send_frame(1 + int(random.below(2)), noise(random, 100));
    while (tab.next(0.0)) {
    }
    open = !tab.closed();
  }
  sent_ = true;
  while (!stop_) ::usleep(kPause_us);
}

}  // namespace firn::test
