// certificate_bytes and certificate_from write and read the certificate of a layer's lower bound as an NPY
// file: float32 (cuts, nx, 64), the multipliers of core/control/mpc/bound/bound.h in their order.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace firn {

std::vector<std::byte> certificate_bytes(std::span<const float> multipliers, int nx);

/// @throws std::invalid_argument naming `name` and the byte: not a certificate, another nx
std::vector<float> certificate_from(std::span<const std::byte> bytes, int nx, const std::string& name);

}  // namespace firn
