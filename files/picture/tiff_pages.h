// tiff_pages counts the pages of a TIFF file (TIFF 6.0, section 2; BigTIFF): its image file directories.
#pragma once

#include <cstddef>
#include <span>

namespace firn {

/// @returns 0: no TIFF file. A chain of directories that leaves the file or runs in a circle ends there.
std::size_t tiff_pages(std::span<const unsigned char> file);

}  // namespace firn
