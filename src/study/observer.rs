//! Who watches an experiment, and the fields that can be kept of it.

use thiserror::Error;
use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, DataArray, DataSet, ElementType, Extent, ImageDataPiece,
    Version, Vtk,
};

use super::grid::SquareGrid;

/// Why an experiment did not come to its end.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The caller ended it.
    #[error("the experiment was stopped")]
    Stopped,
    /// φ is no longer finite.
    #[error("the flow blew up in step {step}; take a smaller time step")]
    BlewUp {
        /// The step.
        step: usize,
    },
    /// There is no zero line to measure or redistance.
    #[error("there is no zero line after step {step}; take a finer grid or a shorter run")]
    NoZeroLine {
        /// The step.
        step: usize,
    },
    /// A field could not be kept.
    #[error("cannot keep the field of step {step}: {reason}")]
    Frame {
        /// The step.
        step: usize,
        /// Why not.
        reason: String,
    },
}

/// A watcher. All methods may be called from several threads.
pub trait Observer: Sync {
    /// Hears how far the experiment is.
    fn progress(&self, line: &str) {
        let _ = line;
    }

    /// Keeps a field.
    fn frame(&self, frame: &Frame) -> Result<(), StudyError> {
        let _ = frame;
        Ok(())
    }

    /// False ends the experiment.
    fn keep_going(&self) -> bool {
        true
    }
}

/// A watcher that keeps nothing.
pub struct Silent;

impl Observer for Silent {}

/// A field at one time.
pub struct Frame<'a> {
    /// Name of the run it belongs to.
    pub series: &'a str,
    /// Step.
    pub step: usize,
    /// Time, in units of length⁴.
    pub time: f64,
    /// The grid.
    pub grid: &'a SquareGrid,
    /// φ at its nodes.
    pub field: &'a [f64],
}

impl Frame<'_> {
    /// The field as a VTI file with the point array `phi`.
    ///
    /// Origin and spacing of the format's writer are 32-bit floats; they are exact for the grids of the experiments.
    pub fn to_vti(&self) -> Result<Vec<u8>, StudyError> {
        let n = self.grid.cells() as i32;
        let extent = Extent::Ranges([0..=n, 0..=n, 0..=0]);
        let [x, y] = self.grid.origin().map(|v| v as f32);
        let h = self.grid.h() as f32;
        let phi = DataArray {
            name: "phi".to_owned(),
            elem: ElementType::Scalars {
                num_comp: 1,
                lookup_table: None,
            },
            data: IOBuffer::F64(self.grid.strip(self.field)),
        };
        let piece = ImageDataPiece {
            extent: extent.clone(),
            data: Attributes {
                point: vec![Attribute::DataArray(phi)],
                cell: Vec::new(),
            },
        };
        let vtk = Vtk {
            version: Version::new_xml(1, 0),
            byte_order: ByteOrder::LittleEndian,
            title: self.series.to_owned(),
            file_path: None,
            data: DataSet::ImageData {
                extent,
                origin: [x, y, 0.0],
                spacing: [h, h, h],
                meta: None,
                pieces: vec![vtkio::model::Piece::Inline(Box::new(piece))],
            },
        };
        let mut bytes = Vec::new();
        vtk.write_xml(&mut bytes)
            .map_err(|error| StudyError::Frame {
                step: self.step,
                reason: error.to_string(),
            })?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_comes_back_from_its_file() {
        let grid = SquareGrid::centred(4);
        let field = grid.field(|[x, y]| x + 10.0 * y);
        let frame = Frame {
            series: "test",
            step: 3,
            time: 0.5,
            grid: &grid,
            field: &field,
        };
        let bytes = frame.to_vti().expect("a file");
        let back = Vtk::parse_xml(bytes.as_slice()).expect("a readable file");
        let DataSet::ImageData {
            pieces, spacing, ..
        } = back.data
        else {
            panic!("not an image");
        };
        let piece = pieces[0]
            .clone()
            .into_loaded_piece_data(None)
            .expect("a piece");
        let Attribute::DataArray(phi) = &piece.data.point[0] else {
            panic!("no array");
        };
        assert_eq!(phi.name, "phi");
        assert_eq!(phi.data.cast_into::<f64>(), Some(grid.strip(&field)));
        assert_eq!(spacing, [0.25; 3]);
    }
}
