//! The scene format: which tables there are, what their keys mean and which values they take.

use super::paths;
use super::section::{FARTHEST, OneOrThree, Section, Text, unavailable, unknown};
use crate::scene::description::{
    ANGULAR_RADIUS_DEG, Align, Background, CELLS, Camera, Cells, Deformer, EffectSettings, GridSettings, Light,
    LightKind, MAX_LIGHTS, MAX_PLANES, MaterialOverride, Model, Projection, Region, Scene, Separability, Shape, Source,
    VoxelizerSettings,
};
use crate::scene::implicit::Implicit;
use crate::scene::parametric::Parametric;
use crate::scene::surface::Surface;
use crate::scene::{SceneError, Warning};
use glam::{UVec3, Vec3};
use std::path::Path;
use std::sync::Arc;

/// The most models in a scene.
const MAX_MODELS: usize = 256;
/// The most overrides or deformers of a model.
const MAX_PER_MODEL: usize = 64;

/// Reads the whole file.
pub(super) fn scene(
    text: Text<'_>,
    root: &toml_edit::Table,
    folder: &Path,
    methods: &[&str],
) -> Result<(Scene, Vec<Warning>), SceneError> {
    let mut warnings = Vec::new();
    let mut file = Section::new(text, root, "the file", None);
    let mut scene = Scene { folder: folder.to_path_buf(), ..Scene::default() };
    if let Some(section) = file.table("camera")? {
        (scene.camera, scene.frame_camera) = camera(section)?;
    }
    if let Some(section) = file.table("grid")? {
        scene.grid = grid(section)?;
    }
    if let Some(section) = file.table("light_grid")? {
        scene.light_grid = light_grid(section)?;
    }
    if let Some(section) = file.table("voxelizer")? {
        scene.voxelizer = voxelizer(section, methods)?;
    }
    if let Some(section) = file.table("effect")? {
        scene.effect = effect(section)?;
    }
    if let Some(section) = file.table("background")? {
        scene.background = background(section, folder)?;
    }
    scene.lights = match file.tables("light", "light", MAX_LIGHTS)? {
        Some(sections) => sections.into_iter().map(light).collect::<Result<_, _>>()?,
        None => vec![Light::default()],
    };
    let models = file.tables("model", "model", MAX_MODELS)?.unwrap_or_default();
    if models.is_empty() && !file.has("model") {
        // A misspelt table is the likelier fault.
        file.finish()?;
        return Err(text.error(&Some(0..0), "the scene has no model; add [[model]] with a `file` or a `shape`"));
    }
    for section in models {
        let model = model(section, folder, &scene.models, &mut warnings)?;
        scene.models.push(model);
    }
    if scene.models.is_empty() {
        return Err(file.error_at("model", "the list of models is empty; add [[model]] with a `file` or a `shape`"));
    }
    let planes = scene.models.iter().filter(|m| matches!(m.source, Source::Shape(Shape::Plane { .. }))).count();
    if planes > MAX_PLANES {
        return Err(file.error_at("model", format!("{planes} planes; at most {MAX_PLANES} are met exactly")));
    }
    file.finish()?;
    Ok((scene, warnings))
}

fn camera(mut from: Section<'_>) -> Result<(Camera, bool), SceneError> {
    let default = Camera::default();
    let camera = Camera {
        eye: from.vector("eye", -FARTHEST..=FARTHEST)?.unwrap_or(default.eye),
        target: from.vector("target", -FARTHEST..=FARTHEST)?.unwrap_or(default.target),
        up: from.direction("up")?.unwrap_or(default.up),
        fov_deg: from.number("fov_deg", 1.0..=170.0)?.unwrap_or(default.fov_deg),
    };
    let forward = camera.target - camera.eye;
    if forward.length() < 1e-6 {
        return Err(from.error_at("eye", "the camera's eye is its target; move one of them"));
    }
    if forward.normalize().cross(camera.up).length() < 1e-4 {
        return Err(from.error_at("up", "the camera looks along its `up`; turn one of them"));
    }
    let frame = from.flag("frame")?.unwrap_or(false);
    from.finish()?;
    Ok((camera, frame))
}

fn cells(from: &mut Section<'_>) -> Result<Cells, SceneError> {
    Ok(match from.one_or_three("cells", CELLS)? {
        Some(OneOrThree::One(longest)) => Cells::Longest(longest),
        Some(OneOrThree::Three(each)) => Cells::Each(UVec3::from_array(each)),
        None => GridSettings::default().cells,
    })
}

