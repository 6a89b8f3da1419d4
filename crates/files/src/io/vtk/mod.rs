//! Reads and writes VTK files: surfaces as legacy and XML poly data (VTP), volumes as XML image data (VTI); reads
//! legacy volumes.
//!
//! Legacy surfaces are written with vtkio. Files are not read with it, because vtkio trusts the counts of a file and does
//! not read raw appended data, which is VTK's default; XML is written without it, because vtkio brings an older quick-xml for it.

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
mod xml_write;

pub(super) use image::read as read_image_xml;
pub(super) use image_legacy::read as read_image_legacy;
pub(super) use image_write::write as write_image;
pub(super) use legacy::read as read_legacy;
pub(super) use write::write_legacy;
pub(super) use xml::read as read_xml;
pub(super) use xml_write::write_xml;

#[cfg(test)]
mod bomb_tests;
#[cfg(test)]
mod data_tests;
#[cfg(test)]
mod image_tests;
#[cfg(test)]
mod tests;
