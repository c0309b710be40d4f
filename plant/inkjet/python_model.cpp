#include "plant/inkjet/python_model.h"

#include <any>
#include <stdexcept>
#include <string>
#include <utility>

#include "python/host/load.h"

namespace firn::plant {
namespace {

// Ports of a live world are not served meanwhile.
constexpr double kLongestPass_s = 20.0;

class PythonModel final : public Model {
 public:
  explicit PythonModel(const WorldConfig& c)
      : grid_(c.grid), height_(c.grid, 0.0), shown_(c.grid, 1, 0), droplet_mm3_(c.droplet.volume_mm3) {
    const auto* nature = std::any_cast<PythonNature>(&c.own);
    if (!nature)
      throw std::invalid_argument("world: model = \"" + c.model + "\": its file is no input of this print");
    python::Parcel setup;
    setup.set_grid(grid_);
    setup.set_seed(c.seed);
    setup.set("droplet_mm3", droplet_mm3_);
    object_ =
        python::host().make_object(python::Kind::kPlant, nature->files, nature->name, setup, kLongestPass_s);
  }

  Landing fire(const Shot& shot) override {
    pending_.push_back(shot);
    return {false, droplet_mm3_, shot.x_mm, shot.y_mm};
  }
  void end_pass() override { settle(); }
  void expose(std::int64_t) override {
    settle();
    layers_.exposed();
  }
  void measured() override {
    settle();
    layers_.measured();
  }
  const Field& surface() override {
    settle();
    for (int j = 0; j < grid_.ny; ++j)
      for (int i = 0; i < grid_.nx; ++i) shown_.set_solid_mm(i, j, height_.at(i, j));
    return shown_;
  }
  HeightMap cell_means() const override { return height_; }
  VolumeLedger ledger() const override { return ledger_; }
  double volume_mm3() const override {
    double sum = 0.0;
    for (const double z : height_.cells) sum += z;
    return sum * grid_.pitch_x_mm * grid_.pitch_y_mm;
  }
  const LayerCount& layers() const override { return layers_; }
  MaterialColumns materials() const override { return {}; }
  void io(Archive& a) override { a.all(height_.cells, pending_, memory_, layers_, ledger_); }

 private:
  void settle() {
    if (pending_.empty()) return;
    python::Parcel given;
    given.text = "layer " + std::to_string(layers_.layer() + 1);
    given.arrays["height_mm"] = {{grid_.ny, grid_.nx}, height_.cells};
    given.arrays["memory"] = {{int(memory_.size())}, memory_};
    std::vector<double> drops(grid_.size(), 0.0);
    for (const Shot& shot : pending_) {
      const NearestCell cell = nearest_cell(grid_, shot.x_mm, shot.y_mm);
      if (grid_.contains(cell.i, cell.j)) drops[grid_.index(cell.i, cell.j)] += 1.0;
    }
    given.arrays["drops"] = {{grid_.ny, grid_.nx}, std::move(drops)};
    given.arrays["x_mm"] = of_shots([](const Shot& s) { return s.x_mm; });
    given.arrays["y_mm"] = of_shots([](const Shot& s) { return s.y_mm; });
    given.arrays["t_s"] = of_shots([](const Shot& s) { return 1e-6 * double(s.t_us); });
    given.arrays["vx_mm_s"] = of_shots([](const Shot& s) { return s.vx_mm_s; });
    given.arrays["vy_mm_s"] = of_shots([](const Shot& s) { return s.vy_mm_s; });
    given.set("layer", layers_.layer());
    python::Parcel told = answer_to(given);  // throws before anything has changed
    const double before_mm3 = volume_mm3();
    height_.cells = std::move(told.arrays.at("height_mm").values);
    memory_ = std::move(told.arrays.at("memory").values);
    pending_.clear();
    ledger_.landed += volume_mm3() - before_mm3;
  }

  python::Parcel answer_to(const python::Parcel& given) try {
    return object_->call(given);
  } catch (const std::runtime_error& error) {
    throw NatureError(std::string("plant.model: ") + error.what());
  }

  template <class Of>
  python::Array of_shots(Of of) const {
    python::Array array{{int(pending_.size())}, {}};
    for (const Shot& shot : pending_) array.values.push_back(of(shot));
    return array;
  }

  GridSpec grid_;
  HeightMap height_;
  std::vector<Shot> pending_;   ///< of the pass that has not been deposited
  std::vector<double> memory_;  ///< of the class
  LayerCount layers_;
  VolumeLedger ledger_;
  Field shown_;  ///< height_ as the sensor's input
  double droplet_mm3_;
  std::unique_ptr<python::Object> object_;
};

}  // namespace

std::unique_ptr<Model> make_python_model(const WorldConfig& config) {
  return std::make_unique<PythonModel>(config);
}

}  // namespace firn::plant
