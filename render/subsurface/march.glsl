// Subsurface texture mapping's march from one point of the surface: the one text of it. subsurface_texture.frag runs it
// for a pixel, march_kernel.cpp for a vector of pixels. march.h and subsurface_texture.md say what it computes.
//
// It is GLSL; as C++ it stands inside a struct, after march_lanes.h. Common to both are
//   Real, Real2, Real3, Mask, Bits   float, vec2, vec3, bool, int, of one point or of a vector of points
//   FORMULA, IN(T), INOUT(T)         starts a function; a parameter that is read; one that is changed as well
//   choose(m, a, b), some(m)         a where m holds, else b; whether m holds for any point
//   exp_minus(x), inverse_root(x)    e^-x for x >= 0; 1/sqrt(x) for normal x > 0, as a / b is for normal b
// and given before this text are the constants
//   int layers, lights, samples; bool by_pieces; most_layers, most_lights: sizes of arrays
//   vec3 sigma_s[k], sigma_t[k] of each layer, k = layers being what is below the last, which doesn't scatter
//   vec4 phase_of[k]                 base, slope, front of phase(); 1 for Schlick's
//   vec3 light_place[l], light_power[l]; float light_far[l]
//   float largest_depth, negligible, least_view_cosine
// and Depths boundaries(Real2 uv), where layers end [mm]; Mask sees(Bits lights, int l), sees_any(Bits lights);
//   FarSide far_side(int l), of the point that marches: where light l comes in that its planes turn away from

/// A point of the surface, its planes and how texture coordinates change round it: FramedPoint.
struct Point {
  Real3 position, normal, w_o, plane_normal, gradient_u, gradient_v;
  Real plane_height;
  Real2 uv;
  Real exit, exit_cosine;  ///< where the view leaves [mm], and its cosine with the surface there
  Bits lights;  ///< those that it sees
};

/// What a march has gathered so far.
struct March {
  Real3 sum, through;  ///< radiance towards the viewer; transmittance from the point to here
  Real steps, light_paths, from_behind, deepest;
};

/// The view ray inside: all that doesn't change along it.
struct Ray {
  Point p;
  Real length;
  Real3 end;       ///< M_max, from the point
  Real3 to_plane;  ///< from M_max to the point of its plane
  Real2 uv_end;    ///< M_max's texture coordinates, less the point's
};

/// A sample M at the share t of the way, and the plane that stands for the surface there.
struct Sample {
  float t;
  Real3 normal;
  Real depth;  ///< below the plane
  Real place;  ///< that, or below where the view leaves if that is nearer: it says in which layer the sample is
  Real2 uv;
  Depths ends;
};

/// One light at one sample.
struct Arrival {
  Mask lit;
  Real falloff;  ///< irradiance facing the light over its power, without extinction
  Real turn;     ///< 1 - cosine of the angle by which light turns that goes on to the viewer
  Real3 tau;     ///< optical depth on the way
};
struct Arrivals {
  Arrival of[most_lights];
};
/// What is left of each light where the march is.
struct Transmittances {
  Real3 of[most_lights];
};

FORMULA Real largest(Real3 v) { return max(v.x, max(v.y, v.z)); }

/// A layer's coefficients, each point's own.
struct Layer {
  Real3 sigma_s, sigma_t;
  Real base, slope, front;  ///< of the phase function
  Mask schlick;
  Real number;
};

FORMULA Layer layer_of(int k) {
  Layer layer;
  layer.sigma_s = sigma_s[k];
  layer.sigma_t = sigma_t[k];
  layer.base = phase_of[k].x;
  layer.slope = phase_of[k].y;
  layer.front = phase_of[k].z;
  layer.schlick = Mask(phase_of[k].w > 0.0f);
  layer.number = float(k + 1);
  return layer;
}

FORMULA Layer either(Mask m, IN(Layer) a, IN(Layer) b) {
  Layer layer;
  layer.sigma_s = choose(m, a.sigma_s, b.sigma_s);
  layer.sigma_t = choose(m, a.sigma_t, b.sigma_t);
  layer.base = choose(m, a.base, b.base);
  layer.slope = choose(m, a.slope, b.slope);
  layer.front = choose(m, a.front, b.front);
  layer.schlick = (m && a.schlick) || (!m && b.schlick);
  layer.number = choose(m, a.number, b.number);
  return layer;
}

