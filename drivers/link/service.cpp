// Driver: a person's orders, step by step.
#include "drivers/link/service.h"

#include "drivers/link/driver.h"

namespace firn::drivers {

void Driver::serve(std::string_view verb, std::span<const double> values, std::int64_t now_us, Effects& fx) {
  if (verb == "reset") {
    permit_reset();
    fx.events.emplace_back(Result{});
    reconnect(now_us, fx, "reset");
  } else if (busy() || service_) {
    refuse_service(kNoCode, "it is busy with another order", fx);
  } else if (!safe()) {
    refuse_service(kNoCode, std::string("it is ") + standing(), fx);
  } else {
    service(verb, values, now_us, fx);
  }
  pump(now_us, fx);
}

void Driver::service(std::string_view verb, std::span<const double>, std::int64_t, Effects& fx) {
  if (verb == "serial")  // it gives none
    return void(fx.events.emplace_back(Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, identity_}));
  refuse_service(kNoCode, "it has no order '" + std::string(verb) + "'", fx);
}

void Driver::refuse_service(std::int32_t code, std::string text, Effects& fx, Figure figure) {
  fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, std::move(text), std::move(figure)});
}

void Driver::run_service(Service service) {
  service_ = std::move(service);
  service_step_ = ServiceStep::kBegin;
  service_text_.clear();
  for (Request r : service_->begin) {
    r.tag = kServiceTag;
    link_.push(r);
  }
}

void Driver::end_service(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  service_.reset();
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text)});
}

void Driver::service_reply(const LinkEvent& event, std::int64_t now_us, Effects& fx) {
  if (!service_) {  // cut by a stop
    if (ending_tell_ && !ending_tell_(event.request, event.frame))
      reconnect(now_us, fx, "it refuses the end of a person's order");
    return;
  }
  if (const auto text = service_->tell(event.request, event.frame)) {
    if (!text->empty()) service_text_ += (service_text_.empty() ? "" : ", ") + *text;
    return;
  }
  const bool acts = service_->acts();
  const std::string verb = service_->verb;
  link_.clear_queue();
  end_service(acts ? Outcome::kFailed : Outcome::kNone, kCommandRejected, "it refuses '" + verb + "'", fx);
  if (acts) reconnect(now_us, fx, "it refuses '" + verb + "'");  // what it does is not known: all is set anew
}

// The link is idle: every reply of the step is there. @returns whether something was queued or has ended
bool Driver::advance_service(std::int64_t now_us, Effects& fx) {
  switch (service_step_) {
    case ServiceStep::kBegin:
      if (service_->hold_us == 0) break;
      service_step_ = ServiceStep::kHold;
      service_until_us_ = now_us + service_->hold_us;
      set_state(DeviceState::kActive, service_->verb, fx);
      return false;
    case ServiceStep::kHold:
      if (now_us < service_until_us_) return false;
      break;
    case ServiceStep::kEnd:
      break;
  }
  if (service_step_ != ServiceStep::kEnd && !service_->end.empty()) {
    service_step_ = ServiceStep::kEnd;
    for (Request r : service_->end) {
      r.tag = kServiceTag;
      link_.push(r);
    }
    return true;
  }
  if (service_->hold_us > 0) set_state(DeviceState::kSafe, service_->verb + " is over", fx);
  const auto then = std::move(service_->then);
  if (!then) {
    end_service(Outcome::kDone, kNoCode, service_text_, fx);
    return true;
  }
  service_.reset();
  then(now_us, fx);
  return true;
}

void Driver::cut_service(std::int64_t now_us, Effects& fx) {
  ending_tell_ = service_->tell;
  link_.clear_queue();
  for (Request r : service_->end) {
    r.tag = kServiceTag;
    link_.urgent(r, now_us, fx);
  }
  end_service(Outcome::kFailed, kNoCode, "safe stop", fx);
}

}  // namespace firn::drivers
