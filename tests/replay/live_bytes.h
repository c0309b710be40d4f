// peak_live_bytes_of counts the bytes that some work has allocated at the same time, through operator new.
#pragma once

#include <cstddef>
#include <functional>

namespace firn::test {

/// Returns the largest number of bytes that all threads held during the work above those at its start.
std::size_t peak_live_bytes_of(const std::function<void()>& work);

}  // namespace firn::test
