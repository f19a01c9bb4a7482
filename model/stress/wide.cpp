#include "model/stress/wide.h"

#include <array>

namespace opaline::fresnel_detail {
namespace {

/// The same number under another type, for which the templates are the general ones.
using General = boost::multiprecision::number<
    boost::multiprecision::mpfr_float_backend<100, boost::multiprecision::allocate_dynamic>,
    boost::multiprecision::et_off>;

struct Remembered {
  Side side = Side::thin;
  Wide x = -1, value = 0;
};

}  // namespace

template <>
Wide entering_series<Wide>(const Wide& x) {
  if (x < 1e-3) return Wide(entering_series(General(x)));
  return entering_closed(x, Wide((1.0 - x) / (1.0 + x)));
}

template <>
Wide second_series<Wide>(Side side, const Wide& x) {
  thread_local std::array<Remembered, 8> memory;
  thread_local std::size_t next = 0;
  for (const Remembered& known : memory) {
    if (known.side == side && known.x == x) return known.value;
  }
  memory[next] = {side, x, Wide(second_series(side, General(x)))};
  Wide value = memory[next].value;
  next = (next + 1) % memory.size();
  return value;
}

}  // namespace opaline::fresnel_detail
