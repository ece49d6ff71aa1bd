//! What several claims need: a frame of a scene, read back.

use crate::gpu;
use glam::{DVec3, UVec2, Vec3};
use murrine::compose::DebugView;
use murrine::frame::{Frame, Request};
use murrine::gpu::{Timing, buffer};
use murrine::march::Channel;
use murrine::scene::description::{Background, MaterialOverride, Model, Shape, Source, VoxelizerSettings};
use murrine::scene::{Scene, World};

/// Says what a claim leaves out and why, past the test program's capture: a claim that holds less than it could must be
/// seen to.
pub(crate) fn left_out(what: &str, why: &str) {
    use std::io::Write;
    // Where nobody listens there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "left out: {what}: {why}");
}

/// Two pictures of a frame, row by row from the top.
pub(crate) struct Rendered {
    pub size: UVec2,
    pub radiance: Vec<[f32; 4]>,
    pub channel: Vec<[f32; 4]>,
}

impl Rendered {
    /// The channel's first three numbers.
    pub(crate) fn channel_at(&self, x: u32, y: u32) -> DVec3 {
        let [a, b, c, _] = self.channel[(y * self.size.x + x) as usize];
        Vec3::new(a, b, c).as_dvec3()
    }
}

/// Renders a still scene until every record has room.
pub(crate) fn render(scene: &Scene, size: UVec2, channel: Channel) -> Rendered {
    let world = World::load(scene, None).unwrap();
    let mut frame = Frame::new(gpu()).unwrap();
    render_with(&mut frame, scene, &world, size, channel)
}

/// As [`render`], with a frame to use again.
pub(crate) fn render_with(frame: &mut Frame, scene: &Scene, world: &World, size: UVec2, channel: Channel) -> Rendered {
    let view = DebugView::None;
    let request =
        Request { scene, world, time_secs: 0.0, size, picture_size: size, channel, view, timing: Timing::Off };
    for _ in 0..4 {
        frame.render(gpu(), &request).unwrap();
        if frame.settle(gpu()).unwrap() {
            break;
        }
    }
    Rendered {
        size,
        radiance: buffer::read_texture(gpu(), &frame.radiance().radiance).unwrap(),
        channel: buffer::read_texture(gpu(), &frame.radiance().channel).unwrap(),
    }
}

/// A scene of these models, black around, without lights.
pub(crate) fn scene_of(models: Vec<Model>) -> Scene {
    Scene {
        models,
        background: Background::Color { color: Vec3::ZERO },
        voxelizer: VoxelizerSettings { method: "triangle-parallel".to_owned(), ..VoxelizerSettings::default() },
        ..Scene::default()
    }
}

/// A model of one shape of one glass.
pub(crate) fn glass(name: &str, shape: Shape, ior: f32, sigma: Vec3) -> Model {
    Model {
        name: name.to_owned(),
        source: Source::Shape(shape),
        materials: vec![MaterialOverride { ior: Some(ior), sigma: Some(sigma), ..MaterialOverride::default() }],
        ..Model::default()
    }
}

/// Unit direction of the ray through the middle of a pixel of a camera that looks along −z, y up.
pub(crate) fn pixel_direction(size: UVec2, fov_deg: f64, x: u32, y: u32) -> DVec3 {
    let tan = (fov_deg.to_radians() * 0.5).tan();
    let [w, h] = [f64::from(size.x), f64::from(size.y)];
    let u = ((f64::from(x) + 0.5) / w * 2.0 - 1.0) * tan * w / h;
    let v = (1.0 - (f64::from(y) + 0.5) / h * 2.0) * tan;
    DVec3::new(u, v, -1.0).normalize()
}

/// The value below which a share of the numbers lies.
pub(crate) fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    let index = ((values.len() - 1) as f64 * share).round() as usize;
    values[index]
}
