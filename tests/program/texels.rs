//! Texels for patches across seams of a texture, on a cube with six charts in one image and holes over its edges and corners.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;

use glam::{DVec2, DVec3};
use isomend::io::{
    Contents, FileDocument, Format, Image, Loaded, WriteOptions, model_to_bytes, read_path,
};
use isomend::{LabelKind, PATCH_NAME, Role};

use crate::desk::{Desk, assert_code, text};

/// Width of a chart in texels, and the margin on each side that shows the texture beyond the cube's edges.
const SIDE: u32 = 128;
const MARGIN: f64 = 5.0;
/// Number of squares along an edge of the cube.
const SQUARES: u32 = 16;

/// The texture as a function in space, in linear light.
fn light(p: DVec3) -> [f64; 3] {
    [
        0.5 + 0.3 * (1.1 * p.x + 0.3).sin() * (0.9 * p.y).cos(),
        0.5 + 0.3 * (1.3 * p.y + 0.8 * p.z).sin(),
        0.45 + 0.25 * (1.2 * p.z - 0.7 * p.x).cos(),
    ]
}

fn byte(light: f64) -> u8 {
    (255.0 * srgb(light)).round() as u8
}

fn srgb(light: f64) -> f64 {
    match light <= 0.003_130_8 {
        true => 12.92 * light,
        false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}

fn linear(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    match value <= 0.04045 {
        true => value / 12.92,
        false => ((value + 0.055) / 1.055).powf(2.4),
    }
}

/// A point on a side of the cube [-1, 1]³; (a, b) is right-handed seen from outside.
fn on_side(side: usize, a: f64, b: f64) -> DVec3 {
    let sign = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut p = [0.0; 3];
    p[side / 2] = sign;
    p[(side / 2 + 1) % 3] = sign * a;
    p[(side / 2 + 2) % 3] = b;
    DVec3::from_array(p)
}

/// The position of a point of a side in the image, in texels from the upper left corner. Every other chart is rotated.
fn in_image(side: usize, a: f64, b: f64) -> DVec2 {
    let (a, b) = if side.is_multiple_of(2) {
        (a, b)
    } else {
        (-b, a)
    };
    let corner = DVec2::new((side % 3) as f64, (side / 3) as f64) * f64::from(SIDE);
    corner + MARGIN + (DVec2::new(a, b) + 1.0) * 0.5 * (f64::from(SIDE) - 2.0 * MARGIN)
}

/// The image of all charts, as a PNG file.
fn atlas() -> Vec<u8> {
    let (width, height) = (3 * SIDE, 2 * SIDE);
    let inside = f64::from(SIDE) - 2.0 * MARGIN;
    let mut data = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let side = (y / SIDE * 3 + x / SIDE) as usize;
            let at = |n: u32| (f64::from(n % SIDE) + 0.5 - MARGIN) / inside * 2.0 - 1.0;
            let (a, b) = match side % 2 {
                0 => (at(x), at(y)),
                _ => (at(y), -at(x)),
            };
            data.extend(light(on_side(side, a, b)).map(byte));
        }
    }
    png(width, height, &data)
}

