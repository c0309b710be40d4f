// Pages for memory that will be written throughout.
#pragma once

#include <cstddef>
#include <span>

namespace firn::slice {

/// Asks the system for the pages of new memory all at once instead of one by one as they are first written
/// to, each by a fault of its own. A hint: where the system does not know it (Linux before 5.14), nothing
/// changes.
void ask_for_pages(std::span<std::byte> memory);

}  // namespace firn::slice
