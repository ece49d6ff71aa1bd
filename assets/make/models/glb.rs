//! Writes glTF 2.0 binary files.
//!
//! Positions are rounded to 2⁻¹⁸ and normals to 2⁻¹⁴, so that the last bits of the arithmetic behind them don't matter.

use super::mesh::{Mesh, index};
use glam::DVec3;
use serde_json::{Value, json};

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;

/// A file in the making. The lists are glTF's own, as JSON.
#[derive(Debug, Default)]
pub(crate) struct Glb {
    binary: Vec<u8>,
    buffer_views: Vec<Value>,
    accessors: Vec<Value>,
    pub(crate) materials: Vec<Value>,
    pub(crate) meshes: Vec<Value>,
    pub(crate) nodes: Vec<Value>,
    pub(crate) skins: Vec<Value>,
    pub(crate) animations: Vec<Value>,
}

/// A glass, by colour at a distance.
pub(crate) struct Glass<'a> {
    pub(crate) name: &'a str,
    pub(crate) ior: f64,
    /// What white light becomes after `distance`.
    pub(crate) color: [f64; 3],
    pub(crate) distance: f64,
}

/// Up to four joints and their weights (sum 1) of a vertex.
pub(crate) type Bindings = Vec<[(u16, f64); 4]>;

impl Glb {
    /// Adds a glass (KHR transmission, volume, ior) and returns its number.
    pub(crate) fn glass(&mut self, glass: &Glass<'_>) -> u32 {
        self.materials.push(json!({
            "name": glass.name,
            "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0 },
            "extensions": {
                "KHR_materials_ior": { "ior": glass.ior },
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_volume": {
                    "thicknessFactor": 1,
                    "attenuationColor": glass.color,
                    "attenuationDistance": glass.distance,
                },
            },
        }));
        index(self.materials.len() - 1)
    }

    /// Adds a clear wall without volume: it bends nothing and tints by its colour.
    pub(crate) fn thin_wall(&mut self, name: &str, tint: [f64; 3]) -> u32 {
        let [r, g, b] = tint;
        self.materials.push(json!({
            "name": name,
            "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1], "metallicFactor": 0, "roughnessFactor": 0 },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } },
        }));
        index(self.materials.len() - 1)
    }

    /// Adds something that light does not pass and returns its number.
    pub(crate) fn opaque(&mut self, name: &str, base_color: [f64; 3], roughness: f64) -> u32 {
        let [r, g, b] = base_color;
        self.materials.push(json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1], "metallicFactor": 0, "roughnessFactor": roughness,
            },
        }));
        index(self.materials.len() - 1)
    }

    /// A primitive of a mesh, bound to joints where `bindings` is given.
    pub(crate) fn primitive(&mut self, mesh: &Mesh, material: u32, bindings: Option<&Bindings>) -> Value {
        let mut attributes = json!({
            "POSITION": self.vectors(&mesh.positions, POSITION_STEPS, true),
            "NORMAL": self.vectors(&mesh.normals, NORMAL_STEPS, false),
        });
        if let Some(bindings) = bindings {
            let (joints, weights) = self.bindings(bindings);
            attributes["JOINTS_0"] = json!(joints);
            attributes["WEIGHTS_0"] = json!(weights);
        }
        let wide = mesh.positions.len() > usize::from(u16::MAX);
        let numbers: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        let (bytes, component) = if wide {
            (numbers.iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>(), UNSIGNED_INT)
        } else {
            let short = |i: &u32| u16::try_from(*i).expect("checked against the number of vertices").to_le_bytes();
            (numbers.iter().flat_map(short).collect(), UNSIGNED_SHORT)
        };
        let indices = self.accessor(&bytes, Some(ELEMENT_ARRAY_BUFFER), component, "SCALAR", numbers.len());
        json!({ "attributes": attributes, "indices": indices, "material": material })
    }

    /// A morph target: what it adds to positions and normals.
    pub(crate) fn target(&mut self, positions: &[DVec3], normals: &[DVec3]) -> Value {
        json!({
            "POSITION": self.vectors(positions, POSITION_STEPS, true),
            "NORMAL": self.vectors(normals, NORMAL_STEPS, false),
        })
    }

    /// Adds an animation channel, linear or cubic spline, and returns sampler and channel for its animation.
    pub(crate) fn keys(&mut self, times_secs: &[f64], values: &[f64], kind: &str) -> (usize, usize) {
        let bytes =
            |values: &[f64]| values.iter().flat_map(|v| round(*v, KEY_STEPS).to_le_bytes()).collect::<Vec<u8>>();
        let input = self.accessor(&bytes(times_secs), None, FLOAT, "SCALAR", times_secs.len());
        self.accessors[input]["min"] = json!([round(times_secs[0], KEY_STEPS)]);
        self.accessors[input]["max"] = json!([round(times_secs[times_secs.len() - 1], KEY_STEPS)]);
        let width = match kind {
            "VEC4" => 4,
            "VEC3" => 3,
            _ => 1,
        };
        let output = self.accessor(&bytes(values), None, FLOAT, kind, values.len() / width);
        (input, output)
    }

    /// Translations as inverse bind matrices; returns their accessor.
    pub(crate) fn inverse_binds(&mut self, joints: &[DVec3]) -> usize {
        let mut bytes = Vec::new();
        for joint in joints {
            let [x, y, z] = (-*joint).to_array();
            for value in [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0] {
                bytes.extend(round(value, POSITION_STEPS).to_le_bytes());
            }
        }
        self.accessor(&bytes, None, FLOAT, "MAT4", joints.len())
    }

    /// The file's bytes. `roots` are the scene's nodes.
    pub(crate) fn bytes(mut self, roots: &[u32]) -> Vec<u8> {
        pad(&mut self.binary, 0);
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "murrine assets" },
            "scene": 0,
            "scenes": [{ "nodes": roots }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.buffer_views,
            "buffers": [{ "byteLength": self.binary.len() }],
            "extensionsUsed": ["KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"],
        });
        if !self.skins.is_empty() {
            root["skins"] = json!(self.skins);
        }
        if !self.animations.is_empty() {
            root["animations"] = json!(self.animations);
        }
        let mut text = root.to_string().into_bytes();
        pad(&mut text, b' ');
        let mut file = Vec::with_capacity(28 + text.len() + self.binary.len());
        let length = |n: usize| index(n).to_le_bytes();
        file.extend(b"glTF");
        file.extend(2_u32.to_le_bytes());
        file.extend(length(28 + text.len() + self.binary.len()));
        file.extend(length(text.len()));
        file.extend(b"JSON");
        file.extend(&text);
        file.extend(length(self.binary.len()));
        file.extend(b"BIN\0");
        file.extend(&self.binary);
        file
    }

    fn vectors(&mut self, vectors: &[DVec3], steps: f64, with_bounds: bool) -> usize {
        let rounded: Vec<[f32; 3]> = vectors.iter().map(|v| v.to_array().map(|c| round(c, steps))).collect();
        let bytes: Vec<u8> = rounded.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        let accessor = self.accessor(&bytes, Some(ARRAY_BUFFER), FLOAT, "VEC3", vectors.len());
        if with_bounds {
            let fold = |start: f32, pick: fn(f32, f32) -> f32| {
                rounded.iter().fold([start; 3], |a, v| [pick(a[0], v[0]), pick(a[1], v[1]), pick(a[2], v[2])])
            };
            self.accessors[accessor]["min"] = json!(fold(f32::INFINITY, f32::min));
            self.accessors[accessor]["max"] = json!(fold(f32::NEG_INFINITY, f32::max));
        }
        accessor
    }

    /// Joints as bytes, weights as 16-bit fractions that sum to one exactly.
    fn bindings(&mut self, bindings: &Bindings) -> (usize, usize) {
        let (mut joints, mut weights) = (Vec::new(), Vec::new());
        for four in bindings {
            let mut shares = four.map(|(_, weight)| fraction16(weight));
            let sum: i64 = shares.iter().sum();
            let largest = (0..4).max_by_key(|&i| shares[i]).unwrap_or(0);
            shares[largest] += 65535 - sum;
            for (share, (joint, _)) in shares.iter().zip(four) {
                let used = if *share == 0 { 0 } else { *joint };
                joints.push(u8::try_from(used).expect("fewer than 256 joints"));
                weights.extend(u16::try_from(*share).expect("a share of 65535").to_le_bytes());
            }
        }
        let count = bindings.len();
        let joints = self.accessor(&joints, Some(ARRAY_BUFFER), UNSIGNED_BYTE, "VEC4", count);
        let weights = self.accessor(&weights, Some(ARRAY_BUFFER), UNSIGNED_SHORT, "VEC4", count);
        self.accessors[weights]["normalized"] = json!(true);
        (joints, weights)
    }

    fn accessor(&mut self, bytes: &[u8], target: Option<u32>, component: u32, kind: &str, count: usize) -> usize {
        pad(&mut self.binary, 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend(bytes);
        self.buffer_views.push(view);
        self.accessors.push(json!({
            "bufferView": self.buffer_views.len() - 1, "componentType": component, "type": kind, "count": count,
        }));
        self.accessors.len() - 1
    }
}

const POSITION_STEPS: f64 = 262_144.0;
const NORMAL_STEPS: f64 = 16_384.0;
const KEY_STEPS: f64 = 1_048_576.0;

#[expect(clippy::cast_possible_truncation, reason = "files hold single precision")]
fn round(value: f64, steps: f64) -> f32 {
    // Adding zero turns -0 into 0.
    ((value * steps).round() / steps + 0.0) as f32
}

#[expect(clippy::cast_possible_truncation, reason = "a weight is between 0 and 1")]
fn fraction16(weight: f64) -> i64 {
    (weight * 65535.0).round() as i64
}

fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().next_multiple_of(4), with);
}
