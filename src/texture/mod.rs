//! Texels for patches that lie across seams of a texture: a page of their own.
//!
//! Over a seam no texture coordinates can be continued. Such a patch is cut open into a disk, laid out in a circle by mean value coordinates
//! and put on a new page, with as many texels for a length as the images round it have. The colours at its rim are read from the images
//! on both sides, in linear light; inside they are harmonic. The images of the input stay as they are.

mod chart;
mod coordinates;
mod disk;
mod image;
mod looks;
mod pack;
mod tile;
mod unfolded;

use std::collections::{BTreeMap, HashMap};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::attributes::{Laplacian, Patches};
use crate::cancel::Cancel;
use crate::io::{Loaded, Resolve};
use crate::mesh::attributes::{LabelKind, Material, NONE, PATCH_NAME};
use crate::mesh::{Attributes, Mesh, Model};
use chart::{Weights, layout};
use coordinates::{first_set, put, uv_rounding};
use image::Linear;
use looks::Looks;
use tile::{Canvas, LEAST_RADIUS, in_tile, side};
use unfolded::Chart;

pub(crate) use image::is_own;

/// Factor on the texels per length for the next try where a page cannot hold all charts: the area of charts falls to 0.64.
const COARSER: f64 = 0.8;
/// The least part of the texels at the rim.
const COARSEST: f64 = 0.02;

/// A page of texels, and the patches that use it.
pub(crate) struct Page {
    /// The PNG file.
    pub(crate) png: Vec<u8>,
    /// Texels in width and height.
    pub(crate) size: [u32; 2],
    /// The faces that use it.
    pub(crate) faces: Vec<u32>,
    /// The part of the texels for a length that the images at the rims have; below 1 where the page was too small.
    pub(crate) density: f64,
    /// Red, green, blue and opacity by which texels are multiplied.
    factor: Linear,
    /// The place of the material that most of the faces at the rims have.
    like: u32,
}

/// What became of the patches across seams.
#[derive(Default)]
pub(crate) struct Painted {
    /// The page, if any patch got texels.
    pub(crate) page: Option<Page>,
    /// Why others got none, and how many did not for each reason.
    pub(crate) refused: BTreeMap<String, usize>,
}

/// Gives the patches of a model that have no texture coordinates, because their rims cross seams, places on a new page. The model begins
/// with the vertices and faces of `input`, as [`transfer`](crate::attributes::transfer) leaves it; `resolve` loads images.
pub(crate) fn paint(
    input: &Loaded,
    model: &mut Model,
    resolve: &Resolve<'_>,
    cancel: &Cancel,
) -> Painted {
    let mut painted = Painted::default();
    let kept = input.mesh.faces.len();
    let positions = &model.mesh.positions;
    let copies: HashMap<u32, u32> = model.attributes.copies.iter().copied().collect();
    let own = |v: u32| match (v as usize) < input.mesh.positions.len() {
        true => v,
        false => copies.get(&v).copied().unwrap_or(v),
    };
    let faces = model.mesh.faces.iter().enumerate();
    let faces = faces.map(|(f, face)| if f < kept { *face } else { face.map(own) });
    let filled = Mesh::new(positions.clone(), faces.collect());
    let patches = Patches::new(&input.mesh, &filled);
    let across = across_seams(input, model, &patches);
    if across.is_empty() {
        return painted;
    }
    let mut rims: Vec<u32> = (across.keys())
        .flat_map(|patch| &patches.rim_faces[*patch as usize])
        .copied()
        .collect();
    rims.sort_unstable();
    rims.dedup();
    let looks = Looks::new(input, &rims, resolve);
    let made = across.into_par_iter().map(|(patch, faces)| {
        let refusal = patches.rim_faces[patch as usize]
            .iter()
            .find_map(|f| looks.refusal(*f));
        match refusal {
            Some(why) => Err(why),
            None => Chart::new(faces, &patches, &filled, &looks, cancel),
        }
    });
    let mut charts = Vec::new();
    for made in made.collect::<Vec<_>>() {
        match made {
            Ok(chart) => charts.push(chart),
            Err(why) => *painted.refused.entry(why).or_default() += 1,
        }
    }
    let work = Work {
        kept: [input.mesh.positions.len(), kept],
        patches: &patches,
        filled: &filled,
        looks: &looks,
        cancel,
    };
    painted.page = work.page(charts, model, &mut painted.refused);
    painted
}

/// The patches without texture coordinates whose rims have some, with their new faces.
fn across_seams(input: &Loaded, model: &Model, patches: &Patches) -> BTreeMap<u32, Vec<usize>> {
    let mut faces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let Some(after) = first_set(&model.attributes) else {
        return faces;
    };
    let Some(before) = first_set(&input.attributes) else {
        return faces;
    };
    let mut at_rim = vec![false; patches.rim_faces.len()];
    for slot in &patches.slots {
        let mut corners = slot.rim.iter();
        at_rim[slot.patch as usize] |=
            corners.any(|&(f, k)| before.at(&input.mesh, f as usize, k.into()).is_some());
    }
    let kept = input.mesh.faces.len();
    for (new, &patch) in patches.of_face.iter().enumerate() {
        let has_own = (0..3).any(|k| after.at(&model.mesh, kept + new, k).is_some());
        at_rim[patch as usize] &= !has_own;
    }
    for (new, &patch) in patches.of_face.iter().enumerate() {
        if at_rim[patch as usize] {
            faces.entry(patch).or_default().push(new);
        }
    }
    faces
}

