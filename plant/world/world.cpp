#include "plant/world/world.h"

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "files/record/checksum.h"
#include "files/record/file.h"
#include "files/record/open_file.h"
#include "plant/world/world_lab.h"

namespace firn::plant {
namespace {

std::size_t port_of(const WorldLab& lab, std::string_view name) {
  for (std::size_t n = 0; n < lab.ports().size(); ++n)
    if (lab.ports()[n] == name) return n;
  std::string known;
  for (const std::string_view port : lab.ports()) known += (known.empty() ? "" : " ") + std::string(port);
  throw std::invalid_argument("world: unknown port \"" + std::string(name) + "\"; known: " + known);
}

std::unique_ptr<WorldLab> make_lab(const WorldConfig& config, WorldRecord* record) {
  check(config);
  std::unique_ptr<WorldLab> lab = config.kind->make(config, record);
  for (Twin* twin : lab->twins) twin->link().speed_up(config.line_speed);
  return lab;
}

}  // namespace

World::World(const WorldConfig& config, WorldRecord* record) : impl_(make_lab(config, record)) {
  impl_->begin(false);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

void World::connect(std::string_view port, std::int64_t now_us) {
  const std::size_t n = port_of(*impl_, port);
  impl_->run_until(now_us);
  impl_->drop_link(n, now_us);
  impl_->twins[n]->link().connect(now_us);
  impl_->twins[n]->connected(now_us);
  impl_->write(RecordKind::kLink, LinkRecord{now_us, impl_->port_at(n), 1, 0, {}});
}

void World::disconnect(std::string_view port, std::int64_t now_us) {
  const std::size_t n = port_of(*impl_, port);
  impl_->run_until(now_us);
  impl_->drop_link(n, now_us);
}

void World::receive(std::string_view port, std::span<const std::byte> bytes, std::int64_t now_us) {
  const std::size_t n = port_of(*impl_, port);
  impl_->run_until(now_us);
  Twin& twin = *impl_->twins[n];
  if (!twin.link().connected()) return;
  twin.link().hear(bytes, impl_->now_us);
  if (twin.link().serial())
    twin.link().arrive(bytes, impl_->now_us);
  else if (!twin.link().hung() && !twin.link().half_open())
    twin.take(bytes, impl_->now_us);
}

void World::inject(const SimFault& fault, std::int64_t now_us) {
  const std::size_t n = port_of(*impl_, fault.port);
  impl_->run_until(now_us);
  Twin& twin = *impl_->twins[n];
  const bool was_connected = twin.link().connected();
  if (fault.kind == FaultKind::kTrip) return twin.trip(now_us, fault.count);
  if (fault.kind == FaultKind::kReboot || fault.kind == FaultKind::kPower) {
    twin.reboot(now_us);
    if (fault.kind == FaultKind::kReboot || !twin.link().serial()) twin.link().close(now_us);
  } else {
    twin.link().inject(fault, now_us);
  }
  if (was_connected && !twin.link().connected()) {
    twin.disconnected(now_us);
    impl_->note_closed(now_us, impl_->port_at(n));
  }
}

void World::lose_power() {
  impl_->begin(true);
  for (std::size_t n = 0; n < impl_->twins.size(); ++n) {
    impl_->drop_link(n, impl_->now_us);
    impl_->twins[n]->reboot(impl_->now_us);
  }
}

std::int64_t World::next_event_us() const {
  std::int64_t next = kNever;
  const bool all = impl_->pulses_speak();
  for (const Twin* twin : impl_->twins)
    next = std::min(
        next, all ? std::min(twin->next_inner_us(), twin->link().next_send_us()) : twin->next_visible_us());
  return next;
}

std::int64_t World::next_inner_us() const {
  std::int64_t next = next_event_us();
  for (const Twin* twin : impl_->twins) next = std::min(next, twin->next_inner_us());
  return next;
}

void World::advance(std::int64_t now_us, const SendFn& send) {
  impl_->run_until(now_us);
  for (;;) {
    std::size_t first = 0;
    for (std::size_t n = 1; n < impl_->twins.size(); ++n)
      if (impl_->twins[n]->link().next_send_us() < impl_->twins[first]->link().next_send_us()) first = n;
    TwinLink& link = impl_->twins[first]->link();
    if (link.next_send_us() > now_us || link.next_send_us() == kNever) break;
    const TwinLink::Chunk chunk = link.pop_send();
    send({impl_->ports()[first], chunk.t_us, std::as_bytes(std::span(chunk.bytes)), chunk.close != 0});
  }
}

Truth World::truth() const { return impl_->truth(); }
MaterialColumns World::materials() const { return impl_->materials(); }
std::uint32_t World::exposures() const { return impl_->milestones(); }
std::int64_t World::now_us() const { return impl_->now_us; }
std::span<const std::string_view> World::ports() const { return impl_->ports(); }
const IceLab* World::ice() const { return impl_->ice(); }
const WorldConfig& World::config() const { return impl_->config; }

void World::save(const std::filesystem::path& path) const {
  if (impl_->record) impl_->record->flush();
  Archive archive;
  impl_->io(archive);
  std::vector<std::byte> bytes = archive.bytes();
  const std::uint64_t sum = record::checksum64(bytes);
  const auto tail = std::as_bytes(std::span(&sum, 1));
  bytes.insert(bytes.end(), tail.begin(), tail.end());

  const std::filesystem::path temporary = path.string() + ".new";
  const auto fail = [&](const char* what) {
    throw std::runtime_error("world state: cannot " + std::string(what) + " " + temporary.string() + ": " +
                             std::strerror(errno));
  };
  const record::FolderOfFile folder(path);
  const record::OpenedFile opened = folder.open(folder.name() + ".new", O_WRONLY | O_CREAT | O_TRUNC, 0666);
  const int fd = opened.fd;
  errno = opened.error;
  if (fd < 0) fail("create");
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno != EINTR) {
      ::close(fd);
      fail("write");
    }
    if (n > 0) done += std::size_t(n);
  }
  if (::fsync(fd) != 0) {
    ::close(fd);
    fail("sync");
  }
  ::close(fd);
  errno = folder.take_place(folder.name() + ".new");
  if (errno != 0) fail("rename");
}

World World::restore(const std::filesystem::path& path, const WorldConfig& config, WorldRecord* record,
                     bool links_kept) {
  const record::MappedFile file(path);
  const auto all = file.bytes();
  std::uint64_t sum = 0;
  if (all.size() < sizeof sum) throw std::runtime_error("world state: " + path.string() + " is cut short");
  std::memcpy(&sum, all.data() + all.size() - sizeof sum, sizeof sum);
  const auto body = all.first(all.size() - sizeof sum);
  if (record::checksum64(body) != sum)
    throw std::runtime_error("world state: " + path.string() + " is damaged (checksum)");
  World world(config, nullptr);
  Archive archive(std::vector<std::byte>(body.begin(), body.end()));
  world.impl_->io(archive);
  world.impl_->record = record;
  world.impl_->begin(true);
  for (std::size_t n = 0; n < world.ports().size() && !links_kept; ++n)
    world.impl_->drop_link(n, world.impl_->now_us);
  return world;
}

}  // namespace firn::plant