/// Schlick's or Henyey and Greenstein's phase function [1/sr]: front over the square, or the 3/2 power, of
/// base + |slope| times the distance of the cosine from the peak, which is at 1, for slope < 0 at -1: so no digits go
/// where the function is largest.
FORMULA Real phase(IN(Layer) layer, Real turn) {
  Real root = inverse_root(layer.base + abs(layer.slope) * choose(layer.slope < 0.0f, 2.0f - turn, turn));
  return layer.front * (root * root * root) * choose(layer.schlick, root, 1.0f);
}

/// Mean of e^-x over a way on which it goes from e0 to e1, x growing by delta.
FORMULA Real mean_between(Real e0, Real e1, Real delta) {
  Mask far = abs(delta) > 0.02f;
  Real near = e0 * (1.0f - delta * (0.5f - delta * (1.0f / 6.0f - delta * (1.0f / 24.0f))));
  return choose(far, (e0 - e1) / choose(far, delta, 1.0f), near);
}
FORMULA Real3 mean_between(Real3 e0, Real3 e1, Real3 delta) {
  return Real3(mean_between(e0.x, e1.x, delta.x), mean_between(e0.y, e1.y, delta.y),
               mean_between(e0.z, e1.z, delta.z));
}

FORMULA Ray view_ray(IN(Point) p) {
  Ray r;
  r.p = p;
  r.length = min(largest_depth / max(dot(p.plane_normal, p.w_o), least_view_cosine), p.exit);
  r.end = p.w_o * -r.length;
  r.to_plane = p.normal * p.plane_height - r.end;
  r.uv_end = Real2(dot(p.gradient_u, r.end), dot(p.gradient_v, r.end));
  return r;
}

FORMULA Sample sample_at(IN(Ray) r, float t) {
  Sample s;
  s.t = t;
  // The print of algorithm 2 has these weights the other way round for the normal.
  Real3 n = r.p.normal * (1.0f - t) + r.p.plane_normal * t;
  Real square = dot(n, n);
  Mask blends = square > 1e-12f;
  s.normal = choose(blends, n * inverse_root(choose(blends, square, 1.0f)), r.p.normal);
  s.depth = max(t * dot(r.to_plane, s.normal), 0.0f);
  s.place = min(s.depth, max((r.p.exit - r.length * t) * r.p.exit_cosine, 0.0f));
  s.uv = r.p.uv + r.uv_end * t;
  s.ends = boundaries(s.uv);
  return s;
}

/// Way of light from K, where it enters a plane, to a sample.
struct LightWay {
  Mask far;            ///< K is on the far side
  Real depth, cosine;  ///< of the sample below K's plane, and of the way with its normal
  Real sinking;        ///< cosine of the way with the near plane, downwards
  Real2 uv;            ///< of K
};

/// Optical depth from the surface straight down.
FORMULA Real3 depth_below(IN(Depths) ends, Real depth) {
  Real left = depth, above = 0.0f;
  Real3 tau = Real3(0.0f);
  for (int j = 0; j < layers; ++j) {
    Real part = min(left, ends.of[j] - above);
    tau += part * sigma_t[j];
    left -= part;
    above = ends.of[j];
  }
  return tau + left * sigma_t[layers];
}

/// Optical depth of the way: equations 10 to 12, with the mean of the thicknesses that equation 12 means. From the far
/// side it is in K's layers as far as K's plane is nearer, then in the sample's.
FORMULA Real3 depth_of_way(IN(Sample) s, IN(LightWay) way) {
  Depths ends = boundaries(way.uv);
  for (int j = 0; j < layers; ++j) ends.of[j] = choose(way.far, ends.of[j], 0.5f * (s.ends.of[j] + ends.of[j]));
  Real per_cosine = 1.0f / way.cosine, length = way.depth * per_cosine;
  Real half_way = min((s.place + length * way.sinking) / (way.cosine + way.sinking), length);
  Real3 tau = depth_below(ends, choose(way.far, half_way * way.cosine, way.depth)) * per_cosine;
  if (some(way.far)) {
    Real3 rest = depth_below(s.ends, s.place + (length - half_way) * way.sinking) - depth_below(s.ends, s.place);
    tau += choose(way.far, rest * (1.0f / way.sinking), Real3(0.0f));
  }
  return tau;
}

