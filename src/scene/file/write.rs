//! Writes a scene as the file that reads back to it. What has its default value is left out.

use super::read::{AXES, BACKGROUNDS, DEFORMERS, LIGHTS, shape_name};
use crate::scene::csg::Tree;
use crate::scene::description::{
    Background, Cells, Deformer, EffectSettings, GridSettings, Light, LightKind, MaterialOverride, Model, Region,
    Scene, Separability, Shape, Source, VoxelizerSettings,
};
use crate::scene::expression::Expression;
use crate::scene::implicit::Implicit;
use crate::scene::parametric::Parametric;
use crate::scene::surface::Surface;
use crate::scene::words::Words;
use glam::Vec3;
use std::path::Path;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, Value};

/// The text of a scene file that says what `scene` says.
#[must_use]
pub fn to_toml(scene: &Scene) -> String {
    document(scene).to_string()
}

/// A scene file that says what `scene` says.
pub(super) fn document(scene: &Scene) -> DocumentMut {
    let mut document = DocumentMut::new();
    let mut section = |name: &str, table: Table| {
        if !table.is_empty() {
            document.insert(name, Item::Table(table));
        }
    };
    section("camera", camera(scene));
    section("grid", without_defaults(grid(&scene.grid), &grid(&GridSettings::default())));
    section("light_grid", without_defaults(grid(&scene.light_grid), &grid(&GridSettings::default())));
    let default = voxelizer(&VoxelizerSettings::default());
    section("voxelizer", without_defaults(voxelizer(&scene.voxelizer), &default));
    section("effect", without_defaults(effect(&scene.effect), &effect(&EffectSettings::default())));
    section("background", background(&scene.background));
    if scene.lights.is_empty() {
        document.insert("light", Item::Value(Value::Array(Array::new())));
    } else {
        document.insert("light", list(scene.lights.iter().map(light)));
    }
    document.insert("model", list(scene.models.iter().map(model)));
    document
}

/// A table that grows by one line at a time.
#[derive(Default)]
struct Lines(Table);

impl Lines {
    fn with(mut self, key: &str, value: impl Into<Value>) -> Self {
        self.0.insert(key, Item::Value(value.into()));
        self
    }

    fn with_some(self, key: &str, value: Option<impl Into<Value>>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }
}

/// The shortest decimal that reads back as this `f32`.
fn number(value: f32) -> Value {
    Value::from(value.to_string().parse::<f64>().unwrap_or(f64::from(value)))
}

fn vector(value: Vec3) -> Value {
    Value::Array(value.to_array().into_iter().map(number).collect())
}

fn path(value: &Path) -> String {
    value.to_string_lossy().replace('\\', "/")
}

fn list(tables: impl Iterator<Item = Table>) -> Item {
    Item::ArrayOfTables(tables.collect::<ArrayOfTables>())
}

fn without_defaults(mut table: Table, default: &Table) -> Table {
    table.retain(|key, item| default.get(key).map(ToString::to_string) != Some(item.to_string()));
    table
}

fn camera(scene: &Scene) -> Table {
    let camera = &scene.camera;
    let lines = Lines::default()
        .with("eye", vector(camera.eye))
        .with("target", vector(camera.target))
        .with("up", vector(camera.up))
        .with("fov_deg", number(camera.fov_deg));
    if scene.frame_camera { lines.with("frame", true).0 } else { lines.0 }
}

fn grid(grid: &GridSettings) -> Table {
    let cells = match grid.cells {
        Cells::Longest(cells) => Value::from(i64::from(cells)),
        Cells::Each(cells) => Value::Array(cells.to_array().into_iter().map(i64::from).collect()),
    };
    let lines = Lines::default().with("cells", cells);
    let region = |r: Region| Value::InlineTable([("min", vector(r.min)), ("max", vector(r.max))].into_iter().collect());
    lines
        .with("align", grid.align.word())
        .with("projection", grid.projection.word())
        .with_some("region", grid.region.map(region))
        .0
}

