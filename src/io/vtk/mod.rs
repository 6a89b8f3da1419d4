//! VTK poly data: legacy files and XML files (VTP); image data: XML files (VTI) and, for reading, legacy files.
//!
//! Files are written with vtkio. They are read here, because vtkio does not read raw appended data, which is what VTK
//! writes unless told otherwise, and trusts the counts of a file.

mod arrays;
mod cells;
mod image;
mod image_legacy;
mod image_write;
mod legacy;
mod legacy_data;
mod markup;
mod payload;
mod scalar;
mod write;
mod write_data;
mod xml;

pub(super) use image::read as read_image_xml;
pub(super) use image_legacy::read as read_image_legacy;
pub(super) use image_write::write as write_image;
pub(super) use legacy::read as read_legacy;
pub(super) use write::{write_legacy, write_xml};
pub(super) use xml::read as read_xml;

#[cfg(test)]
mod bomb_tests;
#[cfg(test)]
mod data_tests;
#[cfg(test)]
mod image_tests;
#[cfg(test)]
mod tests;
