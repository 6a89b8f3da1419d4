//! The binary format of arrays sent to the page: a JSON header, then the arrays one after the other, little-endian.

use serde_json::{Map, Value, json};

/// Named arrays with a header.
///
/// The bytes are: the length of the header as `u32`, the header, padded with spaces to a multiple of four bytes, and the arrays, each
/// padded with zeros to a multiple of four bytes.
pub struct Container {
    header: Map<String, Value>,
    arrays: Vec<Value>,
    body: Vec<u8>,
}

/// A number type of arrays.
pub trait Number: Copy {
    /// Name of the type in the header.
    const NAME: &'static str;
    /// Appends the number's bytes.
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
    /// A container without arrays; `header` is a JSON object, to which the list of arrays is added.
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

    /// Appends an array of values with `components` numbers each.
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

    /// The encoded container.
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
