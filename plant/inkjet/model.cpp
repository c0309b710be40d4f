#include "plant/inkjet/model.h"

namespace firn::plant {

std::unique_ptr<Model> make_model(const WorldConfig& config) {
  check(config);
  return config.model == "lu2015" ? make_lu2015_model(config) : make_droplet_model(config);
}

}  // namespace firn::plant
