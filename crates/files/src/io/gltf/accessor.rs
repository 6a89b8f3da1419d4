//! Decodes glTF accessors: positions, indices and attributes, with strides, normalisation and sparse parts.

use gltf_json::accessor::sparse::Sparse;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Value};
use serde::Deserialize;

use super::super::binary::BinaryNumber;
use super::super::{IoError, Location};
use super::buffers::Buffers;
use isomend_core::mesh::attributes::Scalar;

/// Reads the positions of an accessor.
pub(super) fn positions(buffers: &mut Buffers<'_>, index: usize) -> Result<Vec<[f64; 3]>, IoError> {
    let accessor = get(buffers, index)?;
    let component = layout(buffers, accessor, index, Type::Vec3, "positions")?;
    let scale = match (component, accessor.normalized) {
        (_, false) | (ComponentType::F32 | ComponentType::U32, true) => None,
        (ComponentType::I8, true) => Some(127.0),
        (ComponentType::U8, true) => Some(255.0),
        (ComponentType::I16, true) => Some(32767.0),
        (ComponentType::U16, true) => Some(65535.0),
    };
    let decode = |bytes: &[u8]| {
        let mut point = [0.0; 3];
        for (value, part) in point.iter_mut().zip(bytes.chunks_exact(component.size())) {
            *value = number(scalar(component), part);
            if let Some(scale) = scale {
                // A normalised number stands for a 32-bit float; a patch that shares it is written as one.
                *value = f64::from((*value / scale).max(-1.0) as f32);
            }
        }
        point
    };
    read(
        buffers,
        accessor,
        index,
        3 * component.size(),
        [0.0; 3],
        decode,
    )
}

/// Reads the vertex indices of an accessor.
pub(super) fn indices(buffers: &mut Buffers<'_>, index: usize) -> Result<Vec<u32>, IoError> {
    let accessor = get(buffers, index)?;
    let component = layout(buffers, accessor, index, Type::Scalar, "indices")?;
    if !matches!(
        component,
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32
    ) {
        return Err(fault(
            buffers,
            index,
            "its component type cannot hold indices".to_string(),
        ));
    }
    read(buffers, accessor, index, component.size(), 0, |bytes| {
        number(scalar(component), bytes) as u32
    })
}

/// The values of an attribute.
pub(super) struct Raw {
    pub(super) scalar: Scalar,
    pub(super) normalized: bool,
    pub(super) components: usize,
    pub(super) values: Vec<f64>,
}

/// Reads an attribute of scalars or vectors.
pub(super) fn attribute(buffers: &mut Buffers<'_>, index: usize) -> Result<Raw, IoError> {
    let accessor = get(buffers, index)?;
    let Checked::Valid(type_) = accessor.type_ else {
        return Err(fault(buffers, index, "its type is not known".to_string()));
    };
    let components = match type_ {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 => 4,
        _ => {
            let what = format!("its type {type_:?} is not one of vertices");
            return Err(fault(buffers, index, what));
        }
    };
    let component = layout(buffers, accessor, index, type_, "values of vertices")?;
    let size = component.size();
    let decode = |bytes: &[u8]| {
        let mut value = [0.0; 4];
        for (value, part) in value.iter_mut().zip(bytes.chunks_exact(size)) {
            *value = number(scalar(component), part);
        }
        value
    };
    let rows = read(
        buffers,
        accessor,
        index,
        components * size,
        [0.0; 4],
        decode,
    )?;
    buffers.spend(8 * rows.len() * components)?;
    let mut values = Vec::with_capacity(rows.len() * components);
    rows.iter()
        .for_each(|row| values.extend_from_slice(&row[..components]));
    Ok(Raw {
        scalar: scalar(component),
        normalized: accessor.normalized,
        components,
        values,
    })
}

fn get<'a>(buffers: &Buffers<'a>, index: usize) -> Result<&'a Accessor, IoError> {
    let all = &buffers.root.accessors;
    all.get(index).ok_or_else(|| {
        fault(
            buffers,
            index,
            format!("the file has only {} accessors", all.len()),
        )
    })
}

fn layout(
    buffers: &Buffers<'_>,
    accessor: &Accessor,
    index: usize,
    wanted: Type,
    use_: &str,
) -> Result<ComponentType, IoError> {
    match (accessor.component_type, accessor.type_) {
        (Checked::Valid(component), Checked::Valid(type_)) if type_ == wanted => Ok(component.0),
        (Checked::Valid(_), Checked::Valid(type_)) => Err(fault(
            buffers,
            index,
            format!("its type {type_:?} does not fit {use_}"),
        )),
        _ => Err(fault(
            buffers,
            index,
            "its type or component type is not known".to_string(),
        )),
    }
}