FORMULA Arrival arrival(IN(Ray) r, IN(Sample) s, int l) {
  Arrival a;
  Real3 w_i = light_place[l];
  a.falloff = 1.0f;
  if (light_far[l] == 0.0f) {
    Real3 to_light = w_i - (r.p.position + r.end * s.t);
    Real inverse = inverse_root(max(dot(to_light, to_light), 1e-30f));
    w_i = to_light * inverse;
    a.falloff = inverse * inverse;
  }
  FarSide side = far_side(l);
  Real near_cosine = dot(s.normal, w_i), far_cosine = dot(side.normal, w_i);
  Real far_depth = side.height - s.t * dot(side.normal, r.end);
  // The view may leave where the light comes in: roundings must not decide whether it is lit there.
  Mask near = near_cosine > 1e-4f, far = far_cosine > 1e-4f && far_depth > -1e-3f * r.length;
  LightWay way;
  // A convex surface lies below all its planes: the nearer one says more.
  way.far = far && (!near || far_depth * near_cosine < s.depth * far_cosine);
  way.depth = choose(way.far, far_depth, s.depth);
  way.cosine = choose(way.far, far_cosine, near_cosine);
  a.lit = sees(r.p.lights, l) && (near || far);
  a.turn = 1.0f + clamp(dot(w_i, r.p.w_o), -1.0f, 1.0f);
  a.tau = Real3(0.0f);
  if (some(a.lit)) {
    way.depth = max(way.depth, 0.0f);
    way.cosine = max(way.cosine, 1e-4f);
    way.sinking = max(-dot(s.normal, w_i), 0.01f);
    Real2 change = Real2(dot(r.p.gradient_u, w_i), dot(r.p.gradient_v, w_i));
    way.uv = choose(way.far, side.uv, s.uv + change * (way.depth / way.cosine));
    a.tau = depth_of_way(s, way);
  }
  return a;
}

/// All lights at a sample; only points of `asking` count them.
FORMULA void arrive(IN(Ray) r, IN(Sample) s, Mask asking, INOUT(Arrivals) arrivals, INOUT(March) m) {
  int l = 0;
  do {
    arrivals.of[l] = arrival(r, s, l);
    m.light_paths += choose(asking && arrivals.of[l].lit, 1.0f, 0.0f);
    m.from_behind += choose(asking && sees(r.p.lights, l) && !arrivals.of[l].lit, 1.0f, 0.0f);
  } while (++l < lights);
}

/// Where the step from a to b crosses the end of layer k: a share of it, 2 if it doesn't.
FORMULA Real crossing(IN(Sample) a, IN(Sample) b, int k) {
  Real above_a = a.ends.of[k] - a.place, above_b = b.ends.of[k] - b.place;
  Mask crosses = (above_a > 0.0f) != (above_b > 0.0f);
  return choose(crosses, abs(above_a) / max(abs(above_a) + abs(above_b), 1e-30f), 2.0f);
}

/// The layer at a share t of the step.
FORMULA Layer layer_at(IN(Sample) a, IN(Sample) b, Real t) {
  Layer layer = layer_of(0);
  int k = 0;
  do {
    Real above_a = a.ends.of[k] - a.place, above_b = b.ends.of[k] - b.place;
    Mask below = above_a + t * (above_b - above_a) <= 0.0f;
    if (some(below)) layer = either(below, layer_of(k + 1), layer);
  } while (++k < layers);
  return layer;
}

/// What one light sends on over the piece t0 .. t1 of a step, without the light's power. The light's optical depth
/// changes evenly between the step's ends x and y, so that the integral has a closed form. left: of the light at the
/// piece's start, then at its end; fade: the view ray's optical depth over the piece; before, after: its transmittance.
FORMULA Real3 scattered(IN(Layer) layer, Real t0, Real t1, Real3 fade, Real3 before, Real3 after, IN(Arrival) x,
                        IN(Arrival) y, INOUT(Real3) left) {
  // Lit at one end alone: as there, and half of it, since the light's edge is somewhere between.
  Real3 tau_y = choose(y.lit, y.tau, x.tau), tau_x = choose(x.lit, x.tau, tau_y), change = tau_y - tau_x;
  Real3 at_end = exp_minus(choose(t1 < 1.0f, tau_x + change * t1, tau_y)), at_start = choose(x.lit, left, at_end);
  Real source = choose(x.lit, x.falloff * phase(layer, x.turn), 0.0f) +
                choose(y.lit, y.falloff * phase(layer, y.turn), 0.0f);
  left = at_end;
  return layer.sigma_s * mean_between(before * at_start, after * at_end, fade + change * (t1 - t0)) * (0.5f * source);
}

