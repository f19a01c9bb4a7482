#include "datasets_synthetic/shapes/bust_field.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using V = glm::dvec3;

/// Polynomial smooth minimum (I. Quilez): exact where the two differ by more than k.
double blend(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k / 4;
}
double carve(double a, double b, double k) { return -blend(-a, b, k); }  ///< a without b
double common(double a, double b, double k) { return -blend(-a, -b, k); }

double ball(const V& p, const V& centre, double radius) { return glm::length(p - centre) - radius; }

/// Ellipsoid, first-order distance (exact on the axes of a sphere).
double ellipsoid(const V& p, const V& centre, const V& radii) {
  const V q = (p - centre) / radii;
  const double k0 = glm::length(q), k1 = glm::length(q / radii);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

/// Capsule whose radius goes from ra at a to rb at b.
double limb(const V& p, const V& a, const V& b, double ra, double rb) {
  const V ab = b - a;
  const double t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0, 1.0);
  return glm::length(p - a - t * ab) - (ra + t * (rb - ra));
}

double smooth_step(double lo, double hi, double x) {
  const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Half-space of outward normal n through a point.
double plane(const V& p, const V& through, const V& n) { return glm::dot(p - through, glm::normalize(n)); }

double skull(const V& p) {
  double d = ellipsoid(p, {0, 38, -10}, {74, 80, 95});
  d = blend(d, ellipsoid(p, {0, 40, 30}, {60, 58, 56}), 20);       // forehead
  d = blend(d, ellipsoid(p, {0, -36, 32}, {59, 72, 55}), 28);      // face
  d = blend(d, limb(p, {46, -48, 4}, {15, -96, 66}, 14, 13), 24);  // jaw
  d = blend(d, ellipsoid(p, {0, -97, 73}, {20, 15, 17}), 14);      // chin
  return blend(d, ellipsoid(p, {42, -16, 54}, {17, 12, 18}), 26);  // cheekbone
}

double neck_and_shoulders(const V& p) {
  double d = limb(p, {0, -10, -34}, {0, -180, -52}, 45, 57);
  d = blend(d, limb(p, {46, -30, -30}, {9, -174, 12}, 9, 11), 20);       // neck muscle to the breastbone
  d = blend(d, limb(p, {26, -112, -56}, {104, -176, -52}, 28, 34), 36);  // trapezius
  d = blend(d, limb(p, {60, -196, -44}, {122, -196, -44}, 40, 40), 26);  // shoulder
  d = blend(d, ellipsoid(p, {0, -222, -26}, {118, 62, 66}), 24);         // chest
  d = blend(d, limb(p, {12, -178, 14}, {112, -168, -20}, 8, 8), 14);     // collar bone
  d = common(d, ellipsoid(p, {0, -120, -25}, {160, 150, 130}), 8);       // the sculptor's cut
  return common(d, plane(p, {0, bust_base, 0}, {0, -1, 0}), 8);
}

/// A wedge with its edge along the bridge; wings, tip and nostrils.
double with_nose(double d, const V& at) {
  const V p(std::sqrt(at.x * at.x + 12) - std::sqrt(12.0), at.y, at.z);  // rounds the bridge
  const V top(0, 16, 83), tip(0, -36, 116), wing(11.5, -40, 85);
  const V side = glm::cross(tip - top, wing - top);
  double nose = plane(p, tip, side.x > 0 ? side : -side);
  nose = common(nose, plane(p, {0, -43, 116}, {0, -0.95, 0.2}), 6);
  nose = common(nose, plane(p, {0, -36, 117}, {0, 0.2, 1}), 6);
  nose = common(nose, plane(p, {0, 0, 62}, {0, 0, -1}), 2);
  nose = common(nose, plane(p, {0, 30, 0}, {0, 1, 0}), 2);
  d = blend(d, nose, 7);
  d = blend(d, ellipsoid(p, {0, -37, 106}, {7, 7.5, 10}), 8);
  d = blend(d, ellipsoid(p, {9, -40, 91}, {6, 7, 11}), 6);
  return carve(d, limb(p, {4, -50, 98}, {4, -43, 96}, 3.2, 2.6), 4);
}

/// Socket and eyeball. The lids are a raised skin on the ball outside the almond between two parabolas.
double with_eyes(double d, const V& p) {
  d = blend(d, limb(p, {10, 18, 79}, {48, 15, 56}, 14, 6), 14);  // brow
  d = carve(d, ellipsoid(p, {32, 3, 91}, {21, 13, 16}), 10);     // socket
  d = carve(d, ellipsoid(p, {14, 8, 93}, {6, 9, 8}), 8);         // its inner corner
  const V q = p - V(32, 1.5, 67);
  const double above = q.y - (6.5 - 0.026 * q.x * q.x), below = -5 + 0.018 * q.x * q.x - q.y;
  const double lid = std::max(smooth_step(-1.5, 4.5, above), smooth_step(-1.5, 4.5, below));
  return blend(d, glm::length(q) - (13.2 + 3.2 * lid), 3);
}

double with_mouth(double d, const V& p) {
  d = blend(d, ellipsoid(p, {0, -67, 74}, {28, 22, 20}), 16);           // over the teeth
  d = carve(d, limb(p, {0, -52, 99}, {0, -58, 99.5}, 3, 3), 6);         // philtrum
  d = blend(d, limb(p, {4, -63, 91}, {21, -67, 84}, 5.8, 3.2), 5);      // upper lip
  d = blend(d, limb(p, {0, -75.5, 90}, {19, -71, 84.5}, 6.8, 3.4), 5);  // lower lip
  d = carve(d, limb(p, {0, -69.2, 99.5}, {23, -69, 90}, 2.2, 2), 4.5);  // between the lips
  return carve(d, ellipsoid(p, {0, -87, 98}, {18, 5, 7}), 8);           // above the chin
}

// --- the ear ---
// Frame: u from the head out and back, v up along the ear, w across the plate, forwards and outwards.
struct EarFrame {
  V origin{67, 2, -14}, u, v, w;
};
const EarFrame& ear_frame() {
  static const EarFrame frame = [] {
    EarFrame f;
    const double turn = 0.75, tilt = 0.22;
    f.u = {std::sin(turn), 0, -std::cos(turn)};
    f.w = {std::cos(turn), 0, std::sin(turn)};
    f.v = {0, 1, 0};
    const V u = f.u;
    f.u = std::cos(tilt) * u - std::sin(tilt) * f.v;
    f.v = std::cos(tilt) * f.v + std::sin(tilt) * u;
    return f;
  }();
  return frame;
}

/// Height of the plate's middle surface over the (u, v) plane: a bowl with a dip at the ear canal.
double ear_rise(double u, double v) {
  const double dip = std::exp(-((u - 4) * (u - 4) + (v + 5) * (v + 5)) / 110);
  return 0.008 * (u - 8) * (u - 8) + 0.003 * v * v - 2.0 * dip;
}

/// First-order distance to the ear's outline in the (u, v) plane: an egg, narrow at the lobe.
double ear_outline(double u, double v) {
  const double a = 21 * (1 + 0.009 * v), b = 32, x = (u - 13) / a, y = v / b;
  const double k0 = std::hypot(x, y), k1 = std::hypot(x / a, y / b);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -a;
}

double ear(const V& p) {
  const EarFrame& f = ear_frame();
  const V q = p - f.origin;
  const double u = glm::dot(q, f.u), v = glm::dot(q, f.v);
  constexpr double step = 1e-3;
  const double rise = ear_rise(u, v), ru = (ear_rise(u + step, v) - rise) / step,
               rv = (ear_rise(u, v + step) - rise) / step;
  const double over = (glm::dot(q, f.w) - rise) / std::sqrt(1 + ru * ru + rv * rv);
  const double outline = ear_outline(u, v);
  const double half = bust_ear_thickness / 2;
  // The plate: as thick as stated, with a round edge.
  const double edge = std::max(outline + half, 0.0);
  double d = std::hypot(edge, over) - half;
  const double rim = smooth_step(-26, -8, v) * smooth_step(-2, 6, u + 0.35 * v);
  d = blend(d, std::hypot(outline + 2.4, over - 2.2) - (0.6 + 2.0 * rim), 3.5);  // helix
  const double fold = smooth_step(-20, -10, v) * smooth_step(24, 10, v) * smooth_step(4, 12, u);
  d = blend(d, std::hypot(outline + 14, over - 1.6) - (0.6 + 2.0 * fold), 2.5);                            // antihelix
  d = blend(d, limb(p, f.origin - 6.0 * f.u + 20.0 * f.v, f.origin - 8.0 * f.u - 12.0 * f.v, 7, 5.5), 6);  // root
  d = blend(d, ellipsoid(p, f.origin + 13.0 * f.u - 27.0 * f.v + 1.0 * f.w, {6, 7, 6}), 4);                // lobe
  return blend(d, ellipsoid(p, f.origin + 1.0 * f.u - 6.0 * f.v + 2.0 * f.w, {3.5, 6, 4}), 6);             // tragus
}

/// |x| with its kink rounded off, so that parts given on one side join smoothly at the middle.
constexpr double fold_radius = 1.5;
double folded(double x) { return std::hypot(x, fold_radius) - fold_radius; }
double unfolded(double x) { return std::sqrt(x * (x + 2 * fold_radius)); }

}  // namespace

