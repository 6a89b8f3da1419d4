//! Serialisation: values as bytes (MessagePack) for pickling and other processes, and documents as JSON.

use crate::errors::Failure;

/// A value as MessagePack, with the field names of structures.
pub fn packed<T: serde::Serialize>(value: &T) -> Result<Vec<u8>, Failure> {
    rmp_serde::to_vec_named(value).map_err(|e| Failure::new("IsomendError", e.to_string()))
}

/// A value from the bytes of `packed`; `what` names it in the error message.
pub fn unpacked<T: serde::de::DeserializeOwned>(bytes: &[u8], what: &str) -> Result<T, Failure> {
    rmp_serde::from_slice(bytes)
        .map_err(|e| Failure::parameter(format!("these bytes are no {what}: {e}")))
}

/// A document as JSON.
pub fn json_of(document: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(document).map_err(|e| Failure::new("IsomendError", e.to_string()))
}