/// A step, in pieces of one layer each. asks: where it is known what light comes to its ends.
FORMULA void add_step(IN(Sample) a, IN(Sample) b, Mask alive, Mask asks, Real step_length, IN(Arrivals) from,
                      IN(Arrivals) to, INOUT(Transmittances) left, INOUT(March) m) {
  Real t0 = choose(alive, 0.0f, 1.0f);
  do {
    Real t1 = 1.0f;
    for (int k = 0; k < layers; ++k) {
      Real cut = crossing(a, b, k);
      t1 = choose(cut > t0, min(t1, cut), t1);
    }
    Layer layer = layer_at(a, b, 0.5f * (t0 + t1));
    Mask here = t1 > t0;
    Real part = (t1 - t0) * step_length;
    Real3 fade = layer.sigma_t * part, after = m.through * exp_minus(fade);
    if (some(asks && here)) {
      int l = 0;
      do {
        Real3 light = scattered(layer, t0, t1, fade, m.through, after, from.of[l], to.of[l], left.of[l]);
        m.sum += choose(asks && here, light * light_power[l] * part, Real3(0.0f));
      } while (++l < lights);
    }
    m.through = after;
    m.deepest = choose(here, max(m.deepest, layer.number), m.deepest);
    t0 = t1;
  } while (some(t0 < 1.0f));
}

/// Algorithm 1 as printed: the sample's light times the step, then the step's extinction.
FORMULA void add_sample(IN(Sample) a, IN(Sample) b, Mask alive, Real step_length, IN(Arrivals) from, INOUT(March) m) {
  Layer layer = layer_at(a, b, 0.0f);
  int l = 0;
  do {
    Real source = from.of[l].falloff * phase(layer, from.of[l].turn) * step_length;
    m.sum += choose(alive && from.of[l].lit,
                    m.through * exp_minus(from.of[l].tau) * layer.sigma_s * light_power[l] * source, Real3(0.0f));
  } while (++l < lights);
  m.through = choose(alive, m.through * exp_minus(layer.sigma_t * step_length), m.through);
  m.deepest = choose(alive, max(m.deepest, layer.number), m.deepest);
}

FORMULA Mask in_layers(IN(Sample) s) { return s.place < s.ends.of[layers - 1]; }

FORMULA March march(IN(Point) p) {
  March m;
  m.sum = Real3(0.0f);
  m.through = Real3(1.0f);
  m.steps = 0.0f;
  m.light_paths = 0.0f;
  m.from_behind = 0.0f;
  m.deepest = 0.0f;
  Mask alive = sees_any(p.lights);
  if (!some(alive)) return m;
  Ray ray = view_ray(p);
  Real step_length = ray.length / float(samples);
  Sample from = sample_at(ray, 0.0f), to = sample_at(ray, 1.0f / float(samples)), next;
  Arrivals from_lights, to_lights;
  Transmittances left;
  arrive(ray, from, alive, from_lights, m);
  // Steps that nobody asks about leave to_lights as it is.
  for (int l = 0; l < lights; ++l) to_lights.of[l] = from_lights.of[l], left.of[l] = exp_minus(from_lights.of[l].tau);
  int i = 1;
  do {
    next = to;
    if (i < samples) next = sample_at(ray, float(i + 1) / float(samples));
    m.steps += choose(alive, 1.0f, 0.0f);
    // Below the last layer nothing scatters: what light comes there, nobody asks.
    Mask asks = alive && (in_layers(from) || in_layers(to) || in_layers(next));
    if (some(asks)) arrive(ray, to, asks, to_lights, m);
    if (by_pieces)
      add_step(from, to, alive, asks, step_length, from_lights, to_lights, left, m);
    else
      add_sample(from, to, alive, step_length, from_lights, m);
    alive = alive && largest(m.through) >= negligible;
    from = to;
    to = next;
    for (int l = 0; l < lights; ++l) from_lights.of[l] = to_lights.of[l];
  } while (++i <= samples && some(alive));
  m.sum = choose(largest(m.sum) < 1e30f, m.sum, Real3(0.0f));
  return m;
}
