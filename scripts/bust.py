"""A bust as an implicit surface: ellipsoids that are joined smoothly, with a face, ears and hair; and meshes of it. It needs only numpy."""

import numpy as np
from benchmark import surfaces


def bump(p, at, size):
    return np.exp(-((((p - at) / size) ** 2).sum(axis=-1)))


def ball(p, at, radii):
    """Nearly the distance from an ellipsoid, negative inside."""
    return (np.linalg.norm((p - at) / np.array(radii), axis=-1) - 1) * min(radii)


def join(a, b, width):
    """The smooth minimum of two implicit functions."""
    part = np.clip(0.5 + 0.5 * (b - a) / width, 0, 1)
    return b * (1 - part) + a * part - width * part * (1 - part)


def rod(p, a, b, radius):
    a, b = np.array(a), np.array(b)
    part = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - part[..., None] * (b - a), axis=-1) - radius


def uncut(p):
    """The implicit function of a head with neck and shoulders. It looks along -y and is symmetric in x; the head's radius is about 0.8."""
    half = np.abs(p[..., :1]) * (1, 0, 0) + p * (0, 1, 1)
    f = join(ball(p, (0, 0.06, 0.2), (0.7, 0.84, 0.86)), ball(p, (0, -0.26, -0.45), (0.46, 0.5, 0.52)), 0.25)
    f = join(f, rod(p, (0, 0.12, -0.6), (0, 0.2, -1.35), 0.37), 0.15)
    f = join(f, ball(p, (0, 0.2, -1.72), (1.05, 0.52, 0.5)), 0.22)
    nose = join(rod(p, (0, -0.76, 0.12), (0, -0.95, -0.16), 0.06), rod(half, (0.02, -0.9, -0.18), (0.07, -0.82, -0.19), 0.065), 0.07)
    f = join(f, nose, 0.08)
    f = join(f, np.maximum(ball(half, (0.72, 0.05, 0), (0.11, 0.19, 0.27)), -ball(half, (0.85, -0.04, 0.02), (0.12, 0.1, 0.17))), 0.05)
    f = f + 0.11 * bump(half, (0.27, -0.8, 0.1), (0.15, 0.14, 0.1)) - 0.085 * bump(half, (0.26, -0.8, 0.09), (0.09, 0.1, 0.06))
    f = f + 0.025 * bump(half, (0.26, -0.8, 0.09), (0.13, 0.2, 0.014)) - 0.06 * bump(half, (0.27, -0.8, 0.27), (0.18, 0.14, 0.055))
    f = f - 0.06 * bump(p, (0, -0.76, -0.43), (0.15, 0.12, 0.045)) - 0.07 * bump(p, (0, -0.74, -0.56), (0.13, 0.12, 0.05))
    f = f + 0.03 * bump(p, (0, -0.8, -0.495), (0.17, 0.12, 0.014)) - 0.05 * bump(p, (0, -0.72, -0.82), (0.14, 0.12, 0.1))
    # Hair: a cap with waves, above a line from the forehead to the neck.
    over = 1 / (1 + np.exp(-30 * (p[..., 2] - 0.42 + 0.75 * (p[..., 1] + 0.35)))) / (1 + np.exp(-40 * (p[..., 2] + 0.62)))
    waves = np.sin(26 * (p[..., 2] - 0.35 * p[..., 1] + 0.06 * np.sin(9 * np.abs(p[..., 0]))))
    f = f - over * (0.06 + 0.013 * waves) * (1 - bump(half, (0.74, 0.05, 0), 0.25))
    return f


def bust(p):
    """The bust of the pictures, which ends below the shoulders."""
    return -join(-uncut(p), p[..., 2] + 1.75, 0.04)


def with_chest(p):
    """The bust of data/scan.ply, with a chest and a flat base."""
    return -join(-join(uncut(p), ball(p, (0, 0.14, -2.05), (0.8, 0.5, 0.75)), 0.25), p[..., 2] + 2.3, 0.06)


# --- a mesh of the bust with a chest --------------------------------------------------------------------------------

# Distance from the vertical axis and height of a surface of revolution that is like the bust, from the crown to the base.
PROFILE = np.array([
    (0, 1.1), (0.4, 1.0), (0.68, 0.75), (0.8, 0.35), (0.75, 0), (0.62, -0.35), (0.48, -0.7), (0.42, -0.95), (0.45, -1.2), (0.6, -1.38),
    (0.72, -1.6), (0.76, -1.9), (0.68, -2.15), (0.55, -2.3), (0, -2.3),
])  # fmt: skip
AXIS = 0.12  # the y coordinate of the axis
NECK = -0.95  # the height that the equator of the sphere is mapped to
FARTHEST = 1.5  # every ray leaves the bust before this length


