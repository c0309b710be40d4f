// The table of natures of the ink-jet lab. Another one is a row here, its name and its parameters in
// plant/options/natures.h, and its class.
#include "plant/inkjet/model.h"

#include <algorithm>
#include <array>

#include "plant/inkjet/python_model.h"

namespace firn::plant {
namespace {

struct Nature {
  std::string_view name;
  std::unique_ptr<Model> (*make)(const WorldConfig&);
};
constexpr Nature kNatures[] = {
    {"droplets", &make_droplet_model},    {"lu2015", &make_lu2015_model},
    {"wu_chiu", &make_wu_chiu_model},     {"graph_flow", &make_graph_flow_model},
    {"thin_film", &make_thin_film_model},
};
static_assert(std::ranges::equal(kNatures, kNatureNames, {}, &Nature::name, &NatureName::name),
              "each name of plant.model has its physics");

}  // namespace

std::unique_ptr<Model> make_model(const WorldConfig& config) {
  check(config);
  if (is_python_model(config.model)) return make_python_model(config);
  return std::ranges::find(kNatures, std::string_view(config.model), &Nature::name)->make(config);
}

}  // namespace firn::plant