fn grid(mut from: Section<'_>) -> Result<GridSettings, SceneError> {
    let grid = GridSettings {
        cells: cells(&mut from)?,
        align: from.word("align")?.unwrap_or_default(),
        projection: from.word("projection")?.unwrap_or_default(),
        region: from.table("region")?.map(region).transpose()?,
    };
    if grid.align == Align::World && grid.projection == Projection::Perspective {
        let what = "a perspective grid can't be aligned with the world; write projection = \"orthographic\"";
        return Err(from.error_at("projection", what));
    }
    from.finish()?;
    Ok(grid)
}

fn region(mut from: Section<'_>) -> Result<Region, SceneError> {
    let (min, max) = corners(&mut from, 1.0)?;
    from.finish()?;
    Ok(Region { min, max })
}

fn light_grid(mut from: Section<'_>) -> Result<GridSettings, SceneError> {
    let cells = cells(&mut from)?;
    if from.word::<Align>("align")? == Some(Align::World) {
        return Err(from.error_at("align", "a light's grid is always turned to its light; leave `align` out"));
    }
    let projection = from.word("projection")?.unwrap_or_default();
    from.finish()?;
    Ok(GridSettings { cells, align: Align::Camera, projection, region: None })
}

fn voxelizer(mut from: Section<'_>, methods: &[&str]) -> Result<VoxelizerSettings, SceneError> {
    let default = VoxelizerSettings::default();
    let method = match from.string("method")? {
        None => default.method,
        Some(method) if methods.contains(&method) => method.to_owned(),
        Some(method) => return Err(from.error_at("method", unknown("voxelizer", method, methods))),
    };
    let separability = match from.whole("separability", 0..=i64::MAX)? {
        None | Some(26) => Separability::TwentySix,
        Some(6) => Separability::Six,
        Some(other) => return Err(from.error_at("separability", format!("separability is {other}; write 26 or 6"))),
    };
    let cutoff_cells2 = if from.is_string("cutoff_cells2") {
        match from.string("cutoff_cells2")? {
            Some(other) if other != "auto" => {
                let what = format!("cutoff_cells2 is `{other}`; write a number of voxels², or \"auto\"");
                return Err(from.error_at("cutoff_cells2", what));
            }
            _ => None,
        }
    } else {
        from.number("cutoff_cells2", 0.0..=FARTHEST)?
    };
    let voxelizer = VoxelizerSettings {
        method,
        separability,
        conservative: from.word("conservative")?.unwrap_or_default(),
        conservative_depth: from.flag("conservative_depth")?.unwrap_or_default(),
        slice_overlap: from.number("slice_overlap", 0.0..=1.0)?.unwrap_or(default.slice_overlap),
        column_loop: from.word("column_loop")?.unwrap_or_default(),
        three_axis_blending: from.word("three_axis_blending")?.unwrap_or_default(),
        cutoff_cells2,
        size_measure: from.word("size_measure")?.unwrap_or_default(),
        classify: from.word("classify")?.unwrap_or_default(),
        fill: from.word("fill")?.unwrap_or_default(),
    };
    from.finish()?;
    Ok(voxelizer)
}

fn effect(mut from: Section<'_>) -> Result<EffectSettings, SceneError> {
    let default = EffectSettings::default();
    if from.string("refraction")? == Some("image-space") {
        return Err(from.error_at("refraction", unavailable("refraction", "image-space")));
    }
    from.not_yet("caustics", &["false"])?;
    let effect = EffectSettings {
        refraction: from.word("refraction")?.unwrap_or_default(),
        hit: from.word("hit")?.unwrap_or_default(),
        angle_threshold_deg: from.number("angle_threshold_deg", 0.0..=180.0)?.unwrap_or(default.angle_threshold_deg),
        max_events: from.count("max_events", 1..=32)?.unwrap_or(default.max_events),
        transmittance: from.flag("transmittance")?.unwrap_or(default.transmittance),
        fill_questionable: from.flag("fill_questionable")?.unwrap_or(default.fill_questionable),
        shadow: from.word("shadow")?.unwrap_or_default(),
        reflection: from.flag("reflection")?.unwrap_or(default.reflection),
        exposure: from.number("exposure", 0.0..=1000.0)?.unwrap_or(default.exposure),
    };
    from.finish()?;
    Ok(effect)
}

/// The kinds of background, in the order of [`background`].
pub const BACKGROUNDS: &[&str] = &["color", "sky", "checker", "environment"];

