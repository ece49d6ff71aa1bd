//! What must hold of everything that the readers accept, however odd. A breach panics; a refusal is told in words.

use super::mutate::ASSIGNMENT;
use murrine::scene::description::{Model, Scene, Shape};
use murrine::scene::geometry::Geometry;
use murrine::scene::{World, environment, file, gltf, pose, shapes, voxels};
use std::path::Path;
use std::sync::Arc;

/// A model is refused with one line, or is whole and can be posed; then tells what is notable about it.
pub(crate) fn model(bytes: &[u8]) -> Result<String, String> {
    loaded(gltf::parse(bytes, None, "model").map_err(|e| one_line(&e.to_string()))?)
}

/// Saved voxels are refused with one line, or are a model that is whole and can be posed.
pub(crate) fn voxels(bytes: &[u8]) -> Result<String, String> {
    loaded(voxels::parse(bytes, "voxels").map_err(|e| one_line(&e.to_string()))?)
}

fn loaded(loaded: gltf::Loaded) -> Result<String, String> {
    let notable: Vec<String> = loaded.warnings.iter().map(|w| one_line(&w.to_string())).collect();
    whole(&loaded.geometry);
    let scene = Scene { models: vec![Model::default()], ..Scene::default() };
    let vertices = loaded.geometry.vertices.len();
    let world = World::from_geometry(&scene, vec![Arc::new(loaded.geometry)]);
    assert_eq!(world.materials(&scene).len(), world.parts.len());
    assert!(world.duration_secs(&scene).is_finite());
    for time_secs in [0.0, 0.7, 1e7] {
        let pose = world.pose(&scene, time_secs);
        assert!(pose.matrices.iter().all(glam::Mat4::is_finite), "a matrix is not finite");
        assert_eq!(pose.part_bounds.len(), world.parts.len());
        assert!(!pose.part_bounds.iter().any(|b| b.min.is_nan() || b.max.is_nan()), "bounds are no numbers");
        if vertices < 10_000 {
            assert_eq!(pose::pose_vertices(&world, &scene, &pose).len(), vertices);
        }
    }
    Ok(notable.join(", "))
}

/// Every index of the model points at something.
fn whole(model: &Geometry) {
    let (vertices, triangles) = (model.vertices.len(), model.triangles.len());
    assert_eq!(model.influences.len(), vertices);
    assert_eq!(model.reaches.len(), model.parts.len());
    assert!(triangles > 0, "a model without triangles was accepted");
    let (mut vertex, mut triangle) = (0, 0);
    for part in &model.parts {
        assert_eq!((part.vertices.start, part.triangles.start), (vertex, triangle), "parts leave gaps");
        (vertex, triangle) = (part.vertices.end, part.triangles.end);
        let own = &model.triangles[part.triangles.start as usize..part.triangles.end as usize];
        assert!(own.iter().flatten().all(|v| part.vertices.contains(v)), "a triangle leaves its part");
        let morphs = part.morph_first as usize + part.vertices.len() * part.morph_count as usize;
        assert!(part.morph_count == 0 || morphs <= model.morphs.len(), "morphs are missing");
        assert!((part.node as usize) < model.nodes.len());
        for texture in [part.material.base_color_texture, part.material.emissive_texture].into_iter().flatten() {
            assert!((texture as usize) < model.textures.len());
        }
    }
    assert_eq!((vertex as usize, triangle as usize), (vertices, triangles));
    for v in &model.vertices {
        assert!(v.position.is_finite() && v.normal.is_finite() && v.u.is_finite() && v.v.is_finite());
    }
    for influence in &model.influences {
        assert!(influence.joints.iter().all(|&j| (j as usize) < model.matrices.len()), "a joint is missing");
        assert!((influence.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{influence:?}");
    }
    assert!(model.morphs.iter().all(|m| m.position.is_finite() && m.normal.is_finite()));
    for (i, node) in model.nodes.iter().enumerate() {
        assert!(node.parent.is_none_or(|p| (p as usize) < i), "a parent comes after its child");
        assert!(node.translation.is_finite() && node.rotation.is_normalized() && node.scale.is_finite());
    }
    for texture in &model.textures {
        assert_eq!(texture.rgba8.len(), texture.width as usize * texture.height as usize * 4);
    }
}

/// A scene is refused with one line, or reads the same when written, and can be posed; then tells what is notable.
/// Lines that start with `#set ` are assignments, made first, each refused with one line or not.
pub(crate) fn scene(bytes: &[u8]) -> Result<String, String> {
    let mut text = String::from_utf8_lossy(bytes).into_owned();
    let assignments: Vec<String> = text.lines().filter_map(|l| l.strip_prefix(ASSIGNMENT)).map(str::to_owned).collect();
    for assignment in assignments {
        text = file::set(&text, &assignment).map_err(|e| one_line(&e.to_string()))?;
    }
    let methods: Vec<&str> = murrine::voxelize::METHODS.iter().map(|m| m.name).collect();
    let path = Path::new("scene.toml");
    let (scene, warnings) = file::parse(&text, path, &methods).map_err(|e| one_line(&e.to_string()))?;
    let notable: Vec<String> = warnings.iter().map(|w| one_line(&w.to_string())).collect();
    let written = file::to_toml(&scene);
    let (again, _) =
        file::parse(&written, path, &methods).unwrap_or_else(|e| panic!("{e} in what was written: {written}"));
    assert_eq!(again, scene, "written and read again it is another scene:\n{written}");
    let ball = Arc::new(shapes::shape(&Shape::Icosphere { radius: 1.0, subdivisions: 0 }));
    let world = World::from_geometry(&scene, scene.models.iter().map(|_| Arc::clone(&ball)).collect());
    assert_eq!(world.materials(&scene).len(), world.parts.len());
    for time_secs in [0.0, 0.7, 1e7] {
        let pose = world.pose(&scene, time_secs);
        assert!(!pose.part_bounds.iter().any(|b| b.min.is_nan() || b.max.is_nan()), "bounds are no numbers");
    }
    Ok(notable.join(", "))
}

/// An environment is refused with one line, or is a picture of plain numbers.
pub(crate) fn environment(bytes: &[u8]) -> Result<String, String> {
    let map = environment::parse(bytes).map_err(|e| one_line(&e))?;
    assert_eq!(map.rgb.len(), map.width as usize * map.height as usize);
    assert!(map.rgb.iter().flatten().all(|x| (0.0..=65504.0).contains(x)));
    Ok(String::new())
}

fn one_line(message: &str) -> String {
    assert!(!message.contains('\n'), "a message of several lines: {message}");
    assert!(message.len() < 2000, "a message without end: {message}");
    message.to_owned()
}
