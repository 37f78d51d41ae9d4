// The shaders. A fragment of the film strip is a ray from the camera: in GLSL the formulas of where
// rays meet shapes are written anew, so that the ray caster and this renderer check each other.
#pragma once

#include <fmt/format.h>

#include <string>

namespace seam::render::gl {

// What fragments write: light that Lambert's law makes of colours, colours as they are, their
// places in a palette (one float a texel in place of four), or identity and distance along the ray.
enum class Writes { light, colour, index, truth };

// Before all text of a program.
inline constexpr const char* kVersion = "#version 330 core\n";
inline std::string program_head(Writes writes) {
  constexpr const char* kDefined[] = {"LIGHT", "COLOUR", "INDEX", "TRUTH"};
  return fmt::format("{}#define {}\n", kVersion, kDefined[static_cast<int>(writes)]);
}

// One instance is one shape at one instant: a rectangle of the strip that covers it.
inline constexpr const char* kShapeVertex = R"(
in vec4 place;  // First and last column (but for the rows' stagger) and row of the target.
in vec4 row_x, row_y, row_z;  // R_OV by rows, each with the camera's place in the object's frame.
in vec4 size;   // And the ambient light.
in vec4 light;  // And the factor on the depth.
in vec4 look;   // Red, green, blue; the identity.
in vec4 ray;    // What to add to a fragment's place, and what a texel is on the plane z = 1.
uniform vec4 target;  // 2 / width, 2 / height; the stagger.
flat out vec4 f_x, f_y, f_z, f_size, f_light, f_look, f_ray;
void main() {
  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));
  vec2 at = mix(place.xy, place.zw, corner);
  at.x += target.z * (at.y + ray.y) - ray.x;
  gl_Position = vec4(at * target.xy - 1.0, 0.0, 1.0);
  f_x = row_x; f_y = row_y; f_z = row_z;
  f_size = size; f_light = light; f_look = look; f_ray = ray;
}
)";

// One instance is one flat face at one instant: its two triangles, cut off at the rows of its band
// and before what the band can show of it.
inline constexpr const char* kFaceVertex = R"(
in vec4 centre, along_a, along_b;  // With the band's first row, its end, the nearest depth.
in vec4 plane, look, ray;
uniform vec4 target;  // 2 / width, 2 / height; the stagger.
flat out vec4 f_plane, f_look;
flat out vec4 f_ray;
out float gl_ClipDistance[2];
void main() {
  vec2 side = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
  vec3 p = centre.xyz + side.x * along_a.xyz + side.y * along_b.xyz;
  vec2 grid = p.xy / ray.zw;
  vec2 at = vec2(grid.x + target.z * grid.y, grid.y) - ray.xy * p.z;
  gl_Position = vec4(at * target.xy - p.z, p.z - 2.0 * along_b.w, p.z);
  gl_ClipDistance[0] = at.y - centre.w * p.z;
  gl_ClipDistance[1] = along_a.w * p.z - at.y;
  f_plane = plane; f_look = look; f_ray = ray;
}
)";

inline constexpr const char* kFaceFragment = R"(
flat in vec4 f_plane, f_look;
flat in vec4 f_ray;
uniform vec4 target;
out vec4 seen;
const float kNear = 1e-3;
void main() {
  vec2 grid = gl_FragCoord.xy + f_ray.xy;
  vec2 v = vec2(grid.x - target.z * grid.y, grid.y) * f_ray.zw;
  float nearness = dot(f_plane.xy, v) + f_plane.z;
  // Greater is nearer; a float keeps its digits all the way to far away.
  gl_FragDepth = min(kNear * nearness * f_plane.w, 1.0);
#if defined(TRUTH)
  seen = vec4(f_look.w, 1.0 / nearness, 0.0, 1.0);
#elif defined(INDEX)
  seen = vec4(f_look.w);
#else
  seen = vec4(f_look.rgb, 1.0);
#endif
}
)";

// Before each shape's own `bool meet(vec3 o, vec3 d, out float t, out vec3 n)`.
inline constexpr const char* kShapeFragmentHead = R"(
flat in vec4 f_x, f_y, f_z, f_size, f_light, f_look, f_ray;
uniform vec4 target;
uniform sampler2D picture;
out vec4 seen;
const float kNear = 1e-3;
)";

