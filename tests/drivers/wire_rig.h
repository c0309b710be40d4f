// WireRig puts the ports of a rig on real lines of this host, all serial or all TCP; the time stays
// simulated.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "tests/drivers/port_rig.h"
#include "tests/drivers/real_wire.h"
#include "tests/support/temp_folder.h"

namespace firn::drivers::test {

template <class Rig>
class WireRig : public Rig {
 public:
  template <class... Args>
  explicit WireRig(RealWire::Kind kind, Args&&... args) : Rig(std::forward<Args>(args)...), kind_(kind) {}

  void pull_out(std::string_view name) {
    pulled_.emplace(name);
    this->unplug(name);
  }
  void plug_in(std::string_view name) { pulled_.erase(std::string(name)); }
  std::int64_t exchanges(const std::string& name) const {
    const auto at = exchanges_.find(name);
    return at == exchanges_.end() ? 0 : at->second;
  }

 protected:
  bool open_line(std::string_view name) override {
    if (pulled_.contains(std::string(name))) return false;
    wire(name).open();
    return true;
  }
  void close_line(std::string_view name) override { wire(name).end(); }
  std::string to_instrument(std::string_view name, std::string bytes) override {
    ++exchanges_[std::string(name)];
    return wire(name).to_instrument(bytes);
  }
  std::string to_host(std::string_view name, std::string bytes) override { return wire(name).to_host(bytes); }

 private:
  RealWire& wire(std::string_view name) {
    std::unique_ptr<RealWire>& w = wires_[std::string(name)];
    if (!w) w = std::make_unique<RealWire>(kind_, folder_.path() / std::string(name));
    return *w;
  }

  RealWire::Kind kind_;
  firn::test::TempFolder folder_;
  std::map<std::string, std::unique_ptr<RealWire>> wires_;
  std::set<std::string> pulled_;
  std::map<std::string, std::int64_t> exchanges_;
};

}  // namespace firn::drivers::test
