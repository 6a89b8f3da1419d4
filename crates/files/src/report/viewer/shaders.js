// Shaders of the 3D view: surface, picking of faces, and rims.

// The arrays of a mesh are textures whose width is a power of two; the vertex shader fetches the data of a corner by the index of its face.
const FETCH = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
uniform usampler2D faceTexture, vertexTexture, numberTexture, factTexture, bendTexture;
uniform int wideBits;
uniform bool numbered;
ivec2 texel(int i) { return ivec2(i & ((1 << wideBits) - 1), i >> wideBits); }
int faceNumber() {
  int own = gl_VertexID / 3;
  return numbered ? int(texelFetch(numberTexture, texel(own), 0).r) : own;
}
// Hidden faces get a place outside of the picture.
vec4 unlessHidden(uint fact, vec4 at) { return (fact & 0x20000000u) != 0u ? vec4(2., 2., 2., 1.) : at; }
int vertexNumber() { return int(texelFetch(faceTexture, texel(gl_VertexID), 0).r); }
vec3 normalOf(uint folded) {
  vec2 p = vec2(float(folded & 65535u), float(folded >> 16)) / 32767.5 - 1.;
  vec3 n = vec3(p, 1. - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.);
  n.x += n.x < 0. ? fold : -fold;
  n.y += n.y < 0. ? fold : -fold;
  return normalize(n);
}`;

export const SURFACE_VERTEX = FETCH + `
uniform sampler2D valueTexture, colourTexture, cornerTexture, ambientTexture;
uniform mat4 matrix;
uniform vec3 eye;
uniform int colouring, valuesOn, shading;
uniform bool occluded, creased;
uniform vec2 span;
out vec3 seen;
out vec3 bent;
out vec3 corner;
out vec4 shown;
out float ambient;
out vec3 place;
flat out uint fact;
void main() {
  int k = gl_VertexID % 3, face = faceNumber(), vertex = vertexNumber();
  uvec4 v = texelFetch(vertexTexture, texel(vertex), 0);
  vec3 position = uintBitsToFloat(v.xyz);
  corner = vec3(k == 0, k == 1, k == 2);
  place = position;
  seen = position - eye;
  bent = normalOf(creased ? texelFetch(bendTexture, texel(3 * face + k), 0).r : v.w);
  fact = texelFetch(factTexture, texel(face), 0).r;
  int on = valuesOn == 0 ? vertex : valuesOn == 1 ? face : 3 * face + k;
  shown = vec4(0.);
  if (colouring == 1 || colouring == 2 || colouring == 5) shown.x = (texelFetch(valueTexture, texel(on), 0).r - span.x) / (span.y - span.x);
  if (colouring == 3) shown = texelFetch(colourTexture, texel(on), 0);
  if (colouring == 4) shown.xy = texelFetch(cornerTexture, texel(3 * face + k), 0).rg;
  ambient = shading == 4 && occluded ? texelFetch(ambientTexture, texel(vertex), 0).r : 1.;
  gl_Position = unlessHidden(fact, matrix * vec4(position, 1.0));
}`;

export const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
in vec3 seen;
in vec3 bent;
in vec3 corner;
in vec4 shown;
in float ambient;
in vec3 place;
flat in uint fact;
uniform vec3 right, up, towards, lamp;
// 0: default; 1: no colours of patches; 2: like a lit ball of clay; 3: reflections of stripes; 4: ambient light.
uniform int shading;
uniform vec3 base, patch_, chosen, inside, edge, mask, fault;
uniform int colouring;
uniform bool marks, faceted, skipKept, gaps;
uniform int colours;
uniform vec3 palette[16];
uniform float wire, earlier;
uniform vec2 limits;
uniform int selected;
uniform vec4 section;
uniform highp sampler2DArray images;
out vec4 colour;

vec3 diverging(float x) {
  float size = abs(x);
  vec3 middle = x < 0. ? vec3(.26, .56, .84) : vec3(.90, .42, .32), end = x < 0. ? vec3(.04, .20, .50) : vec3(.50, .03, .10);
  return size < .5 ? mix(vec3(.93, .93, .92), middle, 2. * size) : mix(middle, end, 2. * size - 1.);
}

vec3 rising(float x) {
  vec3 c = mix(vec3(.20, .17, .42), vec3(.16, .46, .56), clamp(3. * x, 0., 1.));
  c = mix(c, vec3(.42, .73, .40), clamp(3. * x - 1., 0., 1.));
  return mix(c, vec3(.97, .90, .25), clamp(3. * x - 2., 0., 1.));
}

// Values outside of the limits are faults, except negative ones; the others rise to an upper limit, or fall from a lower one.
vec3 limited(float x) {
  float size = abs(x);
  if (x >= 0. && (x < limits.x || x > limits.y)) return fault;
  float place = limits.y < 1e9 ? size / max(limits.y, 1e-6) : 1. - (size - limits.x) / max(1. - limits.x, 1e-6);
  return rising(clamp(place, 0., 1.));
}

void main() {
  if (dot(section.xyz, place) > section.w) discard;
  vec3 facet = normalize(cross(dFdx(place), dFdy(place)));
  bool back = !gl_FrontFacing;
  vec3 n = faceted ? facet : normalize(bent);
  if (faceted ? dot(n, seen) > 0. : back) n = -n;
  int region = int(fact & 65535u), origin = int(fact >> 16 & 3u);
  vec3 ground = base;
  if (origin == 2) ground = mix(base, patch_, earlier);
  if (origin == 1 && marks) ground = region == selected ? chosen : patch_;
  if (origin == 1 && marks && colours > 0) ground = palette[clamp(region - 1, 0, 15)];
  if (shading > 0) ground = base;
  bool valued = colouring != 0 && !(isnan(shown.x) || isinf(shown.x));
  if (colouring == 1 && valued) ground = diverging(2. * clamp(shown.x, 0., 1.) - 1.);
  if (colouring == 2 && valued && !(skipKept && origin == 0 && shown.x <= 0.)) ground = rising(clamp(shown.x, 0., 1.));
  // Unknown values are shown as grey stripes, which are not in the scale.
  if (gaps && shown.x < -.01) ground = vec3(mod(gl_FragCoord.x + gl_FragCoord.y, 12.) < 6. ? .72 : .52);
  // Unknown values are grey, also on patches.
  if (colouring == 5) ground = valued ? limited(shown.x) : vec3(.62);
  if (colouring == 3) ground = shown.rgb;
  int layer = int(fact >> 20 & 255u);
  if (colouring == 4 && valued && layer < 255) ground = texture(images, vec3(shown.xy, float(layer))).rgb;
  if (back && colouring == 0) ground = inside;
  if ((fact & 0x80000u) != 0u) ground = mix(ground, fault, .8);
  if ((fact & 0x40000u) != 0u) ground = mix(ground, mask, .62);
  if ((fact & 0x10000000u) != 0u) ground = mix(ground, vec3(.16, .55, .86), .62);
  vec3 eyeward = -normalize(seen);
  float head = max(dot(n, eyeward), 0.);
  vec3 lampward = normalize(lamp);
  float key = max(dot(n, lampward), 0.);
  float fill = max(dot(n, normalize(.4 * towards + right)), 0.);
  float light = colouring == 0 ? .22 + .34 * head + .54 * key + .14 * fill : .45 + .35 * head + .25 * key;
  float shine = back ? 0. : .10 * pow(max(dot(n, normalize(eyeward + lampward)), 0.), 26.);
  vec3 lit = ground * light * (back ? .8 : 1.) + (colouring == 0 ? shine : 0.);
  if (shading == 2 && colouring == 0) {
    float high = .5 + .5 * dot(n, lampward), side = 1. - head;
    vec3 clay = mix(vec3(.20, .16, .20), vec3(.86, .66, .52), high * high);
    lit = mix(clay + .35 * pow(high, 24.), vec3(.55, .66, .80), .5 * side * side * side) * (back ? .6 : 1.);
    if ((fact & 0x100c0000u) != 0u) lit = mix(lit, ground, .6);
  }
  if (shading == 3) {
    float angle = asin(clamp(dot(reflect(-eyeward, n), right), -1., 1.)) * 6., width = fwidth(angle);
    float stripe = smoothstep(-width, width, abs(fract(angle) - .5) - .25);
    lit = mix(lit, mix(vec3(.08), vec3(.97), stripe) * (.75 + .25 * head), back ? .3 : .85);
  }
  if (shading == 4) lit = ground * (back ? .8 : 1.) * (.12 + .88 * ambient) * (.62 + .25 * head + .16 * key);
  if (wire > 0.) {
    vec3 width = fwidth(corner);
    vec3 near = smoothstep(vec3(0.), width * 1.05, corner);
    float line = 1. - min(near.x, min(near.y, near.z));
    float room = 1. - smoothstep(.22, .6, max(width.x, max(width.y, width.z)));
    lit = mix(lit, edge, wire * line * room);
  }
  colour = vec4(lit, 1.);
}`;