def conformal(steps=4000):
    """The conformal map of the unit sphere to the surface of revolution: polar angles, with the radius and the height for each."""
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(PROFILE, axis=0), axis=1))])
    at = np.linspace(0, along[-1], steps + 1)
    radius, height = np.interp(at, along, PROFILE[:, 0]), np.interp(at, along, PROFILE[:, 1])
    # A map is conformal if the logarithm of tan(polar / 2) grows with the arc length over the radius.
    grown = np.concatenate([[0], np.cumsum(np.diff(at) / ((radius[1:] + radius[:-1]) / 2))])
    return 2 * np.arctan(np.exp(grown - grown[np.argmin(abs(height - NECK))])), radius, height


POLAR, RADIUS, HEIGHT = conformal()


def of_revolution(d):
    """Polar angles of directions, and the radius and the height of the surface of revolution there."""
    polar = np.arccos(np.clip(d[:, 2], -1, 1))
    return polar, np.interp(polar, POLAR, RADIUS), np.interp(polar, POLAR, HEIGHT)


def on_bust(d):
    """The points of the bust for directions d, and the outward directions of the rays that find them. The rays start on the axis, are
    horizontal at the face, and spread at the crown and the base. Of several points on a ray the outermost is taken."""
    _, radius, height = of_revolution(d)
    around = d[:, :2] / np.maximum(np.linalg.norm(d[:, :2], axis=1), 1e-12)[:, None]
    start = np.column_stack([0 * height, np.full(len(d), AXIS), np.clip(height, -1.75, 0.3)])
    way = np.column_stack([around * radius[:, None], height - start[:, 2]])
    way /= np.linalg.norm(way, axis=1)[:, None]
    outer, outside, step = np.full(len(d), FARTHEST), np.ones(len(d), bool), 0.01
    for length in np.arange(FARTHEST, 0, -step):
        outside &= with_chest(start + length * way) > 0
        outer[outside] = length
    inner = outer - step
    for _ in range(30):
        middle = (inner + outer) / 2
        inside = with_chest(start + middle[:, None] * way) < 0
        inner, outer = np.where(inside, middle, inner), np.where(inside, outer, middle)
    return start + inner[:, None] * way, way


def density(d):
    """Density of vertices on the sphere: uneven on the bust, and larger at the face."""
    polar, radius, height = of_revolution(d)
    scale = np.clip(radius / np.maximum(np.sin(polar), 0.02), 0.1, 4)
    azimuth = np.arctan2(d[:, 0], -d[:, 1])
    face = np.exp(-((azimuth / 0.7) ** 2) - ((height + 0.15) / 0.5) ** 2)
    return scale**2 * (1 + 4 * face + 0.5 * (height > -0.6) + 0.35 * np.sin(9 * d[:, 0]) * np.sin(7 * d[:, 2]))


def bust_mesh(count, seed):
    """A mesh of the bust with a chest: vertices, their outward directions, faces."""
    drawn = np.random.default_rng(seed).normal(size=(20_000, 3))
    mean = density(drawn / np.linalg.norm(drawn, axis=1)[:, None]).mean()
    # With 0.68 of the mean density that `sphere_mesh` expects, the draws fill the dense parts too.
    d, f = surfaces.sphere_mesh(count, seed, lambda d: 0.68 * density(d) / mean)
    v, way = on_bust(d)
    return v, way, delaunay(v, f)


def delaunay(v, f, rounds=12):
    """Flips edges of a closed mesh whose opposite angles sum to more than a half turn, except where the surface is sharply bent."""
    f = f.copy()

    def angle(at, a, b):
        x, y = v[a] - v[at], v[b] - v[at]
        return np.arccos(np.clip(x @ y / np.sqrt((x @ x) * (y @ y)), -1, 1))

    def normal(a, b, c):
        return np.cross(v[b] - v[a], v[c] - v[a])

    for _ in range(rounds):
        across = {(f[i, k], f[i, (k + 1) % 3]): (i, f[i, (k + 2) % 3]) for i in range(len(f)) for k in range(3)}
        flipped = set()
        for (a, b), (i, c) in sorted(across.items()):
            j, d = across[b, a]
            if a > b or flipped & {i, j} or (c, d) in across or angle(c, a, b) + angle(d, a, b) < np.pi + 1e-6:
                continue
            left, right = normal(a, b, c), normal(b, a, d)
            bent = left @ right < 0.5 * np.sqrt((left @ left) * (right @ right))
            if bent or normal(a, d, c) @ (left + right) <= 0 or normal(b, c, d) @ (left + right) <= 0:
                continue
            f[i], f[j] = (a, d, c), (b, c, d)
            flipped |= {i, j}
            across[c, d] = across[d, c] = (i, a)
        if not flipped:
            break
    return f
