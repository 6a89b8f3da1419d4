//! Report text on invented shape: the counterpart of a patch, and its grain.

use isomend_core::fill::{Closure, CounterpartKind, CounterpartReport, RegionReport};
use isomend_core::mesh::{Unit, number};

/// The counterpart of a region and its fit, or why it was refused; `None` without a counterpart.
pub(crate) fn counterpart_text(r: &RegionReport, unit: Option<Unit>) -> Option<String> {
    let found = r.counterpart.as_ref()?;
    let what = found.kind.map_or("the counterpart".to_owned(), kind_text);
    if let Some(weight) = found.weight {
        let percent = 100.0 * weight;
        return Some(format!(
            "weighed with {what}, {percent:.0} %{}",
            fit(found, unit)
        ));
    }
    Some(match &found.refused {
        Some(why) => format!("not filled with {what}: {why}{}", fit(found, unit)),
        None => format!("filled with {what}{}", fit(found, unit)),
    })
}

/// The text on a region that was closed by a counterpart.
pub(super) fn like(r: &RegionReport, unit: Option<Unit>) -> String {
    counterpart_text(r, unit).unwrap_or_else(|| "closed".to_owned())
}

/// Why the counterpart was refused, for a region that was closed in another way.
pub(super) fn refused(r: &RegionReport, unit: Option<Unit>) -> Option<String> {
    match r.closure {
        Some(Closure::Counterpart) => None,
        _ => counterpart_text(r, unit),
    }
}

/// The grain of a patch, if it was requested.
pub(crate) fn grain_text(r: &RegionReport, unit: Option<Unit>) -> Option<String> {
    let grain = r.grain?;
    let ring = Unit::text(unit, grain.ring);
    Some(match grain.part {
        0.0 => format!(
            "no grain, since more faces would intersect (roughness of the surroundings {ring})"
        ),
        _ => format!(
            "with grain: roughness {}, of the surroundings {ring}; expected errors do not include it",
            Unit::text(unit, grain.patch)
        ),
    })
}

/// A counterpart in words, with the equation of a mirror plane.
fn kind_text(kind: CounterpartKind) -> String {
    match kind {
        CounterpartKind::Mirror([point, n]) => {
            let number = |x: f64| {
                let text = format!("{x:.3}");
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            };
            let [x, y, z] = n.to_array().map(number);
            format!(
                "its mirror image in the plane {x} x + {y} y + {z} z = {}",
                number(n.dot(point))
            )
        }
        CounterpartKind::Template(scale) if (scale - 1.0).abs() < 1e-9 => "the template".to_owned(),
        CounterpartKind::Template(scale) => format!("the template, scaled by {}", number(scale)),
    }
}

/// The misfit of a counterpart beside the hole and its errors on the rings, in parentheses.
fn fit(found: &CounterpartReport, unit: Option<Unit>) -> String {
    let Some(misfit) = found.misfit else {
        return String::new();
    };
    let mut text = format!(" (misfit {} beside the hole", Unit::text(unit, misfit));
    if let (Some(own), Some(smooth)) = (found.ring_error, found.smooth_ring_error) {
        text += &format!(
            "; error on removed rings {}, of a smooth patch {}",
            Unit::text(unit, own),
            Unit::text(unit, smooth)
        );
    }
    text + ")"
}
