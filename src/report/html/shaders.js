// What the graphics card runs.

const SURFACE_VERTEX = `#version 300 es
precision highp float;
in vec3 position;
in vec3 normal;
in float region;
in vec2 values;
uniform mat4 matrix;
uniform vec3 eye;
out vec3 seen;
out vec3 bent;
out vec3 corner;
out vec2 shown;
flat out float piece;
void main() {
  int k = gl_VertexID % 3;
  corner = vec3(k == 0, k == 1, k == 2);
  seen = position - eye;
  bent = normal;
  shown = values;
  piece = region;
  gl_Position = matrix * vec4(position, 1.0);
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 seen;
in vec3 bent;
in vec3 corner;
in vec2 shown;
flat in float piece;
uniform vec3 right, up, towards;
uniform vec3 base, patch_, chosen, inside, edge;
uniform int colouring;
uniform bool isNew, isKept, marks, faceted;
uniform int colours;
uniform vec3 palette[16];
uniform float wire, selected;
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

void main() {
  vec3 facet = normalize(cross(dFdx(seen), dFdy(seen)));
  bool back = !gl_FrontFacing;
  vec3 n = faceted ? facet : normalize(bent);
  if (faceted ? dot(n, seen) > 0. : back) n = -n;
  vec3 ground = base;
  if (isNew && marks) ground = piece == selected ? chosen : patch_;
  if (isNew && marks && colours > 0) ground = palette[clamp(int(piece + .5) - 1, 0, 15)];
  if (colouring == 1) ground = diverging(shown.x);
  if (colouring == 2 && !isKept) ground = rising(shown.y);
  if (back && colouring == 0) ground = inside;
  vec3 eyeward = -normalize(seen);
  float head = max(dot(n, eyeward), 0.);
  float key = max(dot(n, normalize(towards + .7 * up - .55 * right)), 0.);
  float fill = max(dot(n, normalize(.4 * towards + right)), 0.);
  float light = colouring == 0 ? .22 + .34 * head + .54 * key + .14 * fill : .45 + .35 * head + .25 * key;
  float shine = back ? 0. : .10 * pow(max(dot(n, normalize(eyeward + normalize(towards + .7 * up - .55 * right))), 0.), 26.);
  vec3 lit = ground * light * (back ? .8 : 1.) + (colouring == 0 ? shine : 0.);
  if (wire > 0.) {
    vec3 width = fwidth(corner);
    vec3 near = smoothstep(vec3(0.), width * 1.05, corner);
    float line = 1. - min(near.x, min(near.y, near.z));
    float room = 1. - smoothstep(.22, .6, max(width.x, max(width.y, width.z)));
    lit = mix(lit, edge, wire * line * room);
  }
  colour = vec4(lit, 1.);
}`;

const RIM_VERTEX = `#version 300 es
precision highp float;
in vec3 from;
in vec3 to;
in float open;
uniform mat4 matrix;
uniform vec2 size;
uniform float width, lift;
out float isOpen;
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
  isOpen = open;
  gl_Position = p;
}`;

const RIM_FRAGMENT = `#version 300 es
precision highp float;
in float isOpen;
uniform vec3 done, left;
uniform float strength;
out vec4 colour;
void main() {
  colour = vec4(isOpen > .5 ? left : done, strength);
}`;

// Depth alone, in the bytes of a colour: the distance along the view as a part of `far`.

const DEPTH_VERTEX = `#version 300 es
precision highp float;
in vec3 position;
uniform mat4 matrix;
out float depth;
void main() {
  gl_Position = matrix * vec4(position, 1.0);
  depth = gl_Position.w;
}`;

const DEPTH_FRAGMENT = `#version 300 es
precision highp float;
in float depth;
uniform float far;
out vec4 colour;
void main() {
  float d = clamp(depth / far, 0., .999999) * 255.;
  vec3 bytes = vec3(floor(d), floor(fract(d) * 255.), floor(fract(fract(d) * 255.) * 255.));
  colour = vec4(bytes / 255., 1.);
}`;