/// Reads `accessor.count` items of `size` bytes each, and replaces the items of the sparse part.
fn read<T: Copy>(
    buffers: &mut Buffers<'_>,
    accessor: &Accessor,
    index: usize,
    size: usize,
    zero: T,
    decode: impl Fn(&[u8]) -> T,
) -> Result<Vec<T>, IoError> {
    let count = accessor.count.0;
    let offset = accessor.byte_offset.unwrap_or_default().0;
    let mut values = match accessor.buffer_view {
        Some(view) => {
            let wanted = Wanted {
                view: view.value(),
                offset,
                count,
                size,
            };
            wanted.items(buffers, index, &decode)?
        }
        None => {
            let count = zeros(buffers, accessor, index)?;
            buffers.spend(count * size_of::<T>())?;
            vec![zero; count]
        }
    };
    if let Some(sparse) = &accessor.sparse {
        replace(buffers, sparse, index, size, &mut values, &decode)?;
    }
    Ok(values)
}

/// The length of an accessor without a buffer view, which is zero except in its sparse part. No bytes of the file back
/// this length, so that it is limited to `MOST` items.
fn zeros(buffers: &Buffers<'_>, accessor: &Accessor, index: usize) -> Result<usize, IoError> {
    const MOST: u64 = 1 << 20;
    if accessor.sparse.is_none() {
        return Err(fault(buffers, index, "it has no data".to_string()));
    }
    match usize::try_from(accessor.count.0) {
        Ok(count) if count as u64 <= MOST => Ok(count),
        _ => Err(fault(
            buffers,
            index,
            format!("it claims {} items without data", accessor.count.0),
        )),
    }
}

fn replace<T: Copy>(
    buffers: &mut Buffers<'_>,
    sparse: &Sparse,
    index: usize,
    size: usize,
    values: &mut [T],
    decode: &impl Fn(&[u8]) -> T,
) -> Result<(), IoError> {
    let Checked::Valid(component) = sparse.indices.component_type else {
        return Err(fault(
            buffers,
            index,
            "the type of its sparse indices is not known".to_string(),
        ));
    };
    let at = Wanted {
        view: sparse.indices.buffer_view.value(),
        offset: sparse.indices.byte_offset.0,
        count: sparse.count.0,
        size: component.0.size(),
    };
    let places = at.items(buffers, index, &|bytes| {
        number(scalar(component.0), bytes) as usize
    })?;
    let of = Wanted {
        view: sparse.values.buffer_view.value(),
        offset: sparse.values.byte_offset.0,
        count: sparse.count.0,
        size,
    };
    let items = of.items(buffers, index, decode)?;
    for (place, item) in places.into_iter().zip(items) {
        match values.get_mut(place) {
            Some(value) => *value = item,
            None => {
                let what = format!("its sparse part names item {place} of {}", values.len());
                return Err(fault(buffers, index, what));
            }
        }
    }
    Ok(())
}

/// A range of equally spaced items in a buffer view.
struct Wanted {
    view: usize,
    offset: u64,
    count: u64,
    size: usize,
}

impl Wanted {
    fn items<T>(
        &self,
        buffers: &mut Buffers<'_>,
        accessor: usize,
        decode: &impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, IoError> {
        let format = buffers.format;
        let (view, bytes) = buffers.view(self.view)?;
        let stride =
            view.byte_stride.map_or(
                self.size,
                |stride| if stride.0 == 0 { self.size } else { stride.0 },
            );
        let end = self.count.checked_sub(1).map_or(Some(self.offset), |last| {
            last.checked_mul(stride as u64)?
                .checked_add(self.offset)?
                .checked_add(self.size as u64)
        });
        if stride < self.size || end.is_none_or(|end| end > bytes.len() as u64) {
            let what = format!(
                "{} items of {} bytes, {stride} apart, do not fit in the {} bytes of buffer view {}",
                self.count,
                self.size,
                bytes.len(),
                self.view
            );
            return Err(IoError::malformed(
                format,
                Location::Item("accessor", accessor),
                what,
            ));
        }
        let start = self.offset as usize;
        buffers.spend((self.count as usize).saturating_mul(size_of::<T>()))?;
        let (_, bytes) = buffers.view(self.view)?;
        Ok((0..self.count as usize)
            .map(|i| decode(&bytes[start + i * stride..][..self.size]))
            .collect())
    }
}

/// The number in the bytes of a scalar; NaN if there are too few bytes.
fn number(scalar: Scalar, bytes: &[u8]) -> f64 {
    scalar
        .take::<false>(bytes)
        .map_or(f64::NAN, |(value, _)| value)
}

/// The scalar type of a `componentType`; `None` if it is unknown.
pub(super) fn component(number: &Value) -> Option<Scalar> {
    match Checked::<GenericComponentType>::deserialize(number).ok()? {
        Checked::Valid(kind) => Some(scalar(kind.0)),
        Checked::Invalid => None,
    }
}

fn scalar(component: ComponentType) -> Scalar {
    match component {
        ComponentType::I8 => Scalar::I8,
        ComponentType::U8 => Scalar::U8,
        ComponentType::I16 => Scalar::I16,
        ComponentType::U16 => Scalar::U16,
        ComponentType::U32 => Scalar::U32,
        ComponentType::F32 => Scalar::F32,
    }
}

fn fault(buffers: &Buffers<'_>, index: usize, what: String) -> IoError {
    IoError::malformed(buffers.format, Location::Item("accessor", index), what)
}