fn voxelizer(voxelizer: &VoxelizerSettings) -> Table {
    let separability = match voxelizer.separability {
        Separability::TwentySix => 26,
        Separability::Six => 6,
    };
    Lines::default()
        .with("method", voxelizer.method.as_str())
        .with("separability", separability)
        .with("conservative", voxelizer.conservative.word())
        .with("conservative_depth", voxelizer.conservative_depth)
        .with("slice_overlap", number(voxelizer.slice_overlap))
        .with("column_loop", voxelizer.column_loop.word())
        .with("three_axis_blending", voxelizer.three_axis_blending.word())
        .with("cutoff_cells2", voxelizer.cutoff_cells2.map_or_else(|| Value::from("auto"), number))
        .with("size_measure", voxelizer.size_measure.word())
        .with("classify", voxelizer.classify.word())
        .with("fill", voxelizer.fill.word())
        .0
}

fn effect(effect: &EffectSettings) -> Table {
    Lines::default()
        .with("refraction", effect.refraction.word())
        .with("hit", effect.hit.word())
        .with("angle_threshold_deg", number(effect.angle_threshold_deg))
        .with("max_events", i64::from(effect.max_events))
        .with("transmittance", effect.transmittance)
        .with("fill_questionable", effect.fill_questionable)
        .with("shadow", effect.shadow.word())
        .with("reflection", effect.reflection)
        .with("exposure", number(effect.exposure))
        .0
}

fn background(background: &Background) -> Table {
    match background {
        Background::Color { color } => Lines::default().with("kind", BACKGROUNDS[0]).with("color", vector(*color)),
        Background::Sky { horizon, zenith, ground, exponent, intensity } => Lines::default()
            .with("kind", BACKGROUNDS[1])
            .with("horizon", vector(*horizon))
            .with("zenith", vector(*zenith))
            .with("ground", vector(*ground))
            .with("exponent", number(*exponent))
            .with("intensity", number(*intensity)),
        Background::Checker { a, b, square, distance } => Lines::default()
            .with("kind", BACKGROUNDS[2])
            .with("a", vector(*a))
            .with("b", vector(*b))
            .with("square", number(*square))
            .with("distance", number(*distance)),
        Background::Environment { file, rotate_deg, intensity } => Lines::default()
            .with("kind", BACKGROUNDS[3])
            .with("file", path(file))
            .with("rotate_deg", number(*rotate_deg))
            .with("intensity", number(*intensity)),
    }
    .0
}

fn light(light: &Light) -> Table {
    let lines = match light.kind {
        LightKind::Directional { direction } => {
            Lines::default().with("kind", LIGHTS[0]).with("direction", vector(direction))
        }
        LightKind::Point { position } => Lines::default().with("kind", LIGHTS[1]).with("position", vector(position)),
        LightKind::Spot { position, direction, angle_deg, blend } => Lines::default()
            .with("kind", LIGHTS[2])
            .with("position", vector(position))
            .with("direction", vector(direction))
            .with("angle_deg", number(angle_deg))
            .with("blend", number(blend)),
    };
    lines
        .with("color", vector(light.color))
        .with("intensity", number(light.intensity))
        .with("angular_radius_deg", number(light.angular_radius_deg))
        .with_some("casts_shadow", (!light.casts_shadow).then_some(false))
        .0
}

fn model(model: &Model) -> Table {
    let default = Model::default();
    let lines = Lines::default().with("name", model.name.as_str());
    let mut table = source(lines, &model.source)
        .with_some("animation", model.animation.as_deref())
        .with_some("speed", (model.speed != default.speed).then(|| number(model.speed)))
        .with_some("variant", model.variant.as_deref())
        .with_some("translate", (model.translate != default.translate).then(|| vector(model.translate)))
        .with_some("rotate_deg", (model.rotate_deg != default.rotate_deg).then(|| vector(model.rotate_deg)))
        .with_some("scale", (model.scale != default.scale).then(|| number(model.scale)))
        .0;
    if !model.deformers.is_empty() {
        table.insert("deformer", list(model.deformers.iter().map(deformer)));
    }
    if !model.materials.is_empty() {
        table.insert("material", list(model.materials.iter().map(material)));
    }
    table
}

