#include <fmt/core.h>

#include <numbers>

#include "files/json.h"
#include "report/droplets/droplet_files.h"

namespace firn::report {
namespace {

using Json = nlohmann::ordered_json;
using vision::Droplet;
using vision::Estimate;
using vision::PictureState;

const char* text_of(PictureState s) {
  return s == PictureState::kNoDrop ? "no drop" : s == PictureState::kDrop ? "drop" : "not broken off";
}

double volume_pl(const Droplet& d, double um_per_px) {
  const double um = d.diameter_px * um_per_px;
  return std::numbers::pi / 6 * um * um * um / std::sqrt(std::clamp(d.axis_ratio, 0.5, 2.0)) * 1e-3;
}

Json droplet_json(const Droplet& d, const vision::Scale& scale) {
  Json j{{"x_px", d.x},
         {"y_px", d.y},
         {"x_std_px", d.x_std},
         {"y_std_px", d.y_std},
         {"diameter_px", d.diameter_px},
         {"diameter_std_px", d.diameter_std_px},
         {"axis_ratio", d.axis_ratio},
         {"ligament_px", d.tail_px},
         {"opacity", d.opacity},
         {"joined", d.joined}};
  if (scale.um_per_px > 0) {
    const double share = d.diameter_std_px / d.diameter_px, of_scale = scale.std / scale.um_per_px;
    const double relative = std::sqrt(share * share + of_scale * of_scale);
    j["diameter_um"] = d.diameter_px * scale.um_per_px;
    j["diameter_std_um"] = d.diameter_px * scale.um_per_px * relative;
    j["volume_pl"] = volume_pl(d, scale.um_per_px);
    j["volume_std_pl"] = 3 * relative * volume_pl(d, scale.um_per_px);
  }
  return j;
}

Json list_json(const std::vector<Droplet>& list, const vision::Scale& scale) {
  Json j = Json::array();
  for (const Droplet& d : list) j.push_back(droplet_json(d, scale));
  return j;
}

Json picture_json(const AnalysedPicture& p, const vision::Scale& scale) {
  const vision::DropletPicture& r = p.result;
  Json j{{"file", p.file.string()}, {"width_px", p.width}, {"height_px", p.height}};
  if (p.delay_us) j["delay_us"] = *p.delay_us;
  j["state"] = text_of(r.state);
  j["broken_off"] = r.state == PictureState::kNoDrop ? Json() : Json(r.state == PictureState::kDrop);
  j["main"] = r.state == PictureState::kNoDrop ? Json() : droplet_json(r.main, scale);
  j["drops"] = list_json(r.drops, scale);
  j["satellites"] = list_json(r.satellites, scale);
  j["cut_off"] = r.cut_off;
  j["nozzle"] = !r.nozzle.found ? Json()
                                : Json{{"x_px", r.nozzle.edge.x},
                                       {"y_px", r.nozzle.edge.y},
                                       {"edge_std_px", r.nozzle.edge_std_px},
                                       {"width_px", r.nozzle.width_px},
                                       {"width_std_px", r.nozzle.width_std_px},
                                       {"flight", {r.nozzle.flight.x, r.nozzle.flight.y}}};
  j["bright_objects"] = r.bright;
  j["noise"] = r.noise;
  j["blur_px"] = r.blur_px;
  j["saturated"] = p.saturated;
  if (!p.remarks.empty()) j["remarks"] = p.remarks;
  j["background"] = r.used_background ? "pictures" : "smooth";
  return j;
}

void add(Json& j, const char* name, const char* unit, const Estimate& e) {
  const std::string key = std::string(name) + unit;
  j[key] = e.known ? Json(e.value) : Json();
  j[std::string(name) + "_std" + unit] = e.known ? Json(e.std) : Json();
}

Json sweep_json(const vision::SweepResult& s, bool scaled) {
  Json j{{"pictures", s.pictures}, {"with_droplet", s.with_droplet}, {"used", s.used}};
  if (s.used) j["middle_us"] = s.middle_us;
  add(j, "velocity", scaled ? "_m_s" : "_px_us", s.velocity_m_s);
  add(j, "angle", "_deg", s.angle_deg);
  add(j, "diameter", scaled ? "_um" : "_px", s.diameter_um);
  if (scaled) add(j, "volume", "_pl", s.volume_pl);
  add(j, "satellites", "", s.satellites);
  add(j, "largest_satellite", scaled ? "_um" : "_px", s.largest_satellite_um);
  add(j, "break_off", "_us", s.break_off_us);
  add(j, "jitter", "_us", s.jitter_us);
  return j;
}

std::string line(const char* name, const Estimate& e, const char* unit) {
  return e.known ? fmt::format("{:<12}{:.4g} +- {:.2g} {}\n", name, e.value, e.std, unit) : "";
}

}  // namespace

std::string droplets_warnings(const DropletAnalysis& a) {
  constexpr double kSaturated = 0.01;  // a bright spot in a droplet is less
  std::string out;
  for (const AnalysedPicture& p : a.pictures) {
    for (const std::string& r : p.remarks) out += fmt::format("warning: {}: {}\n", p.file.string(), r);
    if (p.saturated > kSaturated)
      out += fmt::format(
          "warning: {}: {:.0f} % of the pixels are saturated: edges are less certain there; less light or a "
          "shorter exposure is needed\n",
          p.file.string(), 100.0 * p.saturated);
  }
  return out;
}

std::string droplets_json(const DropletAnalysis& a) {
  Json pictures = Json::array();
  for (const AnalysedPicture& p : a.pictures) pictures.push_back(picture_json(p, a.scale));
  const bool scaled = a.scale.um_per_px > 0;
  Json j{{"scale_um_per_px", scaled ? Json(a.scale.um_per_px) : Json()},
         {"scale_std_um_per_px", scaled ? Json(a.scale.std) : Json()},
         {"pictures", pictures},
         {"sweep", a.sweep ? sweep_json(*a.sweep, scaled) : Json()}};
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string droplets_text(const DropletAnalysis& a) {
  std::string out;
  const bool scaled = a.scale.um_per_px > 0;
  for (const AnalysedPicture& p : a.pictures) {
    const vision::DropletPicture& r = p.result;
    out += p.file.string() + (p.delay_us ? fmt::format(" ({:g} us)", *p.delay_us) : "") + ": " +
           text_of(r.state);
    if (r.state != PictureState::kNoDrop) {
      out += fmt::format(" at {:.2f}, {:.2f} px, diameter {:.2f} +- {:.2f} px", r.main.x, r.main.y,
                         r.main.diameter_px, r.main.diameter_std_px);
      if (scaled)
        out += fmt::format(" = {:.2f} um, {:.2f} pl", r.main.diameter_px * a.scale.um_per_px,
                           volume_pl(r.main, a.scale.um_per_px));
      if (r.main.tail_px > 0) out += fmt::format(", ligament {:.1f} px", r.main.tail_px);
      out += fmt::format(", {} satellites", r.satellites.size());
      if (!r.drops.empty()) out += fmt::format(", {} further droplets", r.drops.size());
    }
    out += "\n";
  }
  if (scaled) out += fmt::format("{:<12}{:.5g} +- {:.2g} um/px\n", "scale", a.scale.um_per_px, a.scale.std);
  if (a.sweep) {
    const vision::SweepResult& s = *a.sweep;
    out += line("velocity", s.velocity_m_s, scaled ? "m/s" : "px/us") + line("angle", s.angle_deg, "deg");
    out += line("diameter", s.diameter_um, scaled ? "um" : "px") +
           (scaled ? line("volume", s.volume_pl, "pl") : "");
    out += line("satellites", s.satellites, "") + line("break-off", s.break_off_us, "us") +
           line("jitter", s.jitter_us, "us");
  }
  return out;
}

}  // namespace firn::report
