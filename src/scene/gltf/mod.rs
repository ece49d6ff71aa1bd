//! Reads glTF 2.0, `.glb` and `.gltf`, defensively.
//!
//! Source: the Khronos specification, glTF 2.0.1, with KHR_materials_transmission, _volume, _ior, _dispersion,
//! _emissive_strength _unlit and _variants, KHR_mesh_quantization and KHR_texture_transform.
//!
//! [`container`] finds the bytes, [`document`] is the JSON, [`accessor`] turns checked bytes into numbers;
//! [`hierarchy`], [`primitive`] (with [`normals`] and [`cutout`]), [`animations`], [`materials`] and [`pictures`] make the parts of a [`Geometry`].
//!
//! What stops the picture is one error; what does not is a warning. Every index, size and offset is checked where it is
//! followed, and nothing is allocated that the file has no bytes for.

mod accessor;
mod animations;
mod container;
mod cutout;
mod document;
mod hierarchy;
mod materials;
mod normals;
mod pictures;
mod primitive;

use super::geometry::{Geometry, MatrixSource, Part};
use super::{SceneError, Warning};
use accessor::Accessors;
use container::Container;
pub(super) use container::{MAX_FILE_BYTES, read_file};
use document::{Document, Primitive};
use hierarchy::Hierarchy;
use materials::Materials;
use primitive::{MAX_MORPHS, MAX_TRIANGLES, MAX_VERTICES, Rig, Room, Surface};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A model and what was odd about it.
#[derive(Debug)]
pub struct Loaded {
    /// The model.
    pub geometry: Geometry,
    /// What was odd.
    pub warnings: Vec<Warning>,
    /// Those of the warnings that tell of a picture that can't be read.
    pub lost_pictures: Vec<Warning>,
    /// Files beside it that were read too.
    pub files: Vec<PathBuf>,
}

/// Extensions that a file may require.
const SUPPORTED: [&str; 12] = [
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Reads a model file.
///
/// # Errors
/// When the file can't be read, is no glTF 2.0, contradicts itself, needs what is not supported, or shows nothing.
pub fn read(path: &Path) -> Result<Loaded, SceneError> {
    let place = path.display().to_string();
    let bytes = read_file(path, MAX_FILE_BYTES).map_err(|e| SceneError::new(&place, e))?;
    let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
    parse(&bytes, folder, &place)
}

/// Reads a model from its bytes. Files that it names must lie in `folder`; without one it may name none.
///
/// # Errors
/// As [`read`]; messages start with `place`.
pub fn parse(bytes: &[u8], folder: Option<&Path>, place: &str) -> Result<Loaded, SceneError> {
    let mut report = Report { place: place.to_owned(), warnings: Vec::new(), lost_pictures: Vec::new() };
    let fault = |what: String| SceneError::new(place, what);
    let (json, binary) = container::split(bytes).map_err(fault)?;
    let document: Document = serde_json::from_slice(json).map_err(|e| not_gltf(&e, binary.is_some(), place))?;
    check(&document, &mut report).map_err(fault)?;
    let container = Container::new(folder, binary);
    let geometry = {
        let accessors = Accessors::new(&document, &container, bytes.len());
        model(&document, &accessors, &container, &mut report).map_err(fault)?
    };
    let Report { warnings, lost_pictures, .. } = report;
    Ok(Loaded { geometry, warnings, lost_pictures, files: container.into_files() })
}

fn not_gltf(error: &serde_json::Error, inside_binary: bool, place: &str) -> SceneError {
    let what = error.to_string();
    let what = what.split(" at line ").next().unwrap_or_default();
    let place = if inside_binary || error.line() == 0 {
        place.to_owned()
    } else {
        format!("{place}:{}:{}", error.line(), error.column())
    };
    SceneError::new(place, format!("is no glTF that can be read: {what}; name a .glb or .gltf file, version 2.0"))
}

fn check(document: &Document, report: &mut Report) -> Result<(), String> {
    let version = document.asset.version.as_str();
    if !version.starts_with("2.") && version != "2" {
        let shown: String = version.chars().take(20).collect();
        return Err(format!("glTF version `{shown}`; only 2.0 can be read, convert the file"));
    }
    for required in &document.extensions_required {
        // Unknown materials cost looks, not geometry.
        if required.starts_with("KHR_materials_") || required.starts_with("KHR_texture_") {
            if !SUPPORTED.contains(&required.as_str()) {
                report.warn(format!("`{}` is not supported; the model may look different", short(required)));
            }
        } else if required.starts_with("EXT_texture_") {
            report.warn(format!("`{}` is not supported; such pictures are left out", short(required)));
        } else if !SUPPORTED.contains(&required.as_str()) {
            return Err(format!("needs `{}`, which is not supported; export the model without it", short(required)));
        }
    }
    Ok(())
}

fn model<'a>(
    document: &'a Document,
    accessors: &Accessors<'a>,
    container: &Container<'a>,
    report: &mut Report,
) -> Result<Geometry, String> {
    let hierarchy = Hierarchy::of(document, report)?;
    let mut build = Build {
        document,
        accessors,
        materials: Materials::new(document, accessors, container),
        geometry: Geometry {
            variants: document.extensions.variants.variants.iter().map(|v| name(Some(&v.name), "variant")).collect(),
            ..Geometry::default()
        },
        names: BTreeSet::new(),
        skins: BTreeMap::new(),
        targets: vec![0; hierarchy.nodes.len()],
        hierarchy,
    };
    build.check_size()?;
    for i in 0..build.hierarchy.shown.len() {
        build.add_node(build.hierarchy.shown[i], report)?;
    }
    let Build { mut geometry, hierarchy, targets, materials, .. } = build;
    if geometry.triangles.is_empty() {
        return Err("has no triangles to show; export a model with faces".to_owned());
    }
    geometry.clips = animations::clips(document, accessors, &hierarchy, &targets, report);
    geometry.nodes = hierarchy.nodes;
    geometry.textures = materials.pictures.textures;
    geometry.measure();
    Ok(geometry)
}

