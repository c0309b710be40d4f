#include "tests/page/page_attack.h"

#include <sys/resource.h>
#include <unistd.h>

#include <memory>
#include <utility>
#include <vector>

#include "core/grid/random.h"
#include "tests/page/web_client.h"

namespace firn::test {
namespace {

constexpr useconds_t kPause_us = 10'000;
constexpr int kMaxRefused = 100;
constexpr int kAttackersNice = 19;

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

void PageAttack::wait(std::int64_t frames) const {
  while (!over_ && frames_ < frames) ::usleep(kPause_us);
}

void PageAttack::run(Size size, std::uint64_t seed) {
  ::setpriority(PRIO_PROCESS, 0, kAttackersNice);  // of this thread: it stands for a machine elsewhere
  RandomStream random(seed, Purpose::kTest);
  auto tab = std::make_unique<WebClient>(address_);  // before the page is full
  bool open = tab->open("/ws") == 101;
  std::vector<std::unique_ptr<WebClient>> kept;
  for (int n = 0; n < size.deaf && !stop_; ++n) {
    auto& watcher = *kept.emplace_back(std::make_unique<WebClient>(address_));
    if (watcher.open("/ws") == 101) watcher.send(R"({"type":"follow","surface":"measured"})");
  }
  for (int n = 0; n < size.connections && !stop_; ++n) {
    auto& client = *kept.emplace_back(std::make_unique<WebClient>(address_));
    if (n % 2 == 0) client.send_raw(noise(random, 300));
  }
  // A tab that does not take its answers is closed: another goes on. A page that is killed lets none in.
  for (int refused = 0; frames_ < size.frames && !stop_ && refused < kMaxRefused;) {
    if (!open || tab->closed()) {
      tab = std::make_unique<WebClient>(address_);
      open = tab->open("/ws") == 101;
      refused = open ? 0 : refused + 1;
      continue;
    }
    tab->send_frame(1 + int(random.below(2)), noise(random, 100));
    while (tab->next(0.0)) {
    }
    ++frames_;
  }
  over_ = true;
  while (!stop_) ::usleep(kPause_us);
}

}  // namespace firn::test
