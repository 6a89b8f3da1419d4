//! Texture atlas for patches whose rims cross seams of a texture: one new image, called a page.
//!
//! Texture coordinates cannot be continued across a seam. Such a patch is cut open into a disk, mapped into a circle by mean value
//! coordinates and packed into the page, at the texel density of the images at its rim. The colours of the rim are read from these images
//! in linear light; inside they are interpolated harmonically. The images of the input are not changed.

mod chart;
mod coordinates;
mod disk;
mod image;
mod pack;
mod rim_colours;
mod tile;
mod unfolded;

use std::collections::{BTreeMap, HashMap};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::io::{Loaded, Resolve};
use chart::{Weights, layout};
use coordinates::{first_set, put, uv_rounding};
use image::Linear;
use isomend_core::attributes::{Laplacian, Patches};
use isomend_core::cancel::Cancel;
use isomend_core::mesh::attributes::{LabelKind, Material, NONE, PATCH_NAME};
use isomend_core::mesh::{Attributes, Mesh, Model};
use rim_colours::RimColours;
use tile::{Canvas, LEAST_RADIUS, in_tile, side};
use unfolded::Chart;

pub(crate) use image::is_own;

/// Factor on the texel density for the next attempt if a page cannot hold all charts: their area falls to 0.64.
const COARSER: f64 = 0.8;
/// Lower bound of the page's texel density, as a fraction of the density at the rims; below it there is no page.
const COARSEST: f64 = 0.02;

/// A page of texels, and the patches that use it.
pub(crate) struct TexturePage {
    /// The PNG file.
    pub(crate) png: Vec<u8>,
    /// Texels in width and height.
    pub(crate) size: [u32; 2],
    /// The faces that use it, in ascending order.
    pub(crate) faces: Vec<u32>,
    /// Texel density as a fraction of the density at the rims; below 1 if the page was too small.
    pub(crate) density: f64,
    /// Red, green, blue and opacity that multiply the texels.
    factor: Linear,
    /// Label of the most frequent material along the rims; the page's material is a copy of it.
    rim_material: u32,
}

/// The page, and the patches across seams that are not on it.
#[derive(Default)]
pub(crate) struct Painted {
    /// The page; `None` if no patch got texels.
    pub(crate) page: Option<TexturePage>,
    /// Number of patches without texels, by the reason.
    pub(crate) refused: BTreeMap<String, usize>,
}

/// Makes a page for the patches that have no texture coordinates because their rims cross seams, and adds their coordinates to the model.
/// The model begins with the vertices and faces of `input`, as after [`transfer`](isomend_core::attributes::transfer); `resolve` loads images.
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
    // In the new faces, replace copies of rim vertices by the vertices of the input, so that rims are found by index.
    let of_input = |v: u32| match (v as usize) < input.mesh.positions.len() {
        true => v,
        false => copies.get(&v).copied().unwrap_or(v),
    };
    let faces = model.mesh.faces.iter().enumerate();
    let faces = faces.map(|(f, face)| if f < kept { *face } else { face.map(of_input) });
    let filled = Mesh::new(positions.clone(), faces.collect());
    let patches = Patches::new(&input.mesh, &filled, input.bodies().as_ref());
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
    // Load the images at the rims, and map each patch into a circle.
    let rim_colours = RimColours::new(input, &rims, resolve);
    let made = across.into_par_iter().map(|(patch, faces)| {
        let refusal = patches.rim_faces[patch as usize]
            .iter()
            .find_map(|f| rim_colours.refusal(*f));
        match refusal {
            Some(why) => Err(why),
            None => Chart::new(faces, &patches, &filled, &rim_colours, cancel),
        }
    });
    let mut charts = Vec::new();
    for made in made.collect::<Vec<_>>() {
        match made {
            Ok(chart) => charts.push(chart),
            Err(why) => *painted.refused.entry(why).or_default() += 1,
        }
    }
    let pages = PageBuilder {
        kept: [input.mesh.positions.len(), kept],
        patches: &patches,
        filled: &filled,
        rim_colours: &rim_colours,
        cancel,
    };
    painted.page = pages.page(charts, model, &mut painted.refused);
    painted
}

/// The new faces of each patch that has no texture coordinates although its rim has some. Faces are counted from the first new one.
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

/// The data from which a page is made.
struct PageBuilder<'a> {
    /// Number of vertices and faces of the input.
    kept: [usize; 2],
    patches: &'a Patches,
    filled: &'a Mesh,
    rim_colours: &'a RimColours<'a>,
    cancel: &'a Cancel,
}

