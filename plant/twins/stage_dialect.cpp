#include "plant/twins/stage_dialect.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/options/number.h"

namespace firn::plant {
namespace {

using Answer = StageDevice::Answer;

/// Words of a line: split at blanks, commas, brackets and '='; letters in capitals.
struct Words {
  static constexpr int kMax = 12;
  std::array<std::string_view, kMax> word;
  int count = 0;
  bool assigns = false, too_many = false;
  std::array<char, 256> buffer;

  explicit Words(std::string_view line) {
    std::size_t used = 0, begin = 0;
    bool quoted = false;
    const auto end_word = [&] {
      if (used > begin) {
        if (count == kMax)
          too_many = true;
        else
          word[std::size_t(count++)] = {buffer.data() + begin, used - begin};
      }
      begin = used;
    };
    for (char c : line) {
      if (c == '"') quoted = !quoted;
      if (c == '=' && !quoted) assigns = true;
      if (!quoted && (c == ' ' || c == '\t' || c == ',' || c == '(' || c == ')' || c == '=' || c == '\r')) {
        end_word();
        continue;
      }
      if (used == buffer.size()) {
        too_many = true;
        break;
      }
      buffer[used++] = c >= 'a' && c <= 'z' ? char(c - 32) : c;
    }
    end_word();
  }
  std::string_view operator[](int n) const { return n < count ? word[std::size_t(n)] : std::string_view{}; }
};

bool number(std::string_view text, double& value) {
  const std::optional<double> read = whole_number<double>(text);
  value = read.value_or(value);
  return read.has_value();
}

/// "@0".."@2" or X, Y, Z; -1 = no axis.
int axis_of(std::string_view text) {
  if (text.size() == 2 && text[0] == '@' && text[1] >= '0' && text[1] <= '2') return text[1] - '0';
  if (text.size() == 1 && text[0] >= 'X' && text[0] <= 'Z') return text[0] - 'X';
  return -1;
}

std::string text_of(Answer a) { return a == Answer::kOk ? "%\n" : a == Answer::kNak ? "!\n" : "#\n"; }

StageReply integer(std::int64_t value) {
  char out[32] = {'%'};
  char* end = std::to_chars(out + 1, out + 30, value).ptr;
  *end++ = '\n';
  return {std::string(out, end)};
}

/// Six decimals, without the cost of printf.
StageReply decimal(double value) {
  const std::int64_t micro = std::llround(value * 1e6);
  char out[40] = {'%'};
  char* end = out + 1;
  if (micro < 0) *end++ = '-';
  const std::uint64_t size = std::uint64_t(micro < 0 ? -micro : micro);
  end = std::to_chars(end, out + 28, size / 1000000).ptr;
  *end++ = '.';
  std::uint64_t rest = size % 1000000;
  for (std::uint64_t unit = 100000; unit > 0; unit /= 10) *end++ = char('0' + rest / unit % 10);
  *end++ = '\n';
  return {std::string(out, end)};
}

StageReply move_command(StageDevice& d, const Words& w, std::int64_t now_us) {
  Vec3 target{NAN, NAN, NAN};
  double speed = NAN;
  for (int n = 1; n < w.count;) {
    const int axis = axis_of(w[n]);
    if (axis >= 0) {
      if (!number(w[n + 1], target[std::size_t(axis)])) return {"!\n"};
      n += 2;
    } else if (w[n].size() > 1 && w[n][0] == 'F') {
      if (!number(w[n].substr(1), speed)) return {"!\n"};
      n += 1;
    } else if (w[n] == "F" || (w[n].ends_with('F') && axis_of(w[n].substr(0, w[n].size() - 1)) >= 0)) {
      if (!number(w[n + 1], speed)) return {"!\n"};
      n += 2;
    } else if (const auto f = w[n].find('F'); f <= 2 && axis_of(w[n].substr(0, f)) >= 0) {
      if (!number(w[n].substr(f + 1), speed)) return {"!\n"};
      n += 1;
    } else {
      return {"!\n"};
    }
  }
  const bool absolute = d.absolute() || w[0] == "MOVEABS";
  const Answer a = absolute ? d.linear(target, speed, now_us) : d.linear_by(target, speed, now_us);
  return {text_of(a), a == Answer::kOk};
}

StageReply iglobal(StageDevice& d, const Words& w, std::int64_t now_us) {
  d.record_samples(now_us);
  double index = -1, value = 0;
  if (!number(w[1], index) || index < 0 || index >= d.params().global_integers || index != std::floor(index))
    return {"!\n"};
  double& cell = d.iglobals()[std::size_t(index)];
  if (!w.assigns) return w.count == 2 ? integer(std::int64_t(cell)) : StageReply{"!\n"};
  if (w.count != 3 || !number(w[2], value) || value != std::floor(value) || std::abs(value) > 2147483647.0)
    return {"!\n"};
  cell = value;
  return {"%\n"};
}

StageReply dglobal(StageDevice& d, const Words& w, std::int64_t now_us) {
  d.record_samples(now_us);
  double index = -1, value = 0;
  if (!number(w[1], index) || index < 0 || index >= kDglobals || index != std::floor(index)) return {"!\n"};
  double& cell = d.dglobals()[std::size_t(index)];
  if (!w.assigns) return w.count == 2 ? decimal(cell) : StageReply{"!\n"};
  if (w.count != 3 || !number(w[2], value)) return {"!\n"};
  cell = value;
  return {"%\n"};
}

StageReply pso_control(StageDevice& d, Pso& p, int axis, const Words& w, std::int64_t now_us) {
  if (w[2] == "RESET") {
    d.pso_off(axis, now_us);
    p = {};
  } else if (w[2] == "ARM") {
    return {text_of(d.arm(axis, now_us))};
  } else if (w[2] == "OFF") {
    d.pso_off(axis, now_us);
  } else {
    return {"!\n"};
  }
  return {"%\n"};
}

StageReply pso_array(StageDevice& d, Pso& p, const Words& w) {
  double first = 0, count = 0;
  if (!number(w[2], first) || !number(w[3], count) || first < 0 || count < 1 || count > 8192 ||
      first + count > d.params().global_integers)
    return {"!\n"};
  std::vector<std::int64_t> increments;
  for (int n = 0; n < int(count); ++n)
    increments.push_back(std::int64_t(d.iglobals()[std::size_t(first) + std::size_t(n)]));
  for (const std::int64_t n : increments)
    if (n < 1) return {"!\n"};
  p.increments = std::move(increments);
  return {"%\n"};
}

StageReply pso_distance(const StageDevice& d, Pso& p, const Words& w) {
  if (w[2] == "ARRAY") {
    p.mode = Pso::Mode::kArray;
    return {"%\n"};
  }
  double distance = 0;
  if (w[2] != "FIXED" || !number(w[3], distance)) return {"!\n"};
  const double counts = w[4] == "UNITS" ? distance * d.params().counts_per_mm : distance;
  if (!(counts >= 1.0 && counts < 1e12)) return {"!\n"};
  p.mode = Pso::Mode::kFixed;
  p.fixed_counts = std::llround(counts);
  return {"%\n"};
}

StageReply pso_window(Pso& p, const Words& w) {
  if (w[2] != "1") return {"!\n"};
  if (w[3] == "OFF")
    p.window = false;
  else if (w[3] == "INPUT")
    return {"%\n"};
  else if (w[3] == "RANGE" && number(w[4], p.window_low_mm) && number(w[5], p.window_high_mm))
    p.window = true;
  else
    return {"!\n"};
  return {"%\n"};
}

StageReply pso_command(StageDevice& d, const Words& w, std::int64_t now_us) {
  const int axis = axis_of(w[1]);
  if (axis < 0) return {"!\n"};
  Pso& p = d.pso(axis);
  const std::string_view verb = w[0].substr(3);
  if (verb == "CONTROL") return pso_control(d, p, axis, w, now_us);
  if (w[0] == d.params().pulse_counter) return integer(p.pulses);
  if (verb == "DISTANCE") return pso_distance(d, p, w);
  if (verb == "ARRAY") return pso_array(d, p, w);
  if (verb == "WINDOW") return pso_window(p, w);
  if (verb == "OUTPUT" && w[2] == "TOGGLE") {
    p.output = p.toggle = true;
    p.masked = false;
    return {w.count == 3 ? "%\n" : "!\n"};
  }
  if (verb == "OUTPUT" && w[2] == "PULSE") {
    p.output = true;
    p.toggle = false;
    p.masked = w[3] == "WINDOW" && w[4] == "MASK";
    return {w.count == 3 || p.masked ? "%\n" : "!\n"};
  }
  double a = 0, b = 0;
  if (verb == "OUTPUT" && w[2] == "CONTROL" && number(w[3], a)) {
    p.terminal = true;
    return {"%\n"};
  }
  if (verb == "PULSE" && w[2] == "TIME" && number(w[3], a) && number(w[4], b) && a > 0 && b > 0 && b <= a)
    return {"%\n"};
  if (verb == "TRACK" && (w[2] == "INPUT" || w[2] == "DIRECTION") && number(w[3], a)) {
    if (w[2] == "INPUT") p.vector = axis == 0 && number(w[4], b);
    return {"%\n"};
  }
  return {"!\n"};
}

StageReply axis_query(StageDevice& d, std::string_view verb, int axis, std::int64_t now_us) {
  if (verb == "AXISSTATUS") return integer(std::int32_t(d.axis_status(axis, now_us)));
  if (verb == "AXISFAULT") return integer(std::int32_t(d.axis_fault(axis)));
  if (verb == "VFBK") return decimal(d.velocity_mm_s(axis, now_us));
  return decimal(d.feedback_mm(now_us)[std::size_t(axis)]);
}

}  // namespace

StageReply execute(StageDevice& d, std::string_view line, std::int64_t now_us) {
  const Words w(line);
  const std::string_view verb = w[0];
  if (w.count == 0 || w.too_many) return {"!\n"};
  if (verb == "LINEAR" || verb == "MOVEABS") return move_command(d, w, now_us);
  if (verb == "IGLOBAL") return iglobal(d, w, now_us);
  if (verb == "DGLOBAL") return dglobal(d, w, now_us);
  if (verb.starts_with("PSO")) return pso_command(d, w, now_us);
  if (verb == "PLANESTATUS") return integer(d.moving() ? 1 : 0);
  if (verb == "TASKSTATE") return integer(w[1] == "5" ? d.task_state() : 1);
  if (verb == "WAIT" && w[1] == "MODE") {
    if (w[2] == "NOWAIT") return {"%\n", false, 0};
    if (w[2] == "MOVEDONE" || w[2] == "INPOS") return {"%\n", false, 1};
    return {"!\n"};
  }
  if (verb == "VERSION") return {"%4.07.001\n"};
  double value = 0;
  if (verb == "RAMP" && w[1] == "RATE") return {number(w[2], value) && d.set_ramp(value) ? "%\n" : "!\n"};
  if (verb == "ACKNOWLEDGEALL") {
    for (const int axis : {0, 1, 2}) d.fault_acknowledge(axis);
    return {"%\n"};
  }
  if (verb == "SCURVE") return {number(w[1], value) && d.set_scurve(value) ? "%\n" : "!\n"};
  if (verb == "RAMP" && w[1] == "MODE") return {w[w.count - 1] == "RATE" ? "%\n" : "!\n"};
  if (verb == "PROGRAM" && w[1] == "RUN" && w[3] == "\"HOMEASYNC.BCX\"")
    return {text_of(d.home_by_program(now_us))};
  if (verb == "PROGRAM" && w[1] == "RUN" && w[3] == "\"FIRNPATH.BCX\"")
    return {text_of(d.follow_path(now_us))};
  if (verb == "PROGRAM" && w[1] == "STOP") {
    d.stop_program(now_us);
    return {"%\n"};
  }
  if (verb == "ABS" || verb == "INC") {
    if (w.count != 1) return {"!\n"};
    d.set_absolute(verb == "ABS");
    return {"%\n"};
  }
  if (verb == "ABORT") {  // with or without axes: the moves are coordinated, so all stop
    for (int n = 1; n < w.count; ++n)
      if (axis_of(w[n]) < 0) return {"!\n"};
    d.abort(now_us);
    return {"%\n"};
  }
  const int axis = axis_of(w[1]);
  if (axis < 0) return {"!\n"};
  static constexpr std::array<std::string_view, 8> kQuestions{"AXISSTATUS", "AXISFAULT", "VFBK", "PFBKPROG",
                                                              "PCMDPROG",   "CMDPOS",    "PFBK", "PFBKCAL"};
  if (std::ranges::find(kQuestions, verb) != kQuestions.end()) return axis_query(d, verb, axis, now_us);
  if (verb == "FREERUN" && number(w[2], value) && value == 0.0) {  // ends a jog; others are not simulated
    d.abort(now_us);
    return {"%\n"};
  }
  if (verb == "GETPARM") {
    const auto held = number(w[2], value) ? d.parameter(axis, int(value)) : std::nullopt;
    return held ? decimal(*held) : StageReply{"!\n"};
  }
  if (verb == "ENABLE") return {text_of(d.enable(axis))};
  if (verb == "DISABLE") {
    d.disable(axis, now_us);
    return StageReply{"%\n"};
  }
  if (verb == "FAULTACK") {
    d.fault_acknowledge(axis);
    return StageReply{"%\n"};
  }
  if (verb == "HOME") {
    unsigned axes = 0;
    for (int n = 1; n < w.count; ++n) {
      if (axis_of(w[n]) < 0) return {"!\n"};
      axes |= 1u << axis_of(w[n]);
    }
    const Answer a = d.home(axes, now_us);
    return {text_of(a), a == Answer::kOk, -1, d.params().home_blocks};
  }
  return {"!\n"};
}

// The device behind its port.

StageTwin::StageTwin(const StageParams& params, Wires& wires)
    : Twin(Port::kStage, TwinLink(0.0, params.latency_us)), device_(params, wires), wires_(wires) {}

void StageTwin::disconnected(std::int64_t now_us) {
  line_.clear();
  wait_for_motion_ = true;
  blocked_ = false;
  device_.link_lost(now_us);
}

void StageTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  last_heard_us_ = now_us;
  line_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  interpret(now_us);
}

