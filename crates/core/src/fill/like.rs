//! The option `like`: fills holes with the shape of a counterpart, the mirrored mesh or a template.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::mesh::Mesh;

/// The text form of a mirror image in a plane of symmetry.
const MIRROR: &str = "mirror";
/// A normal whose squared length differs from 1 by at most this is kept bit for bit, so that a plane that was written is read as the same
/// plane. Normalising leaves an error of up to about 2 EPSILON, measured on 40 normals.
const UNIT_TOLERANCE: f64 = 8.0 * f64::EPSILON;

/// A counterpart: the surface from which missing parts are taken. Text form: `mirror`, `mirror:x,y,z,nx,ny,nz`, or the name of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub enum Like {
    /// The mesh itself, mirrored in the plane through a point with a normal. Without a plane, the planes of symmetry are searched.
    Mirror(Option<[DVec3; 2]>),
    /// Another mesh of the same kind of object.
    Template {
        /// Its file, or its name in messages.
        file: PathBuf,
        /// The mesh; `None` until a job reads it from the file. Not serialised.
        mesh: Option<Arc<Mesh>>,
    },
}

impl Like {
    /// A template from a mesh in memory, with a name for messages.
    pub fn template(name: impl Into<PathBuf>, mesh: impl Into<Arc<Mesh>>) -> Self {
        Self::Template {
            file: name.into(),
            mesh: Some(mesh.into()),
        }
    }

    /// The file of a template that has not been read.
    pub fn unread(&self) -> Option<&PathBuf> {
        match self {
            Self::Template { file, mesh: None } => Some(file),
            _ => None,
        }
    }
}

impl FromStr for Like {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some(rest) = text.strip_prefix(MIRROR) else {
            return match text.is_empty() {
                true => Err("the name of a file is needed, or `mirror`".to_owned()),
                false => Ok(Self::Template {
                    file: text.into(),
                    mesh: None,
                }),
            };
        };
        let Some(numbers) = rest.strip_prefix(':') else {
            return match rest.is_empty() {
                true => Ok(Self::Mirror(None)),
                false => Ok(Self::Template {
                    file: text.into(),
                    mesh: None,
                }),
            };
        };
        let numbers = numbers
            .split(',')
            .map(|part| part.trim().parse::<f64>().ok());
        let numbers: Option<Vec<f64>> = numbers.collect();
        let plane = numbers
            .filter(|n| n.len() == 6 && n.iter().all(|x| x.is_finite()))
            .map(|n| [DVec3::from_slice(&n), DVec3::from_slice(&n[3..])]);
        match plane {
            Some([point, normal]) => {
                let normal = unit_normal(normal);
                let normal = normal.ok_or("the normal of a mirror plane must not be zero")?;
                Ok(Self::Mirror(Some([point, normal])))
            }
            None => Err(
                "a mirror plane is a point and a normal, six numbers with commas between them, such as mirror:0,0,0,1,0,0"
                    .to_owned(),
            ),
        }
    }
}

impl Like {
    /// Whether a given plane has finite numbers and a normal that is not zero.
    pub(crate) fn is_valid(&self) -> bool {
        match self {
            Self::Mirror(Some([point, normal])) => {
                point.is_finite() && normal.try_normalize().is_some()
            }
            _ => true,
        }
    }
}

/// The unit vector in the direction of a normal, which is kept bit for bit if it is one; `None` for zero.
pub(crate) fn unit_normal(normal: DVec3) -> Option<DVec3> {
    match (normal.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        true => Some(normal),
        false => normal.try_normalize(),
    }
}

impl TryFrom<String> for Like {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for Like {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mirror(None) => f.write_str(MIRROR),
            Self::Mirror(Some([p, n])) => {
                write!(
                    f,
                    "{MIRROR}:{},{},{},{},{},{}",
                    p.x, p.y, p.z, n.x, n.y, n.z
                )
            }
            Self::Template { file, .. } => write!(f, "{}", file.display()),
        }
    }
}

impl From<Like> for String {
    fn from(like: Like) -> Self {
        like.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_as_the_same() {
        let planes = [
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            [0.1, -2.5, 1e-7, 0.6, 0.0, -0.8],
        ];
        let mirrors = planes.map(|n| {
            let text = n.map(|x: f64| x.to_string()).join(",");
            format!("mirror:{text}").parse::<Like>().unwrap()
        });
        let others = ["mirror", "cast.ply", "mirrored.obj", "./mirror"];
        let others = others.map(|text| text.parse::<Like>().unwrap());
        for like in mirrors.into_iter().chain(others) {
            assert_eq!(like.to_string().parse::<Like>().unwrap(), like);
        }
        assert_eq!("mirror".parse(), Ok(Like::Mirror(None)));
        assert!(matches!(
            "mirrored.obj".parse(),
            Ok(Like::Template { mesh: None, .. })
        ));
    }

    #[test]
    fn planes_that_are_none_are_refused() {
        for text in [
            "",
            "mirror:",
            "mirror:1,2,3",
            "mirror:0,0,0,0,0,0",
            "mirror:0,0,0,a,0,0",
            "mirror:0,0,0,inf,0,0",
        ] {
            assert!(text.parse::<Like>().is_err(), "{text}");
        }
    }
}
