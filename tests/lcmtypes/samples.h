// Returns messages within their limits, with every member set, and their bytes.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "firn/all_types.h"

namespace firn::test {

template <class M>
std::vector<std::byte> encode(const M& message) {
  std::vector<std::byte> bytes(std::size_t(message.getEncodedSize()));
  message.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

inline header_t some_header() {
  header_t h{};
  h.run_id = 0x123456789abcdef;
  h.incarnation = 2;
  h.seq = 41;
  h.utime_us = 7'000'000;
  return h;
}

inline grid_t some_grid(int nx, int ny) {
  grid_t g{};
  g.nx = nx;
  g.ny = ny;
  g.pitch_x_mm = g.pitch_y_mm = 0.263256;
  g.origin_x_mm = -5;
  g.origin_y_mm = 3;
  return g;
}

inline height_map_t some_height_map(int nx, int ny) {
  height_map_t m{};
  m.header = some_header();
  m.n = nx * ny;
  m.layer = 7;
  m.map_id = 9;
  m.sample_utime_us = 6'900'000;
  m.grid = some_grid(nx, ny);
  m.noise_std_mm = 0.001;
  m.measured_fraction = 0.98;
  for (int c = 0; c < m.n; ++c) {
    m.height_mm.push_back(c % 5 == 3 ? NAN : 0.01F * float(c));
    m.quality.push_back(std::int8_t(c % 3));
  }
  return m;
}

inline layer_plan_t some_layer_plan(int nx, int ny) {
  layer_plan_t p{};
  p.header = some_header();
  p.n = nx * ny;
  p.layer = 8;
  p.map_id = 9;
  p.passes = 3;
  p.grid = some_grid(nx, ny);
  p.objective_mm = 0.25;
  p.objective_none_mm = 0.5;
  p.iterations = 1600;
  p.reason = "the surface is \"low\" at x > 3 \u00b5m";
  for (int c = 0; c < p.n; ++c) p.drops.push_back(std::int8_t(c % 4));
  return p;
}

inline stage_command_t some_pass(int nx, int ny) {
  stage_command_t s{};
  s.header = some_header();
  s.n = nx * ny;
  s.command_id = 12;
  s.enable_epoch = 1;
  s.verb = 1;
  s.layer = 8;
  s.pass_index = 1;
  s.z_mm = 1;
  s.speed_mm_s = 40;
  s.grid = some_grid(nx, ny);
  s.fires.assign(std::size_t(s.n), 1);
  return s;
}

inline heartbeat_t some_heartbeat() {
  heartbeat_t h{};
  h.header = some_header();
  h.node = "jet";
  h.state = 1;
  h.n = 3;
  h.channel = {"ANSWER_JET", "STATE_JET", "FAULT_JET"};
  h.last_seq = {4, 5, 0};
  return h;
}

}  // namespace firn::test
