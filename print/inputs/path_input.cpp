#include "print/inputs/path_input.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "config/error.h"
#include "files/path/layer_file.h"

namespace firn {
namespace {

constexpr std::size_t kValves = 2;

class PathInput {
 public:
  PathInput(const Experiment& e, const Machine& machine, const std::filesystem::path& file)
      : ice_(e.ice), machine_(machine), file_(file.string()) {}

  slice::PrintPaths read() {
    try {
      LayerReader in(file_);
      paths_.head = in.head();
      const double most =
          ice_.height_mm > 0.0 ? std::floor(ice_.height_mm / ice_.layer_height_mm + 1e-9) : 1e9;
      while (auto layer = in.next())
        if (layer->layer <= most) paths_.layers.push_back(std::move(*layer));
    } catch (const FormatError& error) {
      fail(error.what());
    } catch (const record::FileError& error) {
      fail(error.what());
    }
    check_layers();
    check_materials();
    check_intervals();
    paths_.head.layers = std::int32_t(paths_.layers.size());
    return std::move(paths_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw ConfigError(file_, 0, "ice.paths", "ice.paths: " + problem);
  }

  void check_layers() const {
    if (paths_.layers.empty()) fail("has no layer");
    const auto units = [](double mm) { return std::int32_t(std::lround(mm * geometry::kUnitsPerMm)); };
    const std::int32_t height = units(ice_.layer_height_mm);
    std::int32_t number = 0;
    for (const slice::LayerPaths& l : paths_.layers) {
      if (l.layer != ++number) fail(fmt::format("layer {} is missing; a print begins at layer 1", number));
      if (l.height != height)
        fail(fmt::format("layer {} is {:g} mm high, ice.layer_height_mm = {:g} mm", number,
                         l.height * geometry::kMmPerUnit, ice_.layer_height_mm));
      if (const std::int32_t z = units(number * ice_.layer_height_mm); l.z != z)
        fail(fmt::format("layer {} ends {:g} mm above the table, not {:g} mm", number,
                         l.z * geometry::kMmPerUnit, z * geometry::kMmPerUnit));
    }
  }

  void check_materials() const {
    const std::vector<motion::Tool> known = tools(machine_);
    std::set<std::size_t> checked;
    for (const slice::LayerPaths& l : paths_.layers)
      for (const slice::PathInfo& info : l.info) {
        if (!checked.insert(info.material).second) continue;
        const auto& material = paths_.head.materials.at(info.material);
        if (info.material >= kValves)
          fail(fmt::format("layer {} has material {} (\"{}\"); the lab has valves for {} materials", l.layer,
                           info.material, material.name, kValves));
        if (std::ranges::find(known, material.tool, &motion::Tool::name) == known.end())
          fail(fmt::format("material {} (\"{}\") has the tool \"{}\", which is none of machine {}",
                           info.material, material.name, material.tool, machine_.name));
      }
  }

  // The layer that ends an interval is measured. A material with too little room for a measurement path in
  // one layer is no reason to refuse; a material that is measured nowhere is.
  void check_intervals() const {
    const auto n = std::size_t(ice_.interval_layers);
    std::set<std::uint8_t> laid;
    std::set<std::uint8_t> measured;
    for (std::size_t first = 0; first < paths_.layers.size(); first += n) {
      const std::size_t end = std::min(first + n, paths_.layers.size());
      bool deposits = false;
      for (std::size_t k = first; k < end; ++k) deposits = deposits || lines_of(paths_.layers[k], false) > 0;
      if (!deposits) fail(fmt::format("layers {} to {} deposit nothing", first + 1, end));
      const slice::LayerPaths& top = paths_.layers[end - 1];
      if (lines_of(top, true) == 0)
        fail(
            fmt::format("layer {} ends an interval of ice.interval_layers = {} and has no measurement paths; "
                        "firn slice --experiment writes them",
                        top.layer, n));
      for (const slice::PathInfo& info : top.info)
        (info.kind == PathKind::kMeasurement ? measured : laid).insert(info.material);
    }
    for (const std::uint8_t material : laid)
      if (!measured.contains(material))
        fail(fmt::format(
            "no layer has measurement paths over material {} (\"{}\"); firn slice --experiment writes them",
            material, paths_.head.materials[material].name));
    if (paths_.head.laser != "laser")
      fail(fmt::format(
          "its measurement paths are those of the tool \"{}\", the laser's are wanted: slice with "
          "measure.tool = \"laser\", measure.laser_x_mm = 0 and measure.laser_y_mm = 0",
          paths_.head.laser));
  }

  static std::ptrdiff_t lines_of(const slice::LayerPaths& layer, bool measurement) {
    return std::ranges::count_if(layer.info, [&](const slice::PathInfo& info) {
      return (info.kind == PathKind::kMeasurement) == measurement;
    });
  }

  const IceConfig& ice_;
  const Machine& machine_;
  std::string file_;
  slice::PrintPaths paths_;
};

}  // namespace

slice::PrintPaths read_ice_paths(const Experiment& e, const Machine& machine,
                                 const std::filesystem::path& file) {
  return PathInput(e, machine, file).read();
}

}  // namespace firn
