// Calls the installed library and checks one number that is known without it.
#include "model/fresnel.h"

#include <cmath>
#include <cstdio>

int main() {
  // 1 - (1 - R_e) / eta^2, where R_e = 0.091778 is Fresnel's external reflectance of diffuse light at eta = 1.5.
  const double expected = 0.596346;
  const double value = opaline::diffuse_reflectance_internal(1.5);
  std::printf("diffuse_reflectance_internal(1.5) = %.6f, expected %.6f\n", value, expected);
  return std::abs(value - expected) < 5e-6 ? 0 : 1;
}