fn png(width: u32, height: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Saves `cube.obj` with its material and image, with holes at two corners, on an edge and inside a side.
fn save_cube(desk: &Desk) {
    let holes = [
        (DVec3::ONE, 0.5),
        (DVec3::new(-1.0, -1.0, 1.0), 0.45),
        (DVec3::new(1.0, -1.0, 0.0), 0.4),
        (DVec3::NEG_X, 0.35),
    ];
    let mut vertices: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let (mut points, mut uvs, mut faces) = (String::new(), String::new(), String::new());
    let size = DVec2::new(f64::from(3 * SIDE), f64::from(2 * SIDE));
    for side in 0..6 {
        let first = side * (SQUARES as usize + 1).pow(2);
        let mut grid = Vec::new();
        for j in 0..=SQUARES {
            for i in 0..=SQUARES {
                let [a, b] = [i, j].map(|n| 2.0 * f64::from(n) / f64::from(SQUARES) - 1.0);
                let p = on_side(side, a, b);
                let key = (p * 1e6).round().to_array().map(|x| x as i64);
                let count = vertices.len() + 1;
                grid.push((*vertices.entry(key).or_insert(count), p));
                if vertices.len() == count {
                    let _ = writeln!(points, "v {} {} {}", p.x, p.y, p.z);
                }
                let uv = in_image(side, a, b) / size;
                let _ = writeln!(uvs, "vt {} {}", uv.x, 1.0 - uv.y);
            }
        }
        let at = |i: u32, j: u32| (j * (SQUARES + 1) + i) as usize;
        for (i, j) in (0..SQUARES * SQUARES).map(|n| (n % SQUARES, n / SQUARES)) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for face in [[a, b, c], [a, c, d]] {
                let centre: DVec3 = face.iter().map(|v| grid[*v].1).sum::<DVec3>() / 3.0;
                if holes.iter().all(|(p, r)| centre.distance(*p) > *r) {
                    let corners = face.map(|v| format!("{}/{}", grid[v].0, first + v + 1));
                    let _ = writeln!(faces, "f {}", corners.join(" "));
                }
            }
        }
    }
    desk.text(
        "cube.obj",
        &format!("mtllib cube.mtl\n{points}{uvs}usemtl skin\n{faces}"),
    );
    desk.text("cube.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd atlas.png\n");
    fs::write(desk.path("atlas.png"), atlas()).unwrap();
}

/// An RGB image.
struct Texels {
    width: usize,
    /// Texels, row by row from the top.
    rows: Vec<[u8; 3]>,
}

impl Texels {
    fn read(bytes: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Self {
            width: info.width as usize,
            rows: data.as_chunks::<3>().0.to_vec(),
        }
    }

    /// The colour at texture coordinates, the second counted from the top: bilinear in linear light, returned as sRGB from 0 to 255.
    fn at(&self, uv: DVec2) -> DVec3 {
        let height = self.rows.len() / self.width;
        let at = uv * DVec2::new(self.width as f64, height as f64) - 0.5;
        let (low, part) = (at.floor(), at - at.floor());
        let mut sum = DVec3::ZERO;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let weight = (1.0 - (x - part.x).abs()) * (1.0 - (y - part.y).abs());
            let [i, j] = [low.x + x, low.y + y].map(|n| n.max(0.0) as usize);
            let texel = self.rows[j.min(height - 1) * self.width + i.min(self.width - 1)];
            sum += weight * DVec3::from_array(texel.map(linear));
        }
        DVec3::from_array(sum.to_array().map(|l| 255.0 * srgb(l)))
    }
}

/// A filled mesh with its images, as a viewer shows it.
struct Seen {
    loaded: Loaded,
    images: Vec<Texels>,
    /// The image of each face; `usize::MAX` without one.
    of_face: Vec<usize>,
}

impl Seen {
    fn new(desk: &Desk, name: &str) -> Self {
        let loaded = read_path(&desk.path(name), None).unwrap();
        let file = |name: &String| fs::read(desk.path(name)).unwrap();
        let mut images = Vec::new();
        let mut of_face = vec![usize::MAX; loaded.mesh.faces.len()];
        let document = loaded.document.as_ref();
        if let Some(of_faces) = document.and_then(FileDocument::images_of_faces) {
            for image in (0..).map_while(|i| document?.image(i)) {
                images.push(Texels::read(&match image {
                    Image::Bytes(bytes) => bytes,
                    Image::File(name) => file(&name),
                }));
            }
            for (faces, image) in of_faces {
                of_face[faces].fill(image.unwrap_or(usize::MAX));
            }
        } else {
            let labels = loaded.attributes.labels_of(LabelKind::Material).unwrap();
            let materials = &loaded.attributes.materials;
            for name in &labels.names {
                let found = materials.iter().find(|m| m.name == *name).unwrap();
                images.push(Texels::read(&file(found.texture.as_ref().unwrap())));
            }
            let labels = labels.of_face.iter().map(|l| *l as usize);
            of_face = labels.collect();
        }
        Self {
            loaded,
            images,
            of_face,
        }
    }

    /// Texture coordinates, the second counted from the top.
    fn uv(&self, face: usize, corner: usize) -> Option<DVec2> {
        let all = &self.loaded.attributes;
        let pool = all.corner.iter().find(|c| c.pool.role == Role::Uv(0));
        let value = match pool {
            Some(pool) => pool.get(face, corner)?,
            None => all
                .vertex_role(Role::Uv(0))?
                .get(self.loaded.mesh.faces[face][corner] as usize)?,
        };
        let is_gltf = self.loaded.document.is_some();
        Some(DVec2::new(
            value[0],
            if is_gltf { value[1] } else { 1.0 - value[1] },
        ))
    }

