// One pass of a Stockham transform along the rows or the columns of images of complex numbers that follow one another:
// no reordering, input and output apart. `radix` is a constant put before this text.
//
//   out[(j - k) radix + k + m done] = sum_q exp(-2 pi i q (k/done + m)/radix) in[j + q length/radix],  k = j mod done
//
// where `done` is the product of the radices of the passes before. Twiddles are a table: exp(-2 pi i t/length).
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Input { vec2 source[]; };
layout(std430, binding = 1) writeonly buffer Output { vec2 result[]; };
layout(std430, binding = 2) readonly buffer Twiddles { vec2 twiddles[]; };

uniform int line_length, done, element_step, line_step, image_step;
uniform float direction;  // 1 forward, -1 backward

vec2 times(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

vec2 twiddle(int t) {
  vec2 w = twiddles[t % line_length];
  return vec2(w.x, direction * w.y);
}

void main() {
  int part = line_length / radix, j = int(gl_GlobalInvocationID.x);
  if (j >= part) return;
  int base = int(gl_GlobalInvocationID.z) * image_step + int(gl_GlobalInvocationID.y) * line_step, k = j % done;
  vec2 values[radix];
  for (int q = 0; q < radix; ++q)
    values[q] = times(source[base + (j + q * part) * element_step], twiddle(q * k * (part / done)));
  int first = (j - k) * radix + k;
  for (int m = 0; m < radix; ++m) {
    vec2 sum = values[0];
    for (int q = 1; q < radix; ++q) sum += times(values[q], twiddle((q * m % radix) * part));
    result[base + (first + m * done) * element_step] = sum;
  }
}