fn background(mut from: Section<'_>, folder: &Path) -> Result<Background, SceneError> {
    let radiance = 0.0..=FARTHEST;
    let background = match from.one_of("kind", BACKGROUNDS)?.unwrap_or(1) {
        0 => Background::Color { color: from.vector("color", radiance)?.unwrap_or(Vec3::ZERO) },
        1 => {
            let mut sky = Background::default();
            if let Background::Sky { horizon, zenith, ground, exponent, intensity } = &mut sky {
                *horizon = from.vector("horizon", radiance.clone())?.unwrap_or(*horizon);
                *zenith = from.vector("zenith", radiance.clone())?.unwrap_or(*zenith);
                *ground = from.vector("ground", radiance.clone())?.unwrap_or(*ground);
                *exponent = from.number("exponent", 0.01..=100.0)?.unwrap_or(*exponent);
                *intensity = from.number("intensity", radiance)?.unwrap_or(*intensity);
            }
            sky
        }
        2 => Background::Checker {
            a: from.vector("a", radiance.clone())?.unwrap_or(Vec3::splat(0.8)),
            b: from.vector("b", radiance)?.unwrap_or(Vec3::splat(0.2)),
            square: from.positive("square", FARTHEST)?.unwrap_or(0.5),
            distance: from.positive("distance", FARTHEST)?.unwrap_or(5.0),
        },
        _ => {
            let Some(file) = from.string("file")? else {
                return Err(from.error("an environment needs a `file`, an .hdr or .exr picture"));
            };
            let file = paths::checked(folder, file, &["hdr", "exr"]).map_err(|what| from.error_at("file", what))?;
            Background::Environment {
                file,
                rotate_deg: from.number("rotate_deg", -3600.0..=3600.0)?.unwrap_or(0.0),
                intensity: from.number("intensity", radiance)?.unwrap_or(1.0),
            }
        }
    };
    from.finish()?;
    Ok(background)
}

/// The kinds of light, in the order of [`light`].
pub const LIGHTS: &[&str] = &["directional", "point", "spot"];

fn light(mut from: Section<'_>) -> Result<Light, SceneError> {
    let default = Light::default();
    let kind = from.one_of("kind", LIGHTS)?.unwrap_or(0);
    let kind = if kind == 0 {
        match from.direction("direction")? {
            Some(direction) => LightKind::Directional { direction },
            None => default.kind,
        }
    } else {
        let Some(position) = from.vector("position", -FARTHEST..=FARTHEST)? else {
            return Err(from.error(format!("a {} light needs a `position`", LIGHTS[kind])));
        };
        if kind == 1 {
            LightKind::Point { position }
        } else {
            LightKind::Spot {
                position,
                direction: from.direction("direction")?.unwrap_or(Vec3::NEG_Y),
                angle_deg: from.number("angle_deg", 0.1..=89.0)?.unwrap_or(30.0),
                blend: from.number("blend", 0.0..=1.0)?.unwrap_or(0.15),
            }
        }
    };
    let light = Light {
        kind,
        color: from.vector("color", 0.0..=FARTHEST)?.unwrap_or(default.color),
        intensity: from.number("intensity", 0.0..=FARTHEST)?.unwrap_or(default.intensity),
        angular_radius_deg: from
            .number("angular_radius_deg", ANGULAR_RADIUS_DEG)?
            .unwrap_or(default.angular_radius_deg),
        casts_shadow: from.flag("casts_shadow")?.unwrap_or(default.casts_shadow),
    };
    from.finish()?;
    Ok(light)
}

fn model(
    mut from: Section<'_>,
    folder: &Path,
    earlier: &[Model],
    warnings: &mut Vec<Warning>,
) -> Result<Model, SceneError> {
    let default = Model::default();
    let name = from.string("name")?;
    let source = source(&mut from, folder, warnings)?;
    let name = match name {
        Some(name) if earlier.iter().any(|m| m.name == name) => {
            return Err(from.error_at("name", format!("a model before this one is called `{name}` too; rename one")));
        }
        Some(name) => name.to_owned(),
        None => free_name(&source, earlier),
    };
    let model = Model {
        name,
        source,
        animation: from.string("animation")?.map(str::to_owned),
        speed: from.number("speed", -100.0..=100.0)?.unwrap_or(default.speed),
        variant: from.string("variant")?.map(str::to_owned),
        translate: from.vector("translate", -FARTHEST..=FARTHEST)?.unwrap_or(default.translate),
        rotate_deg: from.vector("rotate_deg", -3600.0..=3600.0)?.unwrap_or(default.rotate_deg),
        scale: from.positive("scale", FARTHEST)?.unwrap_or(default.scale),
        deformers: from
            .tables("deformer", "model.deformer", MAX_PER_MODEL)?
            .unwrap_or_default()
            .into_iter()
            .map(deformer)
            .collect::<Result<_, _>>()?,
        materials: from
            .tables("material", "model.material", MAX_PER_MODEL)?
            .unwrap_or_default()
            .into_iter()
            .map(|section| material(section, warnings))
            .collect::<Result<_, _>>()?,
    };
    from.finish()?;
    Ok(model)
}

