//! Values as bytes, in which they are sent and pickled.

use crate::errors::Failure;

/// A value in the form in which it is sent: MessagePack, structures by the names of their fields.
pub fn packed<T: serde::Serialize>(value: &T) -> Result<Vec<u8>, Failure> {
    rmp_serde::to_vec_named(value).map_err(|e| Failure::new("IsomendError", e.to_string()))
}

/// A value that was sent; `what` names it in the message.
pub fn unpacked<T: serde::de::DeserializeOwned>(bytes: &[u8], what: &str) -> Result<T, Failure> {
    rmp_serde::from_slice(bytes)
        .map_err(|e| Failure::parameter(format!("these bytes are no {what}: {e}")))
}

/// A document as JSON.
pub fn json_of(document: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(document).map_err(|e| Failure::new("IsomendError", e.to_string()))
}
