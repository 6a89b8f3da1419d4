//! Arrays of numbers as the page gets them: a header of JSON, then the arrays one after the other, little-endian.

use serde_json::{Map, Value, json};

/// What is sent to the page in binary.
///
/// The bytes are: the length of the header as `u32`, the header, padded with spaces so that what follows begins at a multiple of
/// four bytes, and the arrays, each padded likewise.
pub struct Container {
    header: Map<String, Value>,
    arrays: Vec<Value>,
    body: Vec<u8>,
}

/// A number in an array.
pub trait Number: Copy {
    /// Its name in the header.
    const NAME: &'static str;
    /// Appends its bytes.
    fn put(self, bytes: &mut Vec<u8>);
}

macro_rules! numbers {
    ($($type:ty),*) => {
        $(impl Number for $type {
            const NAME: &'static str = stringify!($type);
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        })*
    };
}
numbers!(f32, u32, u16, u8);

impl Container {
    /// A container with what its header says beside the arrays, which must be an object.
    pub fn new(header: Value) -> Self {
        let header = match header {
            Value::Object(header) => header,
            _ => Map::new(),
        };
        Self {
            header,
            arrays: Vec::new(),
            body: Vec::new(),
        }
    }

    /// The same with an array of values of so many components.
    #[must_use]
    pub fn with<N: Number>(
        mut self,
        name: &str,
        components: usize,
        values: impl IntoIterator<Item = N>,
    ) -> Self {
        let start = self.body.len();
        for value in values {
            value.put(&mut self.body);
        }
        let numbers = (self.body.len() - start) / size_of::<N>();
        self.body.resize(self.body.len().next_multiple_of(4), 0);
        self.arrays.push(json!({
            "name": name,
            "type": N::NAME,
            "components": components,
            "count": numbers / components.max(1),
        }));
        self
    }

    /// The bytes.
    pub fn bytes(mut self) -> Vec<u8> {
        self.header
            .insert("arrays".to_owned(), Value::Array(self.arrays));
        let mut header = Value::Object(self.header).to_string().into_bytes();
        header.resize(header.len().next_multiple_of(4), b' ');
        let mut bytes = Vec::with_capacity(4 + header.len() + self.body.len());
        (header.len() as u32).put(&mut bytes);
        bytes.extend_from_slice(&header);
        bytes.extend_from_slice(&self.body);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_begin_at_multiples_of_four_bytes() {
        let bytes = Container::new(json!({ "id": 7 }))
            .with("a", 1, [1u8, 2, 3])
            .with("b", 3, [1.5f32, 2.0, -1.0])
            .bytes();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        assert_eq!((4 + length) % 4, 0);
        let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        assert_eq!(header["id"], 7);
        assert_eq!(
            header["arrays"],
            json!([
                { "name": "a", "type": "u8", "components": 1, "count": 3 },
                { "name": "b", "type": "f32", "components": 3, "count": 1 },
            ])
        );
        let body = &bytes[4 + length..];
        assert_eq!(body[..4], [1, 2, 3, 0]);
        assert_eq!(body[4..8], 1.5f32.to_le_bytes());
        assert_eq!(body.len(), 16);
    }
}
