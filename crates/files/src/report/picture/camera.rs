//! Chooses cameras from which the patches of a scene are seen well.

use glam::Vec3;

use super::super::scene::{Scene, Side};
use super::raster::{Camera, NONE, draw};

/// Height and width of the drawings by which directions are compared, in samples.
const TRIAL: usize = 96;
/// Largest penalty, as a fraction of the score, for views of the whole from below or from straight above.
const UPRIGHT: f32 = 0.35;
/// The same for close-ups.
const UPRIGHT_CLOSE: f32 = 0.12;
/// Size of a picture over the size of the scene in it.
const MARGIN: f32 = 1.06;
/// Size of a close-up over the size of its patch.
const CLOSE: f32 = 1.3;

/// A camera for the whole scene, and one for its largest patch if there is one.
pub struct Views {
    /// For the whole scene.
    pub whole: Camera,
    /// For the largest patch.
    pub close: Option<Camera>,
}

/// The faces that a camera points at, such as the new faces of a region.
struct Subject {
    /// Centre of their bounding box.
    centre: Vec3,
    /// Half the diagonal of their bounding box.
    reach: f32,
    /// Sum of their unit normals, each times twice the face's area.
    facing: Vec3,
}

/// The cameras from which all patches, and the largest patch, are seen best. Without patches the camera looks at the first rim.
pub fn views(scene: &Scene) -> Views {
    let up = scene.up;
    let everything = Camera::new(Vec3::X, up, Vec3::ZERO, scene.radius as f32);
    let largest = largest_region(scene);
    let subject = largest.and_then(|region| subject(scene, |f| scene.region(f) == Some(region)));
    let Some(patch) = subject else {
        let towards = rim_or_corner(scene, up);
        return Views {
            whole: fitted(
                scene.positions.iter().copied(),
                everything.towards(towards, up),
                MARGIN,
            ),
            close: None,
        };
    };
    let directions = directions(scene, up, &patch);
    let whole = best(scene, &directions, (up, UPRIGHT), None, everything);
    let near = Camera {
        centre: patch.centre,
        reach: CLOSE * patch.reach,
        ..everything
    };
    let close = best(scene, &directions, (up, UPRIGHT_CLOSE), largest, near);
    let whole = whole.or(close).unwrap_or(everything);
    let all = scene.positions.iter().copied();
    let own = (0..scene.faces.len() as u32)
        .filter(|&f| scene.region(f) == largest)
        .flat_map(|f| scene.faces[f as usize].map(|v| scene.positions[v as usize]));
    Views {
        whole: fitted(all, whole, MARGIN),
        close: close
            .filter(|_| scene.marks_new())
            .map(|camera| fitted(own, camera, CLOSE)),
    }
}

/// The region whose patch has the largest area.
fn largest_region(scene: &Scene) -> Option<u32> {
    let regions = *scene.regions.iter().max()?;
    let mut areas = vec![0.0f64; regions as usize + 1];
    for (face, &region) in scene.faces[scene.kept..].iter().zip(&scene.regions) {
        areas[region as usize] += f64::from(twice_area(scene, face).length());
    }
    let order = |i: &usize, j: &usize| areas[*i].total_cmp(&areas[*j]).then(j.cmp(i));
    (0..areas.len()).max_by(order).map(|r| r as u32)
}

/// The normal of a face, times twice its area.
fn twice_area(scene: &Scene, face: &[u32; 3]) -> Vec3 {
    let [a, b, c] = face.map(|v| scene.positions[v as usize]);
    (b - a).cross(c - a)
}

/// The faces for which `belongs` is true; `None` if there are none.
fn subject(scene: &Scene, belongs: impl Fn(u32) -> bool) -> Option<Subject> {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
    let (low, high, facing) = (0..scene.faces.len() as u32)
        .filter(|&f| belongs(f))
        .map(|f| &scene.faces[f as usize])
        .fold(start, |(low, high, facing), face| {
            let corners = face.map(|v| scene.positions[v as usize]);
            (
                corners.iter().fold(low, |l, p| l.min(*p)),
                corners.iter().fold(high, |h, p| h.max(*p)),
                facing + twice_area(scene, face),
            )
        });
    low.is_finite().then(|| Subject {
        centre: 0.5 * (low + high),
        reach: 0.5 * low.distance(high),
        facing,
    })
}