inline constexpr const char* kShapeFragmentTail = R"(
void main() {
  vec2 grid = gl_FragCoord.xy + f_ray.xy;
  vec3 v = vec3(vec2(grid.x - target.z * grid.y, grid.y) * f_ray.zw, 1.0);
  vec3 d = vec3(dot(f_x.xyz, v), dot(f_y.xyz, v), dot(f_z.xyz, v));
  vec3 o = vec3(f_x.w, f_y.w, f_z.w);
  float t;
  vec3 n;
  bool met = meet(o, d, t, n);
  vec3 p = o + t * d;
  vec3 base = textured(p, n) * f_look.rgb;
  if (!met || !(t > kNear)) discard;
  // Greater is nearer; a float keeps its digits all the way to far away.
  gl_FragDepth = min(kNear / t * f_light.w, 1.0);
#if defined(TRUTH)
  seen = vec4(f_look.w, t, 0.0, 1.0);
#elif defined(INDEX)
  seen = vec4(f_look.w);
#elif defined(LIGHT)
  seen = vec4(base * (f_size.w + max(dot(n, f_light.xyz), 0.0)), 1.0);
#else
  seen = vec4(base, 1.0);
#endif
}
)";

inline constexpr const char* kPlain = R"(
vec3 textured(vec3 p, vec3 n) { return vec3(1.0); }
)";
// A picture's first row is at the top: v runs down.
inline constexpr const char* kTexturedRectangle = R"(
vec3 textured(vec3 p, vec3 n) {
  vec2 at = p.xy / f_size.xy * vec2(0.5, -0.5) + 0.5;
  return texture(picture, at).rgb;
}
)";
// Upright on the four sides, as seen from outside; on top with its upper edge towards +y.
inline constexpr const char* kTexturedBox = R"(
vec3 textured(vec3 p, vec3 n) {
  vec3 q = p / f_size.xyz;
  vec2 at = abs(n.z) > 0.5 ? vec2(q.x * n.z, q.y)
          : abs(n.x) > 0.5 ? vec2(q.y * n.x, q.z) : vec2(-q.x * n.y, q.z);
  return texture(picture, at * vec2(0.5, -0.5) + 0.5).rgb;
}
)";

inline constexpr const char* kRectangle = R"(
bool meet(vec3 o, vec3 d, out float t, out vec3 n) {
  t = -o.z / d.z;
  n = vec3(0.0, 0.0, o.z >= 0.0 ? 1.0 : -1.0);
  vec2 at = abs(o.xy + t * d.xy);
  return at.x <= f_size.x && at.y <= f_size.y;
}
)";

// |o + t d| = R; the discriminant by the cross product, which keeps its digits for far spheres.
inline constexpr const char* kSphere = R"(
bool meet(vec3 o, vec3 d, out float t, out vec3 n) {
  vec3 m = cross(d, o);
  float dd = dot(d, d);
  float under = f_size.x * f_size.x * dd - dot(m, m);
  t = (-dot(d, o) - sqrt(max(under, 0.0))) / dd;
  n = (o + t * d) / f_size.x;
  return under >= 0.0;
}
)";

inline constexpr const char* kCylinder = R"(
bool meet(vec3 o, vec3 d, out float t, out vec3 n) {
  float a = max(dot(d.xy, d.xy), 1e-20);
  float b = dot(d.xy, o.xy);
  float m = d.x * o.y - d.y * o.x;
  float under = a * f_size.x * f_size.x - m * m;
  float half_way = sqrt(max(under, 0.0));
  float side = (-b - half_way) / a, away = (-b + half_way) / a;
  float foot = -o.z / d.z, top = (f_size.z - o.z) / d.z;
  float ends = min(foot, top);
  t = max(side, ends);
  n = ends > side ? vec3(0.0, 0.0, d.z > 0.0 ? -1.0 : 1.0)
                  : vec3((o.xy + t * d.xy) / f_size.x, 0.0);
  return under >= 0.0 && t <= min(away, max(foot, top));
}
)";

