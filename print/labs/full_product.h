// full_product holds every lab, node and reader of meshes of Firn. A new lab or node is a row in its source.
#pragma once

#include "print/labs/product.h"

namespace firn {

const Product& full_product();

}  // namespace firn
