// ScriptDriver drives an instrument by a class in Python, which a program of its own runs: it starts the
// class, calls its methods one at a time, watches how long each takes, and passes bytes between the class and
// the instrument's port. The class declares when it begins how the instrument is made safe (safe_bytes):
// these bytes are sent from here, ahead of the class, on a stop and whenever the class is slow, broken or
// gone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/link/driver.h"
#include "drivers/script/script_options.h"
#include "drivers/script/script_talk.h"

namespace firn::drivers {

/// @tparam Base interface of a class of instruments, a Driver that is made with a dialect: LampDriver, …
template <class Base>
class ScriptDriver : public Base {
 public:
  bool has_line() const final { return !script_.own_port; }
  bool busy() const override { return op_; }
  /// identify() has returned: that the program answers says nothing of its instrument.
  bool answered() const final { return named_; }

 protected:
  using Line = script::Line;
  using Values = script::Values;

  /// ending() of a command that a stop has ended.
  static constexpr std::string_view kStopped = "safe stop";
  /// Tags of a driver's own calls begin here.
  static constexpr std::uint16_t kFirstTag = 16;

  /// @param needs names of the methods that the class must have, beside identify() and safe()
  /// @param config of the interface, behind its dialect
  template <class... Config>
  ScriptDriver(ScriptOptions options, std::vector<std::string_view> needs, Config&&... config)
      : Base(dialect_, std::forward<Config>(config)...),
        script_(std::move(options)),
        needs_(std::move(needs)) {
    needs_.push_back("identify");
    needs_.push_back("safe");
    this->identity_ = script_.file + ":" + script_.class_name;
  }

  // --- Of the kinds of instruments.
  /// A call has returned.
  virtual void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) = 0;
  /// safe() has returned, by a stop or when a command ends; `ending` is empty when that was in order.
  virtual void became_safe(std::int64_t now_us, Effects& fx) = 0;
  /// No call runs: the next one of the command. @returns whether one was made.
  virtual bool work(std::int64_t /*now_us*/, Effects&) { return false; }
  virtual void work_tick(std::int64_t /*now_us*/, Effects&) {}
  virtual std::int64_t work_wake_us() const { return 0; }
  /// The command that has begun ends without its end: a Result with this outcome.
  virtual Result broken_off(Outcome outcome, std::int32_t code, std::string text) {
    return {outcome, -1, 0, 0, 0, code, std::move(text)};
  }

