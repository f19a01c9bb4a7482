// e^-x of three channels at once, for inner loops: plain arithmetic that compilers put into one vector.
#pragma once

#include <glm/glm.hpp>

#include <bit>
#include <cstdint>

namespace opaline {

/// e^-x per channel, relative error below 3e-7 for x from -80 to 80; beyond that as at 80, and as at -80.
inline glm::vec3 exp_minus(const glm::vec3& x) {
  // 2^y, y = n + f with |f| <= 1/2: n goes into the exponent's bits, 2^f is a polynomial (its Taylor series to f^7).
  constexpr float c1 = 0.693147181f, c2 = 0.240226507f, c3 = 0.0555041087f, c4 = 0.00961812911f, c5 = 0.00133335581f,
                  c6 = 0.000154035304f, c7 = 0.0000152527338f;
  constexpr float to_integer = 12582912;  // 1.5 * 2^23: adding it rounds to the nearest integer
  const float in[4] = {x.x, x.y, x.z, 0};
  float out[4];
  for (int i = 0; i < 4; ++i) {
    const float bounded = in[i] < -80 ? -80 : in[i] > 80 ? 80 : in[i];
    // ln 2 in two parts, so that the product keeps its low digits.
    const float rounded = bounded * -1.44269504f + to_integer, n = rounded - to_integer;
    const float f = ((-bounded - n * 0.693359375f) + n * 2.12194440e-4f) * 1.44269504f;
    const float p = 1 + f * (c1 + f * (c2 + f * (c3 + f * (c4 + f * (c5 + f * (c6 + f * c7))))));
    const std::int32_t power = (std::bit_cast<std::int32_t>(rounded) - 0x4b400000 + 127) << 23;
    out[i] = p * std::bit_cast<float>(power);
  }
  return {out[0], out[1], out[2]};
}

}  // namespace opaline
