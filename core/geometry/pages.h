// ask_for_pages() requests the pages of memory that will be written throughout.
#pragma once

#include <cstddef>
#include <span>

namespace firn::geometry {

/// All pages of new memory are requested at once instead of one by one, each with a page fault at its first
/// write. It is a hint: systems without it (Linux before 5.14) ignore it.
void ask_for_pages(std::span<std::byte> memory);

}  // namespace firn::geometry