fn source(lines: Lines, source: &Source) -> Lines {
    let shape = match source {
        Source::File(file) => return lines.with("file", path(file)),
        Source::Csg(of) => return lines.with("csg", tree(of)),
        Source::Surface(from) => return surface(lines.with("shape", from.word()), from),
        Source::Shape(shape) => shape,
    };
    let lines = lines.with("shape", shape_name(shape));
    match *shape {
        Shape::Sphere { radius, rings } => lines.with("radius", number(radius)).with("rings", i64::from(rings)),
        Shape::Icosphere { radius, subdivisions } => {
            lines.with("radius", number(radius)).with("subdivisions", i64::from(subdivisions))
        }
        Shape::Torus { radius, tube, segments } => {
            lines.with("radius", number(radius)).with("tube", number(tube)).with("segments", i64::from(segments))
        }
        Shape::Box { min, max } => lines.with("min", vector(min)).with("max", vector(max)),
        Shape::Plane { size } => lines.with("size", number(size)),
    }
}

fn tree(of: &Tree) -> Value {
    match of {
        Tree::Model(name) => Value::from(name.as_str()),
        Tree::Node(operation, of) => {
            let operands = Value::Array(of.iter().map(tree).collect());
            Value::InlineTable([(operation.word(), operands)].into_iter().collect())
        }
    }
}

fn surface(lines: Lines, surface: &Surface) -> Lines {
    match surface {
        Surface::Parametric(Parametric { position: [x, y, z], ranges: [u, v], steps, wrap }) => lines
            .with("x", x.text())
            .with("y", y.text())
            .with("z", z.text())
            .with("u", range(u))
            .with("v", range(v))
            .with("steps", Value::Array(steps.iter().map(|n| i64::from(*n)).collect()))
            .with("wrap", Value::Array(wrap.iter().copied().collect())),
        Surface::Implicit(Implicit { expression, min, max, cells }) => lines
            .with("expression", expression.text())
            .with("min", vector(*min))
            .with("max", vector(*max))
            .with("cells", i64::from(*cells)),
    }
}

fn range(ends: &[Expression; 2]) -> Value {
    let end = |e: &Expression| e.text().parse::<f64>().map_or_else(|_| Value::from(e.text()), Value::from);
    Value::Array(ends.iter().map(end).collect())
}

fn deformer(deformer: &Deformer) -> Table {
    let axis = |index: u32| AXES.get(index as usize).copied().unwrap_or(AXES[1]);
    match *deformer {
        Deformer::Twist { axis: about, deg_per_unit, hz } => Lines::default()
            .with("kind", DEFORMERS[0])
            .with("axis", axis(about))
            .with("deg_per_unit", number(deg_per_unit))
            .with("hz", number(hz)),
        Deformer::Wave { axis: runs, along, amplitude, wavelength, hz } => Lines::default()
            .with("kind", DEFORMERS[1])
            .with("axis", axis(runs))
            .with("along", axis(along))
            .with("amplitude", number(amplitude))
            .with("wavelength", number(wavelength))
            .with("hz", number(hz)),
    }
    .0
}

fn material(material: &MaterialOverride) -> Table {
    Lines::default()
        .with("part", material.part.as_str())
        .with_some("ior", material.ior.map(number))
        .with_some("attenuation_color", material.attenuation_color.map(vector))
        .with_some("attenuation_distance", material.attenuation_distance.map(number))
        .with_some("sigma", material.sigma.map(vector))
        .with_some("opaque", material.opaque)
        .with_some("base_color", material.base_color.map(vector))
        .with_some("priority", material.priority.map(i64::from))
        .with_some("roughness", material.roughness.map(number))
        .with_some("dispersion", material.dispersion.map(number))
        .with_some("checker_color", material.checker_color.map(vector))
        .with_some("checker_square", material.checker_square.map(number))
        .with_some("emissive", material.emissive.map(vector))
        .0
}