    fn colour(&self, face: usize, parts: [f64; 3]) -> DVec3 {
        let uv = (0..3).map(|k| parts[k] * self.uv(face, k).unwrap()).sum();
        self.images[self.of_face[face]].at(uv)
    }

    fn is_patch(&self, face: usize) -> bool {
        let groups = self.loaded.attributes.labels_of(LabelKind::Group);
        let grouped = groups.and_then(|g| g.get(face)) == Some(PATCH_NAME);
        grouped || self.loaded.attributes.is_patch(face)
    }

    fn root_mean_square(differences: &[DVec3]) -> f64 {
        let sum: f64 = differences.iter().map(|d| d.length_squared()).sum();
        (sum / (3 * differences.len()) as f64).sqrt()
    }

    /// Root mean square difference of colours across the rims of patches with another image, in sRGB from 0 to 255.
    fn rim_step(&self) -> f64 {
        let mesh = &self.loaded.mesh;
        let key = |v: u32| mesh.positions[v as usize].to_array().map(f64::to_bits);
        let mut own = BTreeMap::new();
        let edges = |f: usize| (0..3).map(move |k| (f, k, (k + 1) % 3));
        for (f, a, b) in (0..mesh.faces.len())
            .filter(|f| !self.is_patch(*f))
            .flat_map(edges)
        {
            own.insert([a, b].map(|k| key(mesh.faces[f][k])), (f, [a, b]));
        }
        let mut steps = Vec::new();
        for (f, a, b) in (0..mesh.faces.len())
            .filter(|f| self.is_patch(*f))
            .flat_map(edges)
        {
            let Some(&(other, [d, c])) = own.get(&[b, a].map(|k| key(mesh.faces[f][k]))) else {
                continue;
            };
            if self.of_face[other] == self.of_face[f] {
                continue;
            }
            for part in [0.0, 0.2, 0.5, 0.7, 1.0] {
                let parts = |a: usize, b: usize| {
                    let mut parts = [0.0; 3];
                    parts[a] = 1.0 - part;
                    parts[b] = part;
                    parts
                };
                steps.push(self.colour(f, parts(a, b)) - self.colour(other, parts(c, d)));
            }
        }
        assert!(steps.len() > 200, "{}", steps.len());
        Self::root_mean_square(&steps)
    }

    /// Root mean square error of the colours inside patches on the page against the texture in space, in sRGB from 0 to 255.
    fn inside(&self) -> f64 {
        let own = |f: &usize| self.is_patch(*f) && self.of_face[*f] != self.of_face[0];
        let difference = |f: usize| {
            let centre = self
                .loaded
                .mesh
                .corners(f as u32)
                .into_iter()
                .sum::<DVec3>()
                / 3.0;
            let wanted = light(centre).map(|l| 255.0 * srgb(l));
            self.colour(f, [1.0 / 3.0; 3]) - DVec3::from_array(wanted)
        };
        let faces = 0..self.loaded.mesh.faces.len();
        Self::root_mean_square(&faces.filter(own).map(difference).collect::<Vec<_>>())
    }

    fn check(&self) {
        let patches = (0..self.loaded.mesh.faces.len()).filter(|f| self.is_patch(*f));
        let mut pages = 0;
        for f in patches {
            let [a, b, c] = [0, 1, 2].map(|k| self.uv(f, k).unwrap());
            if self.of_face[f] != self.of_face[0] {
                // With the second coordinate counted from the top, faces are clockwise.
                assert!((b - a).perp_dot(c - a) < 0.0, "face {f}");
                pages += 1;
            }
        }
        assert!(pages > 150, "{pages}");
        let (step, inside) = (self.rim_step(), self.inside());
        assert!(step < 2.0, "the step at rims is {step} of 255");
        assert!(inside < 6.0, "colours inside err by {inside} of 255");
    }
}

