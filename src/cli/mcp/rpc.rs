//! Messages of JSON-RPC 2.0: reading lines, and making answers and errors.

use std::io::{BufRead, Read};

use serde_json::{Map, Value, json};

/// Bytes. Longest message that is read; parameters of tools are far shorter.
const LONGEST: u64 = 4 << 20;

/// Codes of errors, as JSON-RPC defines them.
pub const PARSE_ERROR: i32 = -32700;
pub const INVALID_REQUEST: i32 = -32600;
pub const METHOD_NOT_FOUND: i32 = -32601;
pub const INVALID_PARAMS: i32 = -32602;

/// A message of the client.
#[derive(Debug, PartialEq)]
pub enum Message {
    /// A request, which is answered.
    Request {
        id: Value,
        method: String,
        params: Map<String, Value>,
    },
    /// A notification, which is not.
    Notification {
        method: String,
        params: Map<String, Value>,
    },
    /// An answer of the client; none is expected.
    Answer,
    /// No message: the id where it could be read, the code and the text of the error.
    Wrong(Value, i32, &'static str),
}

/// Reads the next line; none at the end. A line that is too long is skipped, and is empty of content in the result.
pub fn next_line(input: &mut impl BufRead) -> std::io::Result<Option<Result<Vec<u8>, ()>>> {
    let mut line = Vec::new();
    if input.by_ref().take(LONGEST).read_until(b'\n', &mut line)? == 0 {
        return Ok(None);
    }
    if line.ends_with(b"\n") || (line.len() as u64) < LONGEST {
        return Ok(Some(Ok(line)));
    }
    loop {
        line.clear();
        let read = input.by_ref().take(LONGEST).read_until(b'\n', &mut line)?;
        if read == 0 || line.ends_with(b"\n") {
            return Ok(Some(Err(())));
        }
    }
}

/// The message of a line.
pub fn parsed(line: &[u8]) -> Message {
    let Ok(value) = serde_json::from_slice::<Value>(line) else {
        return Message::Wrong(Value::Null, PARSE_ERROR, "the message is not JSON");
    };
    let Value::Object(mut message) = value else {
        let what = "a message must be an object; batches are not supported";
        return Message::Wrong(Value::Null, INVALID_REQUEST, what);
    };
    let id = message.remove("id");
    let is_id = |id: &Value| id.is_string() || id.is_number();
    let known = id.clone().filter(is_id).unwrap_or_default();
    let wrong = |code, what| Message::Wrong(known.clone(), code, what);
    if message.get("jsonrpc") != Some(&json!("2.0")) {
        return wrong(INVALID_REQUEST, "\"jsonrpc\" must be \"2.0\"");
    }
    if id.as_ref().is_some_and(|id| !is_id(id)) {
        return wrong(INVALID_REQUEST, "\"id\" must be a text or a number");
    }
    let method = match message.remove("method") {
        Some(Value::String(method)) => method,
        None if message.contains_key("result") || message.contains_key("error") => {
            return Message::Answer;
        }
        _ => return wrong(INVALID_REQUEST, "\"method\" must be a text"),
    };
    let params = match message.remove("params") {
        None | Some(Value::Null) => Map::new(),
        Some(Value::Object(params)) => params,
        Some(_) => return wrong(INVALID_PARAMS, "\"params\" must be an object"),
    };
    match id {
        Some(id) => Message::Request { id, method, params },
        None => Message::Notification { method, params },
    }
}

/// The answer to a request.
pub fn answer(id: &Value, result: Value) -> Value {
    json!({ "jsonrpc": "2.0", "id": id, "result": result })
}

/// The answer to a request that could not be followed.
pub fn error(id: &Value, code: i32, what: &str) -> Value {
    json!({ "jsonrpc": "2.0", "id": id, "error": { "code": code, "message": what } })
}

/// A notification to the client.
pub fn notification(method: &str, params: Value) -> Value {
    json!({ "jsonrpc": "2.0", "method": method, "params": params })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_recognised_by_their_members() {
        let request = parsed(br#"{"jsonrpc":"2.0","id":"a","method":"ping"}"#);
        assert_eq!(
            request,
            Message::Request {
                id: json!("a"),
                method: "ping".to_owned(),
                params: Map::new()
            }
        );
        for params in ["{}", "null"] {
            let line = format!(r#"{{"jsonrpc":"2.0","method":"x","params":{params}}}"#);
            let notified = parsed(line.as_bytes());
            assert!(matches!(notified, Message::Notification { .. }));
        }
        assert_eq!(
            parsed(br#"{"jsonrpc":"2.0","id":1,"result":{}}"#),
            Message::Answer
        );
        for (line, expected, code) in [
            ("{", Value::Null, PARSE_ERROR),
            ("[]", Value::Null, INVALID_REQUEST),
            (r#"{"id":1,"method":"ping"}"#, json!(1), INVALID_REQUEST),
            (r#"{"jsonrpc":"2.0","id":1}"#, json!(1), INVALID_REQUEST),
            (
                r#"{"jsonrpc":"2.0","id":null,"method":"ping"}"#,
                Value::Null,
                INVALID_REQUEST,
            ),
            (
                r#"{"jsonrpc":"2.0","id":2,"method":"ping","params":[1]}"#,
                json!(2),
                INVALID_PARAMS,
            ),
        ] {
            let Message::Wrong(id, given, _) = parsed(line.as_bytes()) else {
                panic!("{line}")
            };
            assert_eq!((id, given), (expected, code), "{line}");
        }
    }

    #[test]
    fn a_line_that_is_too_long_is_skipped() {
        let mut text = vec![b'x'; 2 * LONGEST as usize + 5];
        text.extend(b"\n{}\nlast");
        let mut input = &text[..];
        assert_eq!(next_line(&mut input).unwrap(), Some(Err(())));
        assert_eq!(next_line(&mut input).unwrap(), Some(Ok(b"{}\n".to_vec())));
        assert_eq!(next_line(&mut input).unwrap(), Some(Ok(b"last".to_vec())));
        assert_eq!(next_line(&mut input).unwrap(), None);
    }
}