/// What pages are made of.
struct Work<'a> {
    /// Vertices and faces of the input.
    kept: [usize; 2],
    patches: &'a Patches,
    filled: &'a Mesh,
    looks: &'a Looks<'a>,
    cancel: &'a Cancel,
}

/// Charts on a page.
struct Sheet {
    size: [u32; 2],
    corners: Vec<[u32; 2]>,
    /// The radii of the charts in texels.
    radii: Vec<f64>,
    density: f64,
}

impl Work<'_> {
    /// Lays charts out on a page, paints it, and gives the model its texture coordinates.
    fn page(
        &self,
        charts: Vec<Chart>,
        model: &mut Model,
        refused: &mut BTreeMap<String, usize>,
    ) -> Option<Page> {
        let goes_up = self.looks.goes_up();
        let (charts, sheet) = laid_out(charts, goes_up, &model.attributes, refused, self.cancel)?;
        let texels = self.texels(&charts, &sheet);
        let png = image::png_file(sheet.size, &texels).ok()?;
        let mut faces: Vec<u32> = Vec::new();
        for (i, chart) in charts.iter().enumerate() {
            let uv: Vec<[f64; 2]> = chart
                .places
                .iter()
                .map(|p| sheet.uv(i, *p, goes_up))
                .collect();
            let own = chart.faces.iter().map(|f| (self.kept[1] + f) as u32);
            faces.extend(own);
            put(chart, &uv, self.kept, model);
        }
        faces.sort_unstable();
        Some(Page {
            png,
            size: sheet.size,
            faces,
            density: sheet.density,
            factor: self.looks.factor(),
            like: self.like(&charts),
        })
    }

    /// The texels of a page.
    fn texels(&self, charts: &[Chart], sheet: &Sheet) -> Vec<[u8; 4]> {
        let colours = self.colours(charts);
        let tiles = charts.par_iter().zip(&sheet.radii).map(|(chart, &radius)| {
            let slots = chart.disk.slots.iter();
            let own: Vec<Linear> = slots.map(|s| colours[*s as usize]).collect();
            let rim = |edge: usize, part: f64| {
                let (face, corners) = chart.across[edge]?;
                Some(self.looks.colour(face, corners, part))
            };
            let canvas = Canvas {
                disk: &chart.disk,
                border: &chart.border,
                places: &chart.places,
                radius,
                colours: &own,
                rim: &rim,
            };
            canvas.painted().into_iter().map(image::texel).collect()
        });
        let tiles: Vec<Vec<[u8; 4]>> = tiles.collect();
        // Where there is nothing: the mean of all, so that smaller versions of the page are not darkened.
        let [width, height] = sheet.size.map(|n| n as usize);
        let mut texels = vec![mean(tiles.iter().flatten()); width * height];
        for ((tile, corner), radius) in tiles.iter().zip(&sheet.corners).zip(&sheet.radii) {
            let [x, y] = corner.map(|n| n as usize);
            for (row, line) in tile.chunks_exact(side(*radius) as usize).enumerate() {
                let start = (y + row) * width + x;
                texels[start..start + line.len()].copy_from_slice(line);
            }
        }
        texels
    }

    /// The colours of all slots: at the rims of the charts the mean of the faces' colours there, inside harmonic.
    fn colours(&self, charts: &[Chart]) -> Vec<Linear> {
        let slots = &self.patches.slots;
        let points: Vec<DVec3> = slots
            .iter()
            .map(|s| self.filled.positions[s.vertex as usize])
            .collect();
        let faces: Vec<[u32; 3]> = (charts.iter())
            .flat_map(|chart| chart.faces.iter().map(|f| self.patches.faces[*f]))
            .collect();
        let mut fixed = vec![false; slots.len()];
        let mut values = vec![0.0; 4 * slots.len()];
        for &s in faces.iter().flatten() {
            let rim = &slots[s as usize].rim;
            fixed[s as usize] = !rim.is_empty();
            let own = &mut values[4 * s as usize..][..4];
            own.fill(0.0);
            for &(face, corner) in rim {
                let colour = self.looks.colour(face, [corner; 2], 0.0);
                let part = 1.0 / rim.len() as f64;
                own.iter_mut().zip(colour).for_each(|(v, c)| *v += part * c);
            }
        }
        Laplacian::new(&points, &faces).solve(&fixed, 4, &mut values);
        values.as_chunks::<4>().0.to_vec()
    }

    /// The place of the material that most of the faces at the rims have.
    fn like(&self, charts: &[Chart]) -> u32 {
        let mut count: BTreeMap<u32, usize> = BTreeMap::new();
        for (face, _) in charts.iter().flat_map(|chart| &chart.across).flatten() {
            *count.entry(self.looks.label(*face)).or_default() += 1;
        }
        let most = count
            .iter()
            .max_by_key(|(label, n)| (**n, u32::MAX - **label));
        most.map_or(NONE, |(label, _)| *label)
    }
}

