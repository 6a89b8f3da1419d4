// Vectors, rotations and the camera.

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const unit = (a) => times(a, 1 / (Math.hypot(...a) || 1));

/** The frame of a camera: unit vectors to the right, up and towards the eye, for an eye in the direction `towards`. */
export function frame(towards, up) {
  towards = unit(towards);
  let right = cross(up, towards);
  if (Math.hypot(...right) < 0.03) right = cross(Math.abs(towards[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0], towards);
  right = unit(right);
  return [right, cross(towards, right), towards];
}

/** A frame rotated about a unit axis. */
export function turned(axes, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  const turn = (v) => plus(plus(times(v, c), times(cross(axis, v), s)), times(axis, dot(axis, v) * (1 - c)));
  const towards = unit(turn(axes[2])), right = unit(minus(turn(axes[0]), times(towards, dot(turn(axes[0]), towards))));
  return [right, cross(towards, right), towards];
}

/** The frame at a fraction `part` of the shortest rotation from one frame to another. */
export function between(from, to, part) {
  // The rotation between the frames: the angle from its trace, the axis from its antisymmetric part.
  const trace = dot(from[0], to[0]) + dot(from[1], to[1]) + dot(from[2], to[2]);
  const angle = Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2)));
  if (angle < 1e-4) return to;
  let axis = plus(plus(cross(from[0], to[0]), cross(from[1], to[1])), cross(from[2], to[2]));
  if (Math.hypot(...axis) < 1e-3) axis = from[1];
  return part === 1 ? to : turned(from, unit(axis), angle * part);
}

/** Half the angle of view, in radians. */
export const HALF_FIELD = 0.25;
/** Half the angle of view, in radians, that equals a parallel projection up to a thousandth of the distances. */
export const PARALLEL = 0.001;

/** A camera that looks at `centre`; the smaller side of the picture spans `reach` to both sides of it. */
export class Camera {
  constructor(radius) {
    this.radius = radius;
    this.centre = [0, 0, 0];
    this.axes = frame([0, -1, 0.3], [0, 0, 1]);
    this.reach = radius;
    this.field = HALF_FIELD;
  }

  get distance() {
    return this.reach / Math.tan(this.field);
  }

  get eye() {
    return plus(this.centre, times(this.axes[2], this.distance));
  }

  orbit(x, y) {
    this.axes = turned(turned(this.axes, this.axes[1], -x), this.axes[0], -y);
  }

  /** Shifts the picture; x and y are fractions of its smaller half side. */
  shift(x, y) {
    this.centre = plus(this.centre, plus(times(this.axes[0], -x * this.reach), times(this.axes[1], y * this.reach)));
  }

  /** Zooms so that the point under the pointer stays there; x and y are fractions of the smaller half side. */
  zoom(factor, x = 0, y = 0) {
    const reach = Math.min(Math.max(this.reach * factor, 1e-5 * this.radius), 20 * this.radius);
    const moved = this.reach - reach;
    this.centre = plus(this.centre, plus(times(this.axes[0], x * moved), times(this.axes[1], y * moved)));
    this.reach = reach;
  }

  /** The projection matrix from the scene to the screen, column by column. */
  matrix(aspect) {
    const [r, u, t] = this.axes, eye = this.eye;
    const far = Math.hypot(...eye) + 1.01 * this.radius;
    const near = Math.max(this.distance - this.radius - Math.hypot(...this.centre), 0.01 * this.distance);
    const y = 1 / Math.tan(this.field) * Math.min(1, aspect), x = y / aspect;
    const a = (far + near) / (far - near), b = 2 * far * near / (far - near);
    const rows = [
      [x * r[0], x * r[1], x * r[2], -x * dot(r, eye)],
      [y * u[0], y * u[1], y * u[2], -y * dot(u, eye)],
      [-a * t[0], -a * t[1], -a * t[2], a * dot(t, eye) - b],
      [-t[0], -t[1], -t[2], dot(t, eye)],
    ];
    return Float32Array.from({ length: 16 }, (_, i) => rows[i % 4][i / 4 | 0]);
  }

  /** The direction from the eye through a point of the screen; x and y are fractions of the smaller half side. */
  ray(x, y) {
    const s = Math.tan(this.field), [r, u, t] = this.axes;
    return unit(minus(plus(times(r, x * s), times(u, y * s)), t));
  }
}
