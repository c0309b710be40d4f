// IceBench holds an ice world with its bytes at hand, addressed through the codecs.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/heater/thermostat.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "plant/world/ice_lab.h"
#include "tests/plant/bench_lines.h"
#include "tests/support/ice_paths.h"

namespace firn::plant {

struct IceBench {
  explicit IceBench(const IceWorldConfig& ice, double host_scale = 1.0)
      : world(config_of(ice, host_scale), &record) {
    connect();
  }
  static WorldConfig config_of(const IceWorldConfig& ice, double host_scale) {
    WorldConfig c;
    c.kind = &kIceWorld;
    c.host_scale = host_scale;
    c.ice = ice;
    return c;
  }
  void connect() {
    for (const auto port : kIcePortNames) world.connect(port, now_us);
  }
  void send(std::string_view port, std::span<const std::byte> bytes) { world.receive(port, bytes, now_us); }
  void run(std::int64_t us) {
    now_us += us;
    world.advance(now_us, [&](const World::Sent& s) {
      auto& to = heard[std::string(s.port)];
      to.append(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size());
      closed[std::string(s.port)] |= s.close;
    });
  }
  std::string ask(std::string_view port, std::span<const std::byte> bytes,
                  std::int64_t limit_us = 5'000'000) {
    heard[std::string(port)].clear();
    send(port, bytes);
    const std::int64_t until_us = now_us + limit_us;
    while (heard[std::string(port)].empty() && world.next_event_us() <= until_us)
      run(std::max<std::int64_t>(0, world.next_event_us() - now_us));
    return heard[std::string(port)];
  }
  std::string ask(std::string_view port, std::string_view text, std::int64_t limit_us = 5'000'000) {
    return ask(port, std::as_bytes(std::span(text.data(), text.size())), limit_us);
  }