#[test]
fn patches_across_seams_get_texels_of_their_own() {
    let desk = Desk::new();
    save_cube(&desk);
    let loaded = read_path(&desk.path("cube.obj"), None).unwrap();
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: None,
    };
    let glb = model_to_bytes(&model, Format::Glb, &WriteOptions::default()).unwrap();
    fs::write(desk.path("cube.glb"), glb.bytes).unwrap();
    for (input, output, files) in [
        (
            "cube.obj",
            "out.obj",
            &["out_isomend.mtl", "out_isomend.png"][..],
        ),
        ("cube.glb", "whole.glb", &[]),
        ("cube.obj", "from_obj.glb", &[]),
        ("cube.glb", "text.gltf", &["text_isomend.png"]),
    ] {
        let before = desk.files();
        let done = desk.run(&["fill", input, "-o", output]);
        assert_code(&done, 0);
        let said = text(&done.stderr);
        assert!(
            said.contains("texels of their own") && said.contains("of holes"),
            "{said}"
        );
        assert!(!said.contains("without texture coordinates"), "{said}");
        let mut after: Vec<String> = [&[output], files]
            .concat()
            .iter()
            .map(ToString::to_string)
            .collect();
        after.extend(before);
        after.sort();
        assert_eq!(desk.files(), after);
        assert_eq!(fs::read(desk.path("atlas.png")).unwrap(), atlas());
        Seen::new(&desk, output).check();
    }
    let obj = fs::read_to_string(desk.path("out.obj")).unwrap();
    assert!(obj.contains("usemtl out_isomend") && obj.contains("mtllib out_isomend.mtl"));
    // One thread writes the same bytes.
    let page = fs::read(desk.path("out_isomend.png")).unwrap();
    assert_code(
        &desk.run(&["fill", "cube.obj", "-o", "out.obj", "--threads", "1"]),
        0,
    );
    assert_eq!(fs::read(desk.path("out_isomend.png")).unwrap(), page);
}

#[test]
fn pages_take_the_place_of_no_other_file_and_can_be_left_out() {
    let desk = Desk::new();
    save_cube(&desk);
    assert_code(
        &desk.run(&["fill", "cube.obj", "-o", "plain.obj", "--no-texture"]),
        0,
    );
    assert!(!desk.files().iter().any(|name| name.contains("_isomend")));
    let obj = fs::read_to_string(desk.path("plain.obj")).unwrap();
    assert!(obj.contains("usemtl isomend_patch"));
    // A link of that name leads elsewhere.
    #[cfg(unix)]
    std::os::unix::fs::symlink("elsewhere.png", desk.path("linked_isomend.png")).unwrap();
    assert_code(
        &desk.run(&["fill", "cube.obj", "-o", "linked.obj", "--holes", "1"]),
        0,
    );
    assert!(!desk.path("elsewhere.png").exists());
    // A file of that name that isomend did not write.
    desk.text("out_isomend.png", "my own");
    let done = desk.run(&["fill", "cube.obj", "-o", "out.obj", "--holes", "1"]);
    assert_code(&done, 0);
    assert_eq!(fs::read(desk.path("out_isomend.png")).unwrap(), b"my own");
    assert!(desk.path("out_isomend_2.png").exists());
    let first = fs::read(desk.path("out_isomend_2.png")).unwrap();
    // The output is filled again, in place: the first page is still used.
    let done = desk.run(&["fill", "out.obj", "-o", "out.obj"]);
    assert_code(&done, 0);
    assert_eq!(fs::read(desk.path("out_isomend_2.png")).unwrap(), first);
    assert!(
        desk.path("out_isomend_3.png").exists(),
        "{:?}",
        desk.files()
    );
    Seen::new(&desk, "out.obj").check();
}

#[test]
fn images_that_cannot_be_read_are_named() {
    let desk = Desk::new();
    save_cube(&desk);
    let whole = atlas();
    for (bytes, why) in [
        (&whole[..200], "damaged PNG"),
        (&b"\x89PNG\r\n\x1a\nnothing"[..], "damaged PNG"),
    ] {
        fs::write(desk.path("atlas.png"), bytes).unwrap();
        let done = desk.run(&["fill", "cube.obj", "-o", "out.obj"]);
        assert_code(&done, 0);
        let said = text(&done.stderr);
        assert!(
            said.contains("without texture coordinates") && said.contains(why),
            "{said}"
        );
    }
}