void StageTwin::interpret(std::int64_t now_us) {
  std::size_t begin = 0;
  while (!blocked_) {
    const std::size_t end = line_.find('\n', begin);
    if (end == std::string::npos) break;
    StageReply reply = execute(device_, std::string_view(line_).substr(begin, end - begin), now_us);
    begin = end + 1;
    if (reply.wait_mode >= 0) wait_for_motion_ = reply.wait_mode == 1;
    if (reply.started_motion && (wait_for_motion_ || reply.blocks) && device_.moving())
      blocked_ = true;
    else
      link_.reply(reply.text, now_us);
  }
  line_.erase(0, begin);
  constexpr std::size_t kLongestLine = 1 << 16;
  if (line_.size() > kLongestLine && line_.find('\n') == std::string::npos) line_.clear();
}

std::int64_t StageTwin::idle_close_us() const {
  return device_.params().idle_close_us > 0 && link_.connected()
             ? last_heard_us_ + device_.params().idle_close_us
             : kNever;
}

std::int64_t StageTwin::next_device_us() const { return std::min(device_.next_us(), idle_close_us()); }

void StageTwin::device_event(std::int64_t now_us) {
  if (device_.next_us() <= now_us) {
    device_.event(now_us);
    if (blocked_ && !device_.moving()) {
      blocked_ = false;
      link_.reply("%\n", now_us);
      interpret(now_us);
    }
    return;
  }
  link_.close(now_us);
  wires_.link_closed(now_us, port_);
  disconnected(now_us);
}

void StageTwin::trip(std::int64_t now_us, std::int64_t code) {
  if (code == 2) return device_.lose_count();
  if (code == 0 || code == 3) device_.stick(code == 3, now_us);
  if (code == 0 || code == 4) device_.refuse_enable(code == 4);
  if (code == 0 || code == 5) device_.mute_pulses(code == 5);
  if (code == 0 || code == 6) device_.cross_encoder(code == 6);
  if (code == 0 || code == 8) device_.break_program(code == 8);
  if (code == 0 || code == 7) device_.jam_shutter(code == 7);
  if (code == 0 || code == 9) device_.drag(code == 9, now_us);
  if (code == 0 || code == 10) device_.stick_encoder(code == 10, now_us);
  if (code <= 1) device_.trip(code == 1, now_us);
}

void StageTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  line_.clear();
  wait_for_motion_ = true;
  blocked_ = false;
  device_.power_on();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void StageTwin::io(Archive& a) {
  a.all(boot_count_, device_, line_, wait_for_motion_, blocked_, last_heard_us_, link_);
}

}  // namespace firn::plant