/// The layout of a page.
struct Sheet {
    /// Texels in width and height.
    size: [u32; 2],
    /// The upper left corner of each chart's tile.
    corners: Vec<[u32; 2]>,
    /// The radii of the charts in texels.
    radii: Vec<f64>,
    /// As in [`TexturePage::density`].
    density: f64,
}

impl PageBuilder<'_> {
    /// Lays out the charts, paints the page, and adds the charts' texture coordinates to the model.
    fn page(
        &self,
        charts: Vec<Chart>,
        model: &mut Model,
        refused: &mut BTreeMap<String, usize>,
    ) -> Option<TexturePage> {
        let goes_up = self.rim_colours.goes_up();
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
        Some(TexturePage {
            png,
            size: sheet.size,
            faces,
            density: sheet.density,
            factor: self.rim_colours.factor(),
            rim_material: self.rim_material(&charts),
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
                Some(self.rim_colours.colour(face, corners, part))
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
        // Between tiles: the mean of all texels, so that mipmaps are not darkened.
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

    /// The colours of all slots: at a rim the mean over the corners of the input's faces there, inside harmonic.
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
                let colour = self.rim_colours.colour(face, [corner; 2], 0.0);
                let part = 1.0 / rim.len() as f64;
                own.iter_mut().zip(colour).for_each(|(v, c)| *v += part * c);
            }
        }
        Laplacian::new(&points, &faces).solve(&fixed, 4, &mut values);
        values.as_chunks::<4>().0.to_vec()
    }

    /// Label of the most frequent material along the rims; [`NONE`] without a rim.
    fn rim_material(&self, charts: &[Chart]) -> u32 {
        let mut count: BTreeMap<u32, usize> = BTreeMap::new();
        for (face, _) in charts.iter().flat_map(|chart| &chart.across).flatten() {
            *count.entry(self.rim_colours.label(*face)).or_default() += 1;
        }
        let most = count
            .iter()
            .max_by_key(|(label, n)| (**n, u32::MAX - **label));
        most.map_or(NONE, |(label, _)| *label)
    }
}

/// Packs charts into a page and verifies that no triangle flips when its texture coordinates are rounded. A chart with flipped triangles is
/// mapped again with equal weights; if some still flip, it is refused and the others are packed again.
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
        // With the second coordinate upwards, so that unflipped triangles have positive area.
        let upright = |i: usize, p: DVec2| {
            let [u, v] = place(i, p);
            [u, if goes_up { v } else { -v }]
        };
        let laid = charts.into_par_iter().enumerate().map(|(i, mut chart)| {
            if chart.is_folded(|p| upright(i, p)) {
                chart.places = layout(
                    &chart.disk,
                    &chart.points,
                    &chart.border,
                    Weights::Equal,
                    cancel,
                );
            }
            (!chart.is_folded(|p| upright(i, p))).then_some(chart)
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

/// The layout with the largest density at which all charts fit on a page, at most 1; `None` if there is none above [`COARSEST`].
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
    /// The texture coordinates of a point in a chart's unit circle.
    fn uv(&self, chart: usize, place: DVec2, goes_up: bool) -> [f64; 2] {
        let at = in_tile(place, self.radii[chart]);
        let [x, y] =
            [0, 1].map(|k| (at[k] + f64::from(self.corners[chart][k])) / f64::from(self.size[k]));
        [x, if goes_up { 1.0 - y } else { y }]
    }
}

/// The mean of texels, channel by channel, in sRGB.
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

impl TexturePage {
    /// Adds a material of this name with the page as its texture, and assigns it to the page's faces. `image` is the texture's path or data
    /// URI.
    pub(crate) fn assign_material(&self, attributes: &mut Attributes, name: &str, image: String) {
        let Some(labels) = attributes
            .labels
            .iter_mut()
            .find(|l| l.kind == LabelKind::Material)
        else {
            return;
        };
        let rim_material = labels
            .names
            .get(self.rim_material as usize)
            .map(|n| n.trim().to_owned());
        // If no face outside the page has the plain material of patches and it is the last label, the new one replaces it.
        let plain = labels.names.iter().position(|n| n == PATCH_NAME);
        let on_page = |f: usize| self.faces.binary_search(&(f as u32)).is_ok();
        let of_face = || labels.of_face.iter().enumerate();
        let free = plain.filter(|p| of_face().all(|(f, l)| *l != *p as u32 || on_page(f)));
        let is_last = |p: &usize| labels.names.len() == p + 1;
        match free.filter(is_last) {
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
            .find(|m| Some(&m.name) == rim_material.as_ref());
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