/// A model as it grows.
struct Build<'r, 'a> {
    document: &'a Document,
    accessors: &'r Accessors<'a>,
    hierarchy: Hierarchy,
    materials: Materials<'r, 'a>,
    geometry: Geometry,
    names: BTreeSet<String>,
    /// By skin: its first matrix and how many.
    skins: BTreeMap<usize, (u32, u32)>,
    /// Morph targets of each node's mesh.
    targets: Vec<usize>,
}

impl Build<'_, '_> {
    /// Refuses at once what is too large, before any of it is read. What else is wrong shows when it is read.
    fn check_size(&self) -> Result<(), String> {
        let (mut triangles, mut vertices) = (0_usize, 0_usize);
        for &node in &self.hierarchy.shown {
            let mesh = self.document.nodes[node].mesh.and_then(|m| self.document.meshes.get(m));
            for primitive in mesh.into_iter().flat_map(|m| &m.primitives) {
                let (more_triangles, more_vertices) = primitive::size(primitive, self.accessors);
                triangles = triangles.saturating_add(more_triangles);
                vertices = vertices.saturating_add(more_vertices);
            }
        }
        if triangles > MAX_TRIANGLES {
            return Err(primitive::too_many_triangles());
        }
        if vertices > MAX_VERTICES { Err(primitive::too_many_vertices(vertices)) } else { Ok(()) }
    }