double bust_field(const glm::dvec3& at) {
  const V p(folded(at.x), at.y, at.z);
  double d = blend(skull(p), neck_and_shoulders(p), 26);
  // Details only matter near their places: outside the balls they change nothing.
  if (ball(p, {20, -30, 80}, 92) < 0) {
    d = with_eyes(d, p);
    d = with_nose(d, p);
    d = with_mouth(d, p);
  }
  const double ear_ball = ball(p, {82, 2, -22}, 46);
  if (ear_ball < 6 && ear_ball < d + 6) d = blend(d, ear(p), 5);
  return d;
}

Box bust_bounds() { return {{-172, bust_base - 8, -165}, {172, bust_crown + 8, 130}}; }

EarProbe bust_ear_probe() {
  const EarFrame& f = ear_frame();
  constexpr double u = 26, v = 8, step = 1e-4;
  const double ru = (ear_rise(u + step, v) - ear_rise(u - step, v)) / (2 * step);
  const double rv = (ear_rise(u, v + step) - ear_rise(u, v - step)) / (2 * step);
  V centre = f.origin + u * f.u + v * f.v + ear_rise(u, v) * f.w;
  centre.x = unfolded(centre.x);
  return {centre, glm::normalize(f.w - ru * f.u - rv * f.v)};
}

}  // namespace opaline