/// The model's file or shape without its ending, numbered if it is taken.
fn free_name(source: &Source, earlier: &[Model]) -> String {
    let stem = match source {
        Source::File(file) => file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
        Source::Shape(shape) => shape_name(shape).to_owned(),
        Source::Surface(surface) => surface.word().to_owned(),
        Source::Csg(_) => "csg".to_owned(),
    };
    let taken = |name: &str| earlier.iter().any(|m| m.name == name);
    if !taken(&stem) {
        return stem;
    }
    (2..).map(|n| format!("{stem}-{n}")).find(|name| !taken(name)).unwrap_or(stem)
}

/// The built-in shapes, in the order of [`source`].
pub const SHAPES: &[&str] = &["sphere", "icosphere", "torus", "box", "plane", "parametric", "implicit"];

/// The word of a shape.
pub(super) fn shape_name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Icosphere { .. } => "icosphere",
        Shape::Torus { .. } => "torus",
        Shape::Box { .. } => "box",
        Shape::Plane { .. } => "plane",
    }
}

fn source(from: &mut Section<'_>, folder: &Path, warnings: &mut Vec<Warning>) -> Result<Source, SceneError> {
    if let Some(tree) = from.tree("csg")? {
        if from.has("file") || from.has("shape") {
            return Err(
                from.error_at("csg", "a model with `csg` is made of other models; leave `file` and `shape` out")
            );
        }
        return Ok(Source::Csg(tree));
    }
    let file = from.string("file")?;
    let shape = from.one_of("shape", SHAPES)?;
    let shape = match (file, shape) {
        (Some(_), Some(_)) => {
            return Err(from.error_at("shape", "a model has a `file` or a `shape`, not both; leave one out"));
        }
        (None, None) => {
            let what = format!("the model has neither `file` nor `shape`; write one (shapes: {})", SHAPES.join(", "));
            return Err(from.error(what));
        }
        (Some(file), None) => {
            let file =
                paths::checked(folder, file, &["glb", "gltf", "npz"]).map_err(|what| from.error_at("file", what))?;
            return Ok(Source::File(file));
        }
        (None, Some(shape)) => shape,
    };
    Ok(Source::Shape(match SHAPES[shape] {
        "parametric" => return Ok(Source::Surface(Arc::new(Surface::Parametric(parametric(from)?)))),
        "implicit" => return Ok(Source::Surface(Arc::new(Surface::Implicit(implicit(from)?)))),
        "sphere" => Shape::Sphere {
            radius: from.positive("radius", FARTHEST)?.unwrap_or(1.0),
            rings: from.count("rings", 3..=1024)?.unwrap_or(64),
        },
        "icosphere" => Shape::Icosphere {
            radius: from.positive("radius", FARTHEST)?.unwrap_or(1.0),
            subdivisions: from.count("subdivisions", 0..=9)?.unwrap_or(5),
        },
        "torus" => {
            let radius = from.positive("radius", FARTHEST)?.unwrap_or(1.0);
            let tube = from.positive("tube", FARTHEST)?.unwrap_or(0.35);
            if tube > radius {
                warnings.push(from.error_at("tube", "the tube is thicker than the ring: the torus meets itself"));
            }
            Shape::Torus { radius, tube, segments: from.count("segments", 3..=2048)?.unwrap_or(128) }
        }
        "box" => {
            let (min, max) = corners(from, 1.0)?;
            Shape::Box { min, max }
        }
        _ => Shape::Plane { size: from.positive("size", FARTHEST)?.unwrap_or(80.0) },
    }))
}

fn parametric(from: &mut Section<'_>) -> Result<Parametric, SceneError> {
    let mut position = Vec::with_capacity(3);
    for key in ["x", "y", "z"] {
        let Some(expression) = from.expression(key, Parametric::VARIABLES)? else {
            return Err(from.error(format!("a parametric shape needs `{key}`, an expression in u and v (and t)")));
        };
        position.push(expression);
    }
    let mut ranges = Vec::with_capacity(2);
    for key in ["u", "v"] {
        let Some(range) = from.range(key)? else {
            return Err(from.error(format!("a parametric shape needs `{key}`, its range, such as [0, \"2*pi\"]")));
        };
        ranges.push(range);
    }
    let (Ok(position), Ok(ranges)) = (position.try_into(), ranges.try_into()) else {
        return Err(from.error("a parametric shape needs x, y, z, u and v"));
    };
    Ok(Parametric {
        position,
        ranges,
        steps: from.two_counts("steps", Parametric::STEPS)?.unwrap_or([128, 64]),
        wrap: from.two_flags("wrap")?.unwrap_or([false; 2]),
    })
}

