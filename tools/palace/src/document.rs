//! A glTF document under construction, with its binary chunk.

use serde_json::{Map, Value, json};

/// The lists of a document by name, and the bytes of its buffer.
#[derive(Default)]
pub(crate) struct Document {
    lists: Map<String, Value>,
    binary: Vec<u8>,
    /// Length of the buffer that compressed views would be decoded into.
    decoded: usize,
}

impl Document {
    /// Appends an element to a list such as `nodes`. Returns its index.
    pub(crate) fn push(&mut self, list: &str, element: Value) -> usize {
        let list = self.lists.entry(list).or_insert_with(|| json!([]));
        let list = list.as_array_mut().expect("all entries are lists");
        list.push(element);
        list.len() - 1
    }

    /// Adds a view of plain bytes.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let start = self.append(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": start, "byteLength": bytes.len()}),
        )
    }

    /// Adds a view of bytes that meshoptimizer compressed: `count` elements of `stride` bytes.
    pub(crate) fn compressed(
        &mut self,
        bytes: &[u8],
        [count, stride]: [usize; 2],
        mode: &str,
        filter: &str,
    ) -> usize {
        let start = self.append(bytes);
        let length = count * stride;
        let mut view = json!({
            "buffer": 1, "byteOffset": self.decoded, "byteLength": length,
            "target": if mode == "TRIANGLES" { 34963 } else { 34962 },
            "extensions": {"EXT_meshopt_compression": {
                "buffer": 0, "byteOffset": start, "byteLength": bytes.len(),
                "byteStride": stride, "count": count, "mode": mode, "filter": filter}}});
        if mode != "TRIANGLES" {
            view["byteStride"] = json!(stride);
        }
        self.decoded += length.next_multiple_of(4);
        self.push("bufferViews", view)
    }

    fn append(&mut self, bytes: &[u8]) -> usize {
        let start = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        start
    }

    /// Returns the bytes of the GLB; `rest` is what else its JSON has.
    pub(crate) fn glb(mut self, rest: Value) -> Vec<u8> {
        self.push("buffers", json!({"byteLength": self.binary.len()}));
        if self.decoded > 0 {
            let fallback = json!({"byteLength": self.decoded, "extensions": {"EXT_meshopt_compression": {"fallback": true}}});
            self.push("buffers", fallback);
        }
        let Value::Object(mut json) = rest else {
            unreachable!("a document is an object")
        };
        json.extend(self.lists);
        let mut json = Value::Object(json).to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF".to_vec();
        let length = 12 + 8 + json.len() + 8 + self.binary.len();
        glb.extend([2, length as u32].map(u32::to_le_bytes).as_flattened());
        for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &self.binary)] {
            glb.extend((bytes.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(bytes);
        }
        glb
    }
}

/// Returns a number with no more digits than an f32 needs.
pub(crate) fn number(value: f32) -> Value {
    let shortest: f64 = (value + 0.0).to_string().parse().expect("a number");
    match shortest.fract() == 0.0 && shortest.abs() < 1e9 {
        true => json!(shortest as i64),
        false => json!(shortest),
    }
}

pub(crate) fn numbers(values: &[f32]) -> Value {
    values.iter().map(|&value| number(value)).collect()
}