    fn add_node(&mut self, node: usize, report: &mut Report) -> Result<(), String> {
        let source = &self.document.nodes[node];
        let Some(mesh_index) = source.mesh else { return Ok(()) };
        let document = self.document;
        let mesh = document.meshes.get(mesh_index).ok_or_else(|| {
            format!("node {node} shows mesh {mesh_index}, which does not exist; export the file again")
        })?;
        let place = self.hierarchy.places[node];
        let targets = mesh.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0);
        self.targets[place as usize] = targets;
        let weights = &mut self.hierarchy.nodes[place as usize].weights;
        if weights.is_empty() {
            weights.clone_from(&mesh.weights);
        }
        weights.resize(targets, 0.0);
        weights.iter_mut().filter(|w| !w.is_finite()).for_each(|w| *w = 0.0);
        let mut node_matrix = None;
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let fault = |what: String| format!("mesh {mesh_index}, primitive {i}: {what}");
            let skinned = primitive.attributes.joints0.is_some() && primitive.attributes.weights0.is_some();
            let rig = match source.skin.filter(|_| skinned) {
                Some(skin) => self.skin(skin, report)?,
                None => None,
            };
            let rig = match rig {
                Some(rig) => rig,
                None => Rig::Node(match node_matrix {
                    Some(matrix) => matrix,
                    None => *node_matrix.insert(self.add_matrices([MatrixSource::Node(place)])?),
                }),
            };
            let own_name = source.name.as_deref().or(mesh.name.as_deref());
            self.add_primitive(primitive, rig, place, own_name, report).map_err(fault)?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &Primitive,
        rig: Rig,
        node: u32,
        own_name: Option<&str>,
        report: &mut Report,
    ) -> Result<(), String> {
        let uv_use = self.materials.uv_use(primitive.material)?;
        let room = Room {
            vertices: MAX_VERTICES - self.geometry.vertices.len(),
            triangles: MAX_TRIANGLES - self.geometry.triangles.len(),
            morphs: MAX_MORPHS - self.geometry.morphs.len(),
        };
        let material = self.materials.material(primitive.material, uv_use.as_ref(), report)?;
        let picture = material.base_color_texture.map(|t| &self.materials.pictures.textures[t as usize]);
        let surface = Surface { uv_use: uv_use.as_ref(), picture };
        let Some(mut mesh) = primitive::mesh(primitive, self.accessors, rig, &surface, room, report)? else {
            return Ok(());
        };
        if mesh.flat && !material.opaque && !material.thin_wall {
            report.warn(
                "a clear part has no normals, so it has facets; export it with normals for smooth glass".to_owned(),
            );
        }
        if mesh.colored && !material.opaque {
            report.warn("vertex colours of a clear part are not shown".to_owned());
        }
        let mut variant_materials = Vec::new();
        for mapping in &primitive.extensions.variants.mappings {
            let of_variant = self.materials.material(Some(mapping.material), uv_use.as_ref(), report)?;
            for &variant in mapping.variants.iter().filter(|v| **v < self.geometry.variants.len()) {
                variant_materials.push((variant, of_variant.clone()));
            }
        }
        let material_name = primitive.material.and_then(|m| self.document.materials[m].name.as_deref());
        let wanted = name(material_name.filter(|n| !n.trim().is_empty()).or(own_name), "part");
        let geometry = &mut self.geometry;
        let (first_vertex, first_triangle) = (number(geometry.vertices.len())?, number(geometry.triangles.len())?);
        let morph_first = number(geometry.morphs.len())?;
        geometry.vertices.append(&mut mesh.vertices);
        geometry.influences.append(&mut mesh.influences);
        geometry.morphs.append(&mut mesh.morphs);
        geometry.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first_vertex)));
        geometry.parts.push(Part {
            name: unique(&wanted, &mut self.names),
            vertices: first_vertex..number(geometry.vertices.len())?,
            triangles: first_triangle..number(geometry.triangles.len())?,
            morph_first,
            morph_count: number(mesh.targets)?,
            node,
            flat: mesh.flat,
            vertex_colors: mesh.colored,
            material,
            variant_materials,
            plane_half: None,
        });
        Ok(())
    }

    /// The rig of a skin, its matrices added once; `None` for a skin without joints.
    fn skin(&mut self, skin: usize, report: &mut Report) -> Result<Option<Rig>, String> {
        let (first, joints) = match self.skins.get(&skin) {
            Some(&known) => known,
            None => {
                let sources = hierarchy::skin(skin, self.document, self.accessors, &self.hierarchy, report)?;
                let joints = number(sources.len())?;
                let added = (self.add_matrices(sources)?, joints);
                self.skins.insert(skin, added);
                added
            }
        };
        if joints == 0 {
            report.warn(format!("skin {skin} has no joints; its mesh stands still"));
            return Ok(None);
        }
        Ok(Some(Rig::Skin { first, joints }))
    }

    /// Adds matrices and tells the first one's index.
    fn add_matrices(&mut self, sources: impl IntoIterator<Item = MatrixSource>) -> Result<u32, String> {
        let first = number(self.geometry.matrices.len())?;
        self.geometry.matrices.extend(sources);
        Ok(first)
    }
}

/// Collects what is odd about a file: each thing once, and not without end.
struct Report {
    place: String,
    warnings: Vec<Warning>,
    lost_pictures: Vec<Warning>,
}

impl Report {
    fn lose_picture(&mut self, what: String) {
        self.lost_pictures.push(Warning::new(self.place.clone(), what.clone()));
        self.warn(what);
    }

    fn warn(&mut self, what: String) {
        const MOST: usize = 32;
        if self.warnings.len() > MOST || self.warnings.iter().any(|w| w.what == what) {
            return;
        }
        let what = if self.warnings.len() == MOST { "and more of the kind".to_owned() } else { what };
        self.warnings.push(Warning::new(self.place.clone(), what));
    }
}

/// A name that can be shown on one line, or another where there is none.
fn name(given: Option<&str>, otherwise: &str) -> String {
    let plain: String = given.unwrap_or_default().chars().filter(|c| !c.is_control()).take(100).collect();
    let plain = plain.trim();
    if plain.is_empty() { otherwise.to_owned() } else { plain.to_owned() }
}

fn short(text: &str) -> String {
    name(Some(text), "?")
}

/// A name that nothing else in `taken` has, numbered from 2 if need be.
fn unique(wanted: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2_u32..).map(|n| format!("{wanted} {n}"));
    let found = std::iter::once(wanted.to_owned()).chain(numbered).find(|n| !taken.contains(n));
    let found = found.unwrap_or_else(|| wanted.to_owned());
    taken.insert(found.clone());
    found
}

fn number(n: usize) -> Result<u32, String> {
    u32::try_from(n).ok().ok_or_else(|| "has more than 2³² of something; simplify the model".to_owned())
}
