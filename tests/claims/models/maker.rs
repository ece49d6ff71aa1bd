//! Makes small glTF files for tests, piece by piece.

use murrine::scene::gltf::{self, Loaded};
use serde_json::{Value, json};

/// A document that grows, with one buffer.
pub(super) struct Maker {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
}

pub(super) const F32: u32 = 5126;
pub(super) const U8: u32 = 5121;
pub(super) const U16: u32 = 5123;
pub(super) const U32: u32 = 5125;
pub(super) const I8: u32 = 5120;
pub(super) const I16: u32 = 5122;

impl Maker {
    /// A document of nothing but its version.
    pub(super) fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "buffers": [{ "byteLength": 0 }], "materials": [], "skins": [],
            "animations": [], "textures": [], "images": [],
        });
        Self { json, bytes: Vec::new() }
    }

    /// One triangle in the plane z = 0, counter-clockwise from +z, at one node.
    pub(super) fn triangle() -> Self {
        let mut maker = Self::new();
        let position = maker.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        maker.add_mesh(&json!({ "attributes": { "POSITION": position } }));
        maker
    }

    /// Appends to one of the document's lists and tells the index.
    pub(super) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// A mesh of one primitive, shown at a node of the scene; tells the node.
    pub(super) fn add_mesh(&mut self, primitive: &Value) -> usize {
        let mesh = self.push("meshes", json!({ "primitives": [primitive] }));
        self.add_root(json!({ "mesh": mesh }))
    }

    /// A node of the scene.
    pub(super) fn add_root(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
        node
    }

    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub(super) fn last_view(&mut self) -> &mut Value {
        self.json["bufferViews"].as_array_mut().unwrap().last_mut().unwrap()
    }

    pub(super) fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component, "type": kind, "count": count });
        self.push("accessors", accessor)
    }

    pub(super) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(F32, kind, values.len() / width, &bytes)
    }

    /// An animation of one channel.
    pub(super) fn animate(&mut self, name: &str, node: usize, path: &str, how: &str, times: &[f32], values: &[f32]) {
        let input = self.floats("SCALAR", times);
        let kind = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let output = self.floats(kind, values);
        self.push(
            "animations",
            json!({
                "name": name,
                "samplers": [{ "input": input, "output": output, "interpolation": how }],
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
            }),
        );
    }

    /// The document as a `.glb`.
    pub(super) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.bytes.len());
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let word = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
        let mut glb = [b"glTF".as_slice(), &2_u32.to_le_bytes(), &word(28 + text.len() + self.bytes.len())].concat();
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            glb.extend([&word(chunk.len()), kind.as_slice(), chunk].concat());
        }
        glb
    }

    /// The document read; it must be sound.
    pub(super) fn read(&self) -> Loaded {
        gltf::parse(&self.glb(), None, "made.glb").unwrap_or_else(|e| panic!("{e}"))
    }

    /// The document read without a word of warning.
    pub(super) fn read_cleanly(&self) -> Loaded {
        let loaded = self.read();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded
    }

    /// What stops the document from being read.
    pub(super) fn error(&self) -> String {
        gltf::parse(&self.glb(), None, "made.glb").unwrap_err().to_string()
    }
}
