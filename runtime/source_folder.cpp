#include "runtime/source_folder.h"

namespace firn {

std::filesystem::path source_folder() { return FIRN_SOURCE_DIR; }

}  // namespace firn