/// A direction for scenes without patches: the direction that the first rim faces, else from the scene's centre to it, else obliquely from
/// above.
fn rim_or_corner(scene: &Scene, up: Vec3) -> Vec3 {
    let rim = scene.rims.first().filter(|rim| !rim.is_empty());
    if let Some(facing) = rim.and_then(|rim| rim_facing(rim)) {
        return facing;
    }
    let centre = rim.map(|rim| rim.iter().copied().sum::<Vec3>() / rim.len() as f32);
    let side = if up == Vec3::Y { Vec3::Z } else { -Vec3::Y };
    let towards = centre.and_then(Vec3::try_normalize);
    towards.unwrap_or(Vec3::new(0.5, 0.0, 0.0) + side + 0.4 * up)
}

/// The direction that a rim faces, if the area that it encloses is large enough for its length.
fn rim_facing(rim: &[Vec3]) -> Option<Vec3> {
    let (mut area, mut length) = (Vec3::ZERO, 0.0);
    for (i, &p) in rim.iter().enumerate() {
        let next = rim[(i + 1) % rim.len()];
        area += (p - rim[0]).cross(next - rim[0]);
        length += p.distance(next);
    }
    (area.length() > 1e-2 * length * length).then(|| area.normalize_or_zero())
}

/// Candidate directions: the normal of the patch, the direction from the scene's centre to the patch, and directions all around at
/// several heights.
fn directions(scene: &Scene, up: Vec3, patch: &Subject) -> Vec<Vec3> {
    let out = patch.centre.normalize_or_zero();
    let facing = patch.facing.normalize_or_zero();
    let lifted = (facing + 0.35 * up).normalize_or_zero();
    let mut all = vec![facing, lifted, out, (facing + out).normalize_or_zero()];
    let side = up.any_orthonormal_vector();
    let across = up.cross(side);
    for (height, count) in [(0.0f32, 12u8), (0.45, 12), (0.8, 6), (-0.45, 12), (-0.8, 6)] {
        for i in 0..count {
            let (s, c) = (f32::from(i) / f32::from(count) * std::f32::consts::TAU).sin_cos();
            all.push(height * up + (1.0 - height * height).sqrt() * (c * side + s * across));
        }
    }
    all.retain(|d| d.is_finite() && d.length_squared() > 0.5 && !scene.faces.is_empty());
    all
}

/// The camera turned to the direction from which most samples of the region `wanted` are seen, or of all new faces. `upright` is the
/// penalty for views from below and from straight above.
fn best(
    scene: &Scene,
    directions: &[Vec3],
    (up, upright): (Vec3, f32),
    wanted: Option<u32>,
    camera: Camera,
) -> Option<Camera> {
    let mut found: Option<(f32, Camera)> = None;
    for &towards in directions {
        let camera = camera.towards(towards, up);
        let seen = draw(scene, Side::After, &camera, [TRIAL, TRIAL]);
        let counts = |&i: &u32| {
            let Some(face) = seen.faces.get(i as usize).filter(|_| i != NONE) else {
                return false;
            };
            let region = scene.region(face.face);
            !face.is_back() && region.is_some() && (wanted.is_none() || region == wanted)
        };
        let count = seen.nearest.iter().filter(|i| counts(i)).count() as f32;
        let tilt = up.dot(towards);
        let score = count * (1.0 - upright * if tilt < 0.0 { -tilt } else { tilt.powi(4) });
        if score > found.as_ref().map_or(0.0, |(top, _)| *top) {
            found = Some((score, camera));
        }
    }
    found.map(|(_, camera)| camera)
}

/// The camera moved and scaled so that the points fit into a square picture with a margin.
fn fitted(points: impl Iterator<Item = Vec3>, camera: Camera, margin: f32) -> Camera {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = points.fold(start, |(l, h), p| {
        let q = Vec3::new(p.dot(camera.right), p.dot(camera.up), p.dot(camera.towards));
        (l.min(q), h.max(q))
    });
    if !low.is_finite() {
        return camera;
    }
    let middle = 0.5 * (low + high);
    let size = 0.5 * (high - low);
    Camera {
        centre: camera.right * middle.x + camera.up * middle.y + camera.towards * middle.z,
        reach: (margin * size.x.max(size.y)).max(f32::MIN_POSITIVE),
        ..camera
    }
}