/// Charts laid out on a page, all triangles of which keep their side once texture coordinates are rounded; the others are refused.
fn laid_out(
    mut charts: Vec<Chart>,
    goes_up: bool,
    attributes: &Attributes,
    refused: &mut BTreeMap<String, usize>,
    cancel: &Cancel,
) -> Option<(Vec<Chart>, Sheet)> {
    loop {
        let Some(sheet) = sheet(&charts) else {
            if !charts.is_empty() {
                *refused
                    .entry("a page cannot hold all of them".to_owned())
                    .or_default() += charts.len();
            }
            return None;
        };
        let rounds = uv_rounding(attributes)?;
        let place = |i: usize, p: DVec2| sheet.uv(i, p, goes_up).map(&rounds);
        let turned = |i: usize, p: DVec2| {
            let [u, v] = place(i, p);
            [u, if goes_up { v } else { -v }]
        };
        let laid = charts.into_par_iter().enumerate().map(|(i, mut chart)| {
            if chart.is_folded(|p| turned(i, p)) {
                chart.places = layout(
                    &chart.disk,
                    &chart.points,
                    &chart.border,
                    Weights::Equal,
                    cancel,
                );
            }
            (!chart.is_folded(|p| turned(i, p))).then_some(chart)
        });
        let laid: Vec<Option<Chart>> = laid.collect();
        let count = laid.len();
        charts = laid.into_iter().flatten().collect();
        if charts.len() == count {
            return Some((charts, sheet));
        }
        let why = "triangles of the patch are too small for texture coordinates".to_owned();
        *refused.entry(why).or_default() += count - charts.len();
    }
}

/// The charts with as many texels as a page can hold.
fn sheet(charts: &[Chart]) -> Option<Sheet> {
    let mut density = 1.0;
    while density > COARSEST && !charts.is_empty() {
        let radius = |chart: &Chart| (density * chart.radius).max(LEAST_RADIUS);
        let radii: Vec<f64> = charts.iter().map(radius).collect();
        let fits = radii.iter().all(|r| *r < f64::from(pack::LONGEST));
        let sides = || radii.iter().map(|r| side(*r)).collect::<Vec<_>>();
        if let Some(packed) = fits.then(|| pack::packed(&sides())).flatten() {
            return Some(Sheet {
                size: packed.size,
                corners: packed.corners,
                radii,
                density,
            });
        }
        density *= COARSER;
    }
    None
}

impl Sheet {
    /// The texture coordinates of a place of a chart.
    fn uv(&self, chart: usize, place: DVec2, goes_up: bool) -> [f64; 2] {
        let at = in_tile(place, self.radii[chart]);
        let [x, y] =
            [0, 1].map(|k| (at[k] + f64::from(self.corners[chart][k])) / f64::from(self.size[k]));
        [x, if goes_up { 1.0 - y } else { y }]
    }
}

/// The mean of texels, each number by itself.
fn mean<'a>(texels: impl Iterator<Item = &'a [u8; 4]>) -> [u8; 4] {
    let (mut sum, mut count) = ([0u64; 4], 0);
    for texel in texels {
        sum.iter_mut()
            .zip(texel)
            .for_each(|(s, t)| *s += u64::from(*t));
        count += 1;
    }
    sum.map(|s| (s / u64::max(count, 1)) as u8)
}

impl Page {
    /// Gives its faces a material of this name with the page as its image, under the name that the file has for it.
    pub(crate) fn dress(&self, attributes: &mut Attributes, name: &str, image: String) {
        let Some(labels) = attributes
            .labels
            .iter_mut()
            .find(|l| l.kind == LabelKind::Material)
        else {
            return;
        };
        let like = labels
            .names
            .get(self.like as usize)
            .map(|n| n.trim().to_owned());
        // The plain material of patches goes where none has it any more.
        let plain = labels.names.iter().position(|n| n == PATCH_NAME);
        let on_page = |f: usize| self.faces.binary_search(&(f as u32)).is_ok();
        let of_face = || labels.of_face.iter().enumerate();
        let free = plain.filter(|p| of_face().all(|(f, l)| *l != *p as u32 || on_page(f)));
        let is_new = |p: &usize| labels.names.len() == p + 1;
        match free.filter(is_new) {
            Some(place) => labels.names[place] = name.to_owned(),
            None => _ = labels.place(name),
        }
        let place = labels.place(name);
        for &face in &self.faces {
            labels.of_face[face as usize] = place;
        }
        let found = attributes
            .materials
            .iter()
            .find(|m| Some(&m.name) == like.as_ref());
        let [r, g, b, opacity] = self.factor.map(|x| x as f32);
        let material = Material {
            name: name.to_owned(),
            colour: Some([r, g, b]),
            opacity: (opacity < 1.0).then_some(opacity),
            texture: Some(image),
            ..found.cloned().unwrap_or_default()
        };
        attributes.materials.push(material);
    }
}
