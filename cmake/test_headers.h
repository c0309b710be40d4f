// Catch2 and the standard headers, parsed once for all tests.
#pragma once

#include <catch2/catch.hpp>

#include "cmake/standard_headers.h"