fn implicit(from: &mut Section<'_>) -> Result<Implicit, SceneError> {
    let Some(expression) = from.expression("expression", Implicit::VARIABLES)? else {
        return Err(from.error("an implicit shape needs an `expression` in x, y, z (and t), negative inside"));
    };
    let (min, max) = corners(from, 1.5)?;
    Ok(Implicit { expression, min, max, cells: from.count("cells", Implicit::CELLS)?.unwrap_or(64) })
}

/// `min` and `max` of a box; without them a cube of this half side.
fn corners(from: &mut Section<'_>, half: f32) -> Result<(Vec3, Vec3), SceneError> {
    let min = from.vector("min", -FARTHEST..=FARTHEST)?.unwrap_or(Vec3::splat(-half));
    let max = from.vector("max", -FARTHEST..=FARTHEST)?.unwrap_or(Vec3::splat(half));
    if min.cmplt(max).all() {
        Ok((min, max))
    } else {
        Err(from.error_at("max", "the box's `max` is not above its `min` in every axis; swap them"))
    }
}

/// The axes, as files name them.
pub(super) const AXES: &[&str] = &["x", "y", "z"];
/// The deformers, in the order of [`deformer`].
pub const DEFORMERS: &[&str] = &["twist", "wave"];

fn deformer(mut from: Section<'_>) -> Result<Deformer, SceneError> {
    let Some(kind) = from.one_of("kind", DEFORMERS)? else {
        return Err(from.error(format!("a deformer needs a `kind`; choose {}", DEFORMERS.join(", "))));
    };
    let axis = |from: &mut Section<'_>, key, default: &str| -> Result<u32, SceneError> {
        let index = from.one_of(key, AXES)?.or_else(|| AXES.iter().position(|a| *a == default));
        Ok(index.and_then(|i| u32::try_from(i).ok()).unwrap_or(0))
    };
    let deformer = if kind == 0 {
        Deformer::Twist {
            axis: axis(&mut from, "axis", "y")?,
            deg_per_unit: from.number("deg_per_unit", -3600.0..=3600.0)?.unwrap_or(45.0),
            hz: from.number("hz", 0.0..=100.0)?.unwrap_or(0.0),
        }
    } else {
        Deformer::Wave {
            axis: axis(&mut from, "axis", "x")?,
            along: axis(&mut from, "along", "y")?,
            amplitude: from.number("amplitude", 0.0..=FARTHEST)?.unwrap_or(0.1),
            wavelength: from.positive("wavelength", FARTHEST)?.unwrap_or(1.0),
            hz: from.number("hz", -100.0..=100.0)?.unwrap_or(0.0),
        }
    };
    from.finish()?;
    Ok(deformer)
}

fn material(mut from: Section<'_>, warnings: &mut Vec<Warning>) -> Result<MaterialOverride, SceneError> {
    let priority = from.whole("priority", -1000..=1000)?.and_then(|p| i32::try_from(p).ok());
    let material = MaterialOverride {
        part: from.string("part")?.unwrap_or("*").to_owned(),
        ior: from.number("ior", 0.1..=10.0)?,
        attenuation_color: from.vector("attenuation_color", 0.0..=1.0)?,
        attenuation_distance: from.positive("attenuation_distance", FARTHEST)?,
        sigma: from.vector("sigma", 0.0..=FARTHEST)?,
        opaque: from.flag("opaque")?,
        base_color: from.vector("base_color", 0.0..=1.0)?,
        priority,
        roughness: from.number("roughness", 0.0..=1.0)?,
        dispersion: from.number("dispersion", 0.0..=100.0)?,
        checker_color: from.vector("checker_color", 0.0..=1.0)?,
        checker_square: from.number("checker_square", 0.0..=FARTHEST)?,
        emissive: from.vector("emissive", 0.0..=FARTHEST)?,
    };
    if material.sigma.is_some() && (material.attenuation_color.is_some() || material.attenuation_distance.is_some()) {
        warnings.push(from.error_at("sigma", "`sigma` wins over attenuation_color and attenuation_distance"));
    }
    if material.attenuation_color.is_some() && material.attenuation_distance.is_none() && material.sigma.is_none() {
        let what = "attenuation_color needs an attenuation_distance, unless the model's file gives one";
        warnings.push(from.error_at("attenuation_color", what));
    }
    from.finish()?;
    Ok(material)
}
