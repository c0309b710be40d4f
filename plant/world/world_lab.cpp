#include "plant/world/world_lab.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace firn::plant {
namespace {

// Parameters on which a saved state and the configuration must agree.
std::string fingerprint(const WorldConfig& c) {
  char text[320];
  const GridSpec& g = c.grid;
  std::snprintf(text, sizeof text, "%s %llu %d %d %a %a %a %a %d %d %d %d", c.model.c_str(),
                static_cast<unsigned long long>(c.seed), g.nx, g.ny, g.pitch_x_mm, g.pitch_y_mm,
                g.origin_x_mm, g.origin_y_mm, c.droplet.fine_cells, c.droplet.margin_cells, c.profiler.points,
                int(c.two_inks));
  return text + c.kind->fingerprint(c);
}

}  // namespace

Port WorldLab::port_at(std::size_t n) const {
  return std::ranges::find(kPorts, ports()[n], &PortRow::name)->port;
}

void WorldLab::run_until(std::int64_t t_us) {
  for (;;) {
    Twin* first = nullptr;
    std::int64_t at_us = kNever;
    for (Twin* twin : twins)
      if (const std::int64_t next = twin->next_inner_us(); next < at_us) {
        first = twin;
        at_us = next;
      }
    if (!first || at_us > t_us) break;
    catch_up(at_us);
    first->step();
  }
  catch_up(std::max(now_us, t_us));
  now_us = std::max(now_us, t_us);
}

void WorldLab::begin(bool restored) {
  write(RecordKind::kBegin, BeginRecord{now_us, begun_with(), milestones(), restored ? 1u : 0u});
  if (record) record->flush();
}

void WorldLab::drop_link(std::size_t port, std::int64_t t_us) {
  if (!twins[port]->link().connected()) return;
  twins[port]->link().disconnect();
  twins[port]->disconnected(t_us);
  write(RecordKind::kLink, LinkRecord{t_us, port_at(port), 0, 0, {}});
}

void WorldLab::io(Archive& a) {
  a.tag(0x4e524946, "the head");  // "FIRN"
  std::string print = fingerprint(config);
  a(print);
  if (print != fingerprint(config))
    throw std::runtime_error("world state: of another configuration: \"" + print + "\", not \"" +
                             fingerprint(config) + "\"");
  a(now_us);
  io_plant(a);
  for (std::size_t n = 0; n < twins.size(); ++n) {
    a.tag(std::uint32_t(2 + n), ports()[n].data());
    twins[n]->io(a);
  }
  a.expect_end();
}

}  // namespace firn::plant
