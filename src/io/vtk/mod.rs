//! VTK poly data: legacy files and XML files (VTP).
//!
//! Files are written with vtkio. They are read here, because vtkio does not read raw appended data, which is what VTK
//! writes unless told otherwise, and trusts the counts of a file.

mod cells;
mod legacy;
mod payload;
mod scalar;
mod write;
mod xml;

pub(super) use legacy::read as read_legacy;
pub(super) use write::{write_legacy, write_xml};
pub(super) use xml::read as read_xml;

#[cfg(test)]
mod tests;
