#include "plant/inkjet/model.h"

#include "plant/inkjet/python_model.h"

namespace firn::plant {

std::unique_ptr<Model> make_model(const WorldConfig& config) {
  check(config);
  if (is_python_model(config.model)) return make_python_model(config);
  return config.model == "lu2015" ? make_lu2015_model(config) : make_droplet_model(config);
}

}  // namespace firn::plant