// Where a ray enters the endless tube beyond an end, it can only enter through that end's ball.
inline constexpr const char* kCapsule = R"(
bool meet(vec3 o, vec3 d, out float t, out vec3 n) {
  float a = max(dot(d.xy, d.xy), 1e-20);
  float m = d.x * o.y - d.y * o.x;
  float under = a * f_size.x * f_size.x - m * m;
  float side = (-dot(d.xy, o.xy) - sqrt(max(under, 0.0))) / a;
  float height = o.z + side * d.z;
  bool on_side = height >= 0.0 && height <= f_size.z;
  vec3 e = o - vec3(0.0, 0.0, height > f_size.z ? f_size.z : 0.0);
  vec3 k = cross(d, e);
  float dd = dot(d, d);
  float under_ball = f_size.x * f_size.x * dd - dot(k, k);
  float ball = (-dot(d, e) - sqrt(max(under_ball, 0.0))) / dd;
  t = on_side ? side : ball;
  vec3 p = o + t * d;
  n = (p - vec3(0.0, 0.0, clamp(p.z, 0.0, f_size.z))) / f_size.x;
  return under >= 0.0 && (on_side || under_ball >= 0.0);
}
)";

inline constexpr const char* kBox = R"(
bool meet(vec3 o, vec3 d, out float t, out vec3 n) {
  vec3 low = (-f_size.xyz - o) / d, high = (f_size.xyz - o) / d;
  vec3 enter = min(low, high), leave = max(low, high);
  t = max(enter.x, max(enter.y, enter.z));
  vec3 against = vec3(d.x > 0.0 ? -1.0 : 1.0, d.y > 0.0 ? -1.0 : 1.0, d.z > 0.0 ? -1.0 : 1.0);
  n = enter.z >= max(enter.x, enter.y) ? vec3(0.0, 0.0, against.z)
    : enter.x >= enter.y ? vec3(against.x, 0.0, 0.0) : vec3(0.0, against.y, 0.0);
  return t <= min(leave.x, min(leave.y, leave.z));
}
)";

// One triangle that covers the image.
inline constexpr const char* kGatherVertex = R"(
void main() {
  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
)";

// A fragment is a pixel. Its rays lie in two texels of `rays` for each table: places on the plane z
// = 1 and how they change along u, then how along v. Each column of two texels in `bands` is a band
// of its row: the texels' offset, the band's first row on the page and its last, then its weight.
inline constexpr const char* kGatherFragment = R"(
uniform sampler2D rays, bands, texels, palette;
uniform vec4 grid;   // Texels of x, of y along u, of y along v; the page's width.
uniform vec4 count;  // Texels of a pixel across and down, bands of a row, tables of rays.
uniform vec4 form;   // Rows of rays; the palette's width, 0 where texels are light themselves.
out vec4 sum;

vec3 light(vec2 at, vec4 band) {
  ivec2 place = ivec2(at.x * grid.x + at.y * grid.y + band.x, at.y * grid.z + band.y);
  place = clamp(place, ivec2(0), ivec2(int(grid.w) - 1, int(band.w)));
  vec4 texel = texelFetch(texels, ivec2(place.x, place.y + int(band.z)), 0);
  if (form.y == 0.0) return texel.rgb;
  int colour = int(texel.r), width = int(form.y);
  return texelFetch(palette, ivec2(colour % width, colour / width), 0).rgb;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec2 share = 1.0 / count.xy;
  vec3 all = vec3(0.0);
  for (int table = 0; table < int(count.w); ++table) {
    int row = 2 * table * int(form.x) + pixel.y;
    vec4 ray = texelFetch(rays, ivec2(pixel.x, row), 0);
    vec2 along_v = texelFetch(rays, ivec2(pixel.x, row + int(form.x)), 0).xy;
    vec3 seen = vec3(0.0);
    for (int k = 0; k < int(count.z); ++k) {
      float weight = texelFetch(bands, ivec2(2 * k + 1, pixel.y), 0).x;
      if (weight == 0.0) continue;
      vec4 band = texelFetch(bands, ivec2(2 * k, pixel.y), 0);
      vec3 at_once = vec3(0.0);
      for (int b = 0; b < int(count.y); ++b) {
        for (int a = 0; a < int(count.x); ++a) {
          vec2 d = (vec2(a, b) + 0.5) * share - 0.5;
          at_once += light(ray.xy + d.x * ray.zw + d.y * along_v, band);
        }
      }
      seen += weight * at_once;
    }
    if (int(count.w) == 1) all = seen;
    else all[table] = seen[table];
  }
  sum = vec4(all * share.x * share.y, 1.0);
}
)";

}  // namespace seam::render::gl
