//! Units of length of mesh coordinates.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::length;

/// The unit of length of a mesh's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Unit {
    /// Micrometre.
    #[serde(rename = "um")]
    Micrometre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Centimetre.
    #[serde(rename = "cm")]
    Centimetre,
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Inch: 25.4 mm.
    #[serde(rename = "in")]
    Inch,
    /// Foot: 12 inches.
    #[serde(rename = "ft")]
    Foot,
}

impl Unit {
    /// All units.
    pub const ALL: [Self; 6] = [
        Self::Micrometre,
        Self::Millimetre,
        Self::Centimetre,
        Self::Metre,
        Self::Inch,
        Self::Foot,
    ];

    /// The unit's symbol, for example `mm`.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Micrometre => "um",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }

    /// Its length in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }

    /// Formats a length with this unit as [`length`] does; without a symbol if the unit is unknown.
    pub fn text(unit: Option<Self>, x: f64) -> String {
        match unit {
            Some(unit) => format!("{} {unit}", length(x)),
            None => length(x),
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sign())
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|unit| unit.sign() == text);
        found.ok_or_else(|| {
            let signs = Self::ALL.map(Self::sign).join(", ");
            format!("unknown unit '{text}'; the units are {signs}")
        })
    }
}