  // --- For them.
  bool ready() const { return phase_ == Phase::kReady; }
  bool stopping() const final { return phase_ == Phase::kStopping; }
  /// A command may begin; else it is refused.
  bool accepts(Effects& fx) {
    if (ready() && !op_) return true;
    const std::string why =
        op_ ? std::string("busy with another command") : std::string(standing(this->state()));
    refuse(kNoCode, "the " + script_.node + " is " + why, fx);
    return false;
  }
  static void refuse(std::int32_t code, std::string text, Effects& fx) {
    fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, std::move(text)});
  }
  void begin_command() {
    op_ = true;
    acts_ = false;
    ending_.clear();
    ending_code_ = kNoCode;
  }
  /// From here on something physical may go on until safe() has returned.
  void acts() { acts_ = true; }
  void end_acting() { acts_ = false; }
  bool may_act() const { return acts_; }
  void finish(Result result, Effects& fx) {
    if (!std::exchange(op_, false)) return;
    fx.events.emplace_back(std::move(result));
  }
  const std::string& ending() const { return ending_; }
  std::int32_t ending_code() const { return ending_code_; }

  void call(std::uint16_t tag, std::string_view method, const Values& arguments, std::int64_t now_us) {
    call_within(limit_s(method), tag, method, arguments, now_us);
  }
  /// The same of a method that may take as long as the order says, beyond its own time.
  void call_for(double order_s, std::uint16_t tag, std::string_view method, const Values& arguments,
                std::int64_t now_us) {
    call_within(std::min(order_s + limit_s(method), kMostTime_s), tag, method, arguments, now_us);
  }
  /// The class has the method.
  bool has(std::string_view method) const { return declared_.contains("has_" + std::string(method)); }
  /// A call runs.
  bool waits() const { return deadline_us_ != 0; }

  /// Ends the command, and with it whatever goes on: safe() is called, became_safe() follows.
  void make_safe(std::string ending, std::int32_t code, std::int64_t now_us, Effects& fx) {
    if (!ending.empty() && ending_.empty()) {
      ending_ = std::move(ending);
      ending_code_ = code;
    }
    if (phase_ == Phase::kStopping) return;
    phase_ = Phase::kStopping;
    next_.reset();
    this->link_.clear_queue();
    const double safe_s = limit_s("safe");
    begin_call("safe", safe_s, now_us);
    this->link_.urgent(dialect_.request(current_, script::stop_line(current_, safe_s), kStop), now_us, fx);
  }
  /// The class has returned something else than its contract says.
  void wrong(std::string_view method, std::string_view why, std::int64_t now_us, Effects& fx) {
    const std::string text = blame(method, why);
    this->fault(Severity::kStop, kInstrument, text, fx);
    send_safe_bytes(fx);
    make_safe(text, kInstrument, now_us, fx);
  }
  /// "lamp: psu.py: Lamp.on: why"
  std::string blame(std::string_view method, std::string_view why) const {
    return script_.node + ": " + script_.file + ": " + script_.class_name + "." + std::string(method) + ": " +
           std::string(why);
  }
  const ScriptOptions& script() const { return script_; }

 private:
  enum class Phase : std::uint8_t {
    kDown,
    kBeginning,   // the class is imported
    kWaiting,     // for the instrument's port
    kConnecting,  // the object is made, and asks who is there
    kStopping,    // safe() runs
    kReady,
    kBroken,  // the class is none: a new start would not help
  };
  enum Tag : std::uint16_t { kBegin = 1, kConnect, kIdentify, kStop, kPoll };

  static constexpr double kImport_s = 20.0;  // a package of instruments on a slow disk
  static constexpr int kMostNotes = 20;      // of one start
  static constexpr double kMostTime_s = 600.0;

  void begin_call(std::string_view method, double within_s, std::int64_t now_us) {
    ++current_;
    method_ = method;
    asked_us_ = now_us;
    deadline_us_ = now_us + std::int64_t((within_s + script_.host_latency_s) * 1e6);
  }
  /// A call that runs, such as poll(), is waited for.
  void call_within(double within_s, std::uint16_t tag, std::string_view method, const Values& arguments,
                   std::int64_t now_us) {
    if (waits()) {
      next_ = Call{within_s, tag, std::string(method), arguments};
      return;
    }
    begin_call(method, within_s, now_us);
    this->link_.push(
        dialect_.request(current_, script::call_line(current_, within_s, method, arguments), tag));
  }
  void call_next(std::int64_t now_us) {
    if (!next_ || waits()) return;
    const Call call = *std::exchange(next_, std::nullopt);
    call_within(call.within_s, call.tag, call.method, call.arguments, now_us);
  }

  double limit_s(std::string_view method) const {
    const auto own = declared_.find("time_" + std::string(method));
    return own != declared_.end() ? own->second.front() : declared("timeout_s");
  }
  double declared(std::string_view name) const {
    const auto at = declared_.find(name);
    return at == declared_.end() || at->second.size() != 1 ? 1.0 : at->second.front();
  }

  void connected(std::int64_t now_us, Effects& fx) final {
    this->set_state(DeviceState::kIdentifying, this->identity_, fx);
    phase_ = Phase::kBeginning;
    notes_ = 0;
    reason_.clear();
    begin_call("begin", kImport_s, now_us);
    this->link_.push(dialect_.request(
        current_,
        script::begin_line(current_, script_.file, script_.class_name, script_.arguments, has_line(), needs_),
        kBegin));
  }

  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) final {
    take_reply(request, frame, now_us, fx);
    call_next(now_us);
  }
  void take_reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                  Effects& fx) {
    if (request.argument != current_) return;  // broken off by a stop
    deadline_us_ = 0;
    const std::optional<Line> line = script::parse_line(text_of(frame.first(frame.size() - 1)));
    if (!line) return give_up(blame(method_, "its answer is damaged"), kLinkLost, now_us, fx);
    if (line->kind == Line::Kind::kFailed) return raised(request.tag, *line, now_us, fx);
    switch (request.tag) {
      case kBegin:
        if (std::string why = take_declared(*line); !why.empty()) return broken(why, fx);
        phase_ = Phase::kWaiting;
        if (!has_line() || line_open_) connect(now_us, fx);
        return;
      case kConnect:
        return call(kIdentify, "identify", {}, now_us);
      case kIdentify:
        if (line->text.empty()) return give_up(blame(method_, "it returns no text"), kLinkLost, now_us, fx);
        this->identity_ = line->text;
        named_ = true;
        return make_safe({}, kNoCode, now_us, fx);
      case kStop:
        phase_ = Phase::kReady;
        acts_ = false;
        this->identified();
        poll_from_us_ = now_us;
        this->set_state(DeviceState::kSafe, "safe() has returned", fx);
        became_safe(now_us, fx);
        if (op_)
          finish(broken_off(ending_code_ == kCommandRejected ? Outcome::kNone : Outcome::kFailed,
                            ending_code_, ending_),
                 fx);
        ending_.clear();
        ending_code_ = kNoCode;
        return;
      case kPoll:
        poll_from_us_ = now_us;
        return;
      default:
        poll_from_us_ = now_us;
        return returned(request.tag, *line, now_us, fx);
    }
  }

  void raised(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
    const std::string why = blame(method_, line.text);
    switch (tag) {
      case kBegin:
        return broken(line.text, fx);
      case kConnect:
      case kIdentify:
      case kPoll:
        return give_up(why, line.why == Line::Why::kLate ? kLinkLost : kInstrument, now_us, fx);
      case kStop:
        this->fault(Severity::kStop, kInstrument, why + ": it may not be safe", fx);
        return give_up(why, kInstrument, now_us, fx);
      default:
        if (line.why == Line::Why::kRefused) return make_safe(line.text, kCommandRejected, now_us, fx);
        this->fault(Severity::kStop, line.why == Line::Why::kLate ? kLinkLost : kInstrument, why, fx);
        send_safe_bytes(fx);
        return make_safe(why, line.why == Line::Why::kLate ? kLinkLost : kInstrument, now_us, fx);
    }
  }

  std::string take_declared(const Line& line) {
    declared_ = line.values;
    safe_bytes_.clear();
    for (const auto& [name, values] : declared_) {
      if (name == "safe_bytes") {
        for (const double v : values) {
          if (!(v >= 0.0 && v <= 255.0) || v != std::floor(v)) return "safe_bytes are no bytes";
          safe_bytes_.push_back(std::byte(std::uint8_t(v)));
        }
      } else if (values.size() != 1 || !(values.front() > 0.0 && values.front() <= kMostTime_s)) {
        char text[120];
        std::snprintf(text, sizeof text, "%s = %g s is outside (0, %g] s", name.c_str(),
                      values.empty() ? 0.0 : values.front(), kMostTime_s);
        return text;
      }
    }
    if (has_line() && !declared_.contains("safe_bytes"))
      return "it declares no safe_bytes: without them nothing can be sent when the class itself is slow or "
             "gone "
             "(b\"\" if there is nothing to make safe)";
    return {};
  }

  /// Nothing is tried again: the same text would be read.
  void broken(const std::string& why, Effects& fx) {
    phase_ = Phase::kBroken;
    const std::string text = script_.node + ": " + script_.file + ": " + script_.class_name + ": " + why;
    this->fault(Severity::kStop, kInstrument, text, fx);
    this->set_state(DeviceState::kFault, text, fx);
  }

  void connect(std::int64_t now_us, Effects& fx) {
    phase_ = Phase::kConnecting;
    if (has_line()) tell(script::line_line(true), fx);
    call(kConnect, "connect", {}, now_us);
  }

  void give_up(const std::string& why, std::int32_t code, std::int64_t now_us, Effects& fx) {
    reason_ = why;
    reason_code_ = code;
    this->reconnect(now_us, fx, why);
  }

  /// A method that does not return: its program is ended at once, not after the pause of a new attempt.
  void hung(std::int64_t now_us, Effects& fx) {
    char text[80];
    std::snprintf(text, sizeof text, "it has not returned within %g s",
                  double(deadline_us_ - asked_us_) * 1e-6);
    give_up(blame(method_, text), kLinkLost, now_us, fx);
    fx.reopen = true;
  }

  void failed(const Request&, std::int64_t, Effects&) final {}  // overtaken by a stop, whose answer counts

  void lost(std::int64_t, Effects& fx) final {
    if (phase_ == Phase::kDown) return;
    if (phase_ == Phase::kBroken) {
      phase_ = Phase::kDown;
      return;
    }
    if (reason_.empty()) {
      reason_ = blame(method_, "its program has ended");
      reason_code_ = kLinkLost;
    }
    send_safe_bytes(fx);
    const bool in_use = op_ || acts_;
    this->fault(in_use ? Severity::kStop : Severity::kWarning, reason_code_, reason_, fx);
    finish(broken_off(acts_ ? Outcome::kUnknown : Outcome::kNone, reason_code_, reason_), fx);
    phase_ = Phase::kDown;
    named_ = false;
    deadline_us_ = 0;
    next_.reset();
    ending_.clear();
    program_lost(fx);
  }
  virtual void program_lost(Effects&) {}

  void stop(std::int64_t now_us, Effects& fx) final {
    if (phase_ == Phase::kStopping) return;
    send_safe_bytes(fx);
    if (phase_ == Phase::kReady) make_safe(op_ ? std::string(kStopped) : std::string(), kNoCode, now_us, fx);
    // Else the instrument is made safe before it is ever called ready.
  }

  void send_safe_bytes(Effects& fx) const {
    if (line_open_) fx.line_tx.insert(fx.line_tx.end(), safe_bytes_.begin(), safe_bytes_.end());
  }
  static void tell(const std::string& line, Effects& fx) {
    const auto bytes = std::as_bytes(std::span(line));
    fx.tx.insert(fx.tx.end(), bytes.begin(), bytes.end());
  }

  void line_is(bool open, std::int64_t now_us, Effects& fx) final {
    line_open_ = open;
    if (open) {
      if (phase_ == Phase::kWaiting) connect(now_us, fx);
      return;
    }
    fx.reopen_line = true;
    if (phase_ == Phase::kConnecting || phase_ == Phase::kStopping || phase_ == Phase::kReady)
      give_up(script_.node + ": the instrument's port has closed", kLinkLost, now_us, fx);
  }
  void line_said(std::span<const std::byte> bytes, std::int64_t, Effects& fx) final {
    if (this->link_.is_open() && phase_ != Phase::kBeginning && phase_ != Phase::kWaiting)
      tell(script::bytes_line(bytes), fx);
  }

  void unsolicited(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) final {
    const std::optional<Line> line = script::parse_line(text_of(frame.first(frame.size() - 1)));
    if (!line) return give_up(blame(method_, "its line is damaged"), kLinkLost, now_us, fx);
    if (line->kind == Line::Kind::kNote) {
      if (++notes_ <= kMostNotes)
        this->fault(Severity::kNotice, kNoCode, script_.node + ": " + line->text, fx);
    } else if (waits() && line->call == current_ && line_open_) {
      fx.line_tx.insert(fx.line_tx.end(), line->bytes.begin(), line->bytes.end());
    }  // else: of a call that a stop broke off
  }

  bool idle(std::int64_t now_us, Effects& fx) final {
    if (phase_ != Phase::kReady || waits()) return false;
    if (work(now_us, fx)) return true;
    if (op_ || !declared_.contains("poll_s") || now_us < poll_at_us()) return false;
    call(kPoll, "poll", {}, now_us);
    return true;
  }
  std::int64_t poll_at_us() const { return poll_from_us_ + std::int64_t(declared("poll_s") * 1e6); }

  void tick(std::int64_t now_us, Effects& fx) final {
    if (deadline_us_ != 0 && now_us >= deadline_us_) hung(now_us, fx);
    work_tick(now_us, fx);
  }
  std::int64_t device_wake_us() const final {
    std::int64_t wake_us = deadline_us_;
    const std::int64_t poll_us =
        phase_ == Phase::kReady && !op_ && !waits() && declared_.contains("poll_s") ? poll_at_us() : 0;
    for (const std::int64_t t : {work_wake_us(), poll_us})
      if (t != 0 && (wake_us == 0 || t < wake_us)) wake_us = t;
    return wake_us;
  }

  script::ScriptDialect dialect_;
  ScriptOptions script_;
  std::vector<std::string_view> needs_;
  Values declared_;
  std::vector<std::byte> safe_bytes_;
  Phase phase_ = Phase::kDown;
  bool line_open_ = false;
  bool named_ = false;
  bool op_ = false;    // a command's Result is to come
  bool acts_ = false;  // something physical may go on
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
  struct Call {
    double within_s = 0.0;
    std::uint16_t tag = 0;
    std::string method;
    Values arguments;
  };
  std::optional<Call> next_;
  // The call that runs, or ran last.
  std::int32_t current_ = 0;
  std::string method_;
  std::int64_t asked_us_ = 0, deadline_us_ = 0;  // 0: none runs
  std::int64_t poll_from_us_ = 0;
  std::string reason_;  // why the connection is given up
  std::int32_t reason_code_ = kNoCode;
  int notes_ = 0;
};

}  // namespace firn::drivers