  /// Returns the robot's reply without its number: "ACK ...".
  std::string robot(std::string_view words) {
    drivers::LineWriter line;
    seq = drivers::fvp::next_seq(seq);
    line.text("@").number(seq).word(words);
    ask(kRobotPort, line.finish(1));
    for (int tries = 0; tries < 100; ++tries) {  // events come in between
      const std::string all = heard[std::string(kRobotPort)];
      for (std::size_t at = 0, end; (end = all.find('\n', at)) != std::string::npos; at = end + 1) {
        const auto m = drivers::fvp::parse(std::string_view(all).substr(at, end + 1 - at));
        if (m.kind == drivers::fvp::Message::Kind::kNumbered && m.seq == seq) return std::string(m.text);
        if (m.kind == drivers::fvp::Message::Kind::kEvent) events.push_back(std::string(m.text));
      }
      run(5000);
    }
    return "no reply";
  }
  drivers::fvp::Status status() {
    const std::string reply = robot("STAT");
    drivers::WordReader words(std::string_view(reply).substr(4));
    return drivers::fvp::parse_status(words).value();
  }
  void home() {
    robot("HELLO FIRN 1");
    robot("POWER 1");
    run(3'100'000);
    robot("CAL");
    run(8'100'000);
  }
  void wait_for_rest() {
    while (status().state == drivers::fvp::State::kRunning) run(50'000);
  }
  void load(std::int32_t id, const std::vector<Joints>& points) {
    std::vector<drivers::fvp::Counts> counts;
    for (const Joints& q : points) counts.push_back(drivers::fvp::counts_of(q));
    robot("PATH BEGIN " + std::to_string(id) + " N=" + std::to_string(counts.size()) + " DT=0.016");
    drivers::fvp::FvpDialect dialect;
    dialect.points = counts;
    seq = drivers::fvp::next_seq(seq);
    std::vector<std::byte> bytes;
    dialect.write(drivers::fvp::path_block(seq, 0, counts.size(), 0), bytes);
    ask(kRobotPort, bytes);
    drivers::fvp::PointsCrc crc;
    for (const auto& c : counts) crc.add(c);
    char hex[5];
    std::snprintf(hex, sizeof hex, "%04X", unsigned(crc.value()));
    end_reply = robot(std::string("PATH END ") + hex);
  }
  void move_to(const Joints& q) {
    drivers::LineWriter line;
    drivers::fvp::put(line, drivers::fvp::counts_of(q));
    move_reply = robot("MOVEJ" + std::string(line.so_far()) + " 50");
    wait_for_rest();
  }

  drivers::fvb::Found valve(std::string_view port, const std::vector<std::byte>& bytes) {
    valve_reply = ask(port, bytes);
    return drivers::fvb::find(std::as_bytes(std::span(valve_reply.data(), valve_reply.size())));
  }
  std::uint8_t next() { return vseq = drivers::fvb::next_seq(vseq); }
  /// 0 = acknowledged
  int order(std::string_view port, drivers::fvb::Type type, std::span<const std::byte> payload = {}) {
    std::vector<std::byte> bytes;
    drivers::fvb::encode(type, next(), payload, bytes);
    const auto reply = drivers::fvb::parse_reply(valve(port, bytes));
    return !reply ? -1 : reply->type == drivers::fvb::Type::kAck ? 0 : reply->refusal;
  }
  int arm(std::string_view port) {
    const std::byte wait[4] = {};
    return order(port, drivers::fvb::Type::kArm, wait);
  }
  int load_list(std::string_view port, std::uint32_t path, const std::vector<std::uint16_t>& ticks) {
    using namespace drivers::fvb;
    std::vector<std::byte> bytes;
    encode(next(),
           Begin{path, std::uint8_t(port == kValveAPort ? 1 : 2), std::uint16_t(ticks.size()), 2000, 1250},
           bytes);
    if (parse_reply(valve(port, bytes))->type != Type::kAck) return -2;
    for (std::size_t at = 0; at < ticks.size(); at += kEntriesPerFrame) {
      bytes.clear();
      encode_data(next(), std::uint16_t(at),
                  std::span(ticks).subspan(at, std::min(kEntriesPerFrame, ticks.size() - at)), bytes);
      const auto reply = parse_reply(valve(port, bytes));
      if (reply->type != Type::kAck) return reply->refusal;
    }
    const std::uint16_t crc = list_crc(ticks);
    const std::byte payload[2] = {std::byte(crc & 255), std::byte(crc >> 8)};
    return order(port, Type::kEnd, payload);
  }
  drivers::fvb::Status valve_status(std::string_view port) {
    std::vector<std::byte> bytes;
    drivers::fvb::encode(drivers::fvb::Type::kStatus, next(), {}, bytes);
    return drivers::fvb::parse_status(valve(port, bytes).payload).value();
  }
  void hello(std::string_view port) {
    std::vector<std::byte> bytes;
    drivers::fvb::encode(drivers::fvb::Type::kHello, next(), {}, bytes);
    valve(port, bytes);
  }
  IceTruth truth() const { return world.ice()->ice_truth(); }
  std::string laser(std::string_view command) {
    return ask(kLaserPointPort, std::string(command) + "\r", 20'000'000);
  }

  MemoryRecord record;
  World world;
  std::int64_t now_us = 0, seq = 0;
  std::uint8_t vseq = 0;
  std::map<std::string, std::string> heard;
  std::map<std::string, bool> closed;
  std::string valve_reply, end_reply, move_reply;
  std::vector<std::string> events;  ///< of the robot, that came before a reply
};

inline IceWorldConfig small() {
  IceWorldConfig c;
  c.field = {0.3, -25.0, -25.0, 50.0, 50.0};
  return c;
}

inline ice_paths::Run line_of(const IceWorldConfig& c, double y_mm = 0.0, double z_mm = 3.24,
                              double speed = 60.0) {
  return ice_paths::along(
      c.arm, c.arm.valve_a, {{-15.0, y_mm}, {15.0, y_mm}}, z_mm, speed, 1.5, [](double) { return 0.25; },
      ice_paths::calibrated_late_s(c, 0) - c.valve[0].trigger_delay_s);
}

/// Ready to run path 7 with valve_a's list armed.
inline void prepare(IceBench& b, const ice_paths::Run& run) {
  b.home();
  b.hello(kValveAPort);
  if (b.load_list(kValveAPort, 7, run.ticks) != 0) throw std::logic_error("the valve does not take the list");
  b.load(7, run.points);
  if (b.end_reply != "ACK " + std::to_string(run.points.size()))
    throw std::logic_error("the robot does not take the path");
  b.move_to(run.points.front());
  if (b.arm(kValveAPort) != 0) throw std::logic_error("the valve does not arm");
}

}  // namespace firn::plant