export const RIM_VERTEX = `#version 300 es
precision highp float;
in vec3 from;
in vec3 to;
in float kind;
uniform mat4 matrix;
uniform vec2 size;
uniform float width, lift;
out float isKind;
out vec3 place;
void main() {
  vec4 a = matrix * vec4(from, 1.0), b = matrix * vec4(to, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * size;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1., 0.);
  int k = gl_VertexID;
  bool far = k == 1 || k == 2 || k == 4;
  float side = k == 0 || k == 1 || k == 3 ? -1. : 1.;
  vec4 p = far ? b : a;
  vec2 away = side * vec2(-along.y, along.x) + (far ? .5 : -.5) * along;
  p.xy += away * width / size * p.w;
  p.z -= lift * p.w;
  isKind = kind;
  place = far ? to : from;
  gl_Position = p;
}`;

export const RIM_FRAGMENT = `#version 300 es
precision highp float;
in float isKind;
in vec3 place;
uniform vec3 kinds[5];
uniform float strength, slack;
uniform vec4 section;
out vec4 colour;
void main() {
  if (dot(section.xyz, place) > section.w + slack) discard;
  colour = vec4(kinds[int(isKind + .5)], strength);
}`;

// The index of the visible face, plus one.

export const NUMBER_VERTEX = FETCH + `
uniform mat4 matrix;
out vec3 place;
flat out uint number;
void main() {
  uvec4 v = texelFetch(vertexTexture, texel(vertexNumber()), 0);
  place = uintBitsToFloat(v.xyz);
  number = uint(faceNumber()) + 1u;
  gl_Position = unlessHidden(texelFetch(factTexture, texel(faceNumber()), 0).r, matrix * vec4(place, 1.0));
}`;

export const NUMBER_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
in vec3 place;
flat in uint number;
uniform vec4 section;
out uvec4 seenNumber;
void main() {
  if (dot(section.xyz, place) > section.w) discard;
  seenNumber = uvec4(number, 0u, 0u, 0u);
}`;
