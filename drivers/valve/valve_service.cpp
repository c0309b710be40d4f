// Valve: orders of a person, beside a print (firn device).
#include <cmath>

#include "drivers/valve/valve.h"

namespace firn::drivers {
namespace {

constexpr int kSpitEvery_us = 20'000;

}  // namespace

void Valve::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (verb != "spit" || v.size() != 1) return Driver::service(verb, v, now_us, fx);
  if (!(v[0] >= 1 && v[0] <= config_.dialect.most_spits) || v[0] != std::floor(v[0]))
    return refuse(kLimit,
                  "spits are a whole number, 1 to " + std::to_string(config_.dialect.most_spits) +
                      " (devices.NODE.dialect.most_spits)",
                  fx);
  if (config_.pulse_us + config_.guard_us > kSpitEvery_us)
    return refuse(kLimit, "a pulse and its guard time are longer than 20 ms", fx);
  forget_list();  // the controller's too
  const fvb::Begin spit{0, std::uint8_t(config_.valve), std::uint16_t(v[0]), kSpitEvery_us,
                        std::uint16_t(config_.pulse_us)};
  Service s{std::string(verb),
            {fvb::spit(seq(), spit)},
            std::int64_t(v[0]) * kSpitEvery_us,
            {},
            [](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
              const auto reply = fvb::parse_reply(fvb::find(frame));
              return reply && reply->type == fvb::Type::kAck ? std::optional<std::string>("") : std::nullopt;
            }};
  run_service(std::move(s));
}

}  // namespace firn::drivers
