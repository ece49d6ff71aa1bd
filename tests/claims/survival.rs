//! What the window keeps when files go bad under it, or the device goes away.

use crate::gpu;
use glam::UVec2;
use murrine::app::loader::{self, Answer, Reason};
use murrine::app::notices::Severity;
use murrine::app::pictures::{Next, Pictures, Wish};
use murrine::app::session::Session;
use murrine::app::watch::{Change, Watcher};
use murrine::gpu::shader::ShaderLibrary;
use murrine::gpu::{AdapterChoice, Gpu, GpuError, buffer};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

const SIZE: UVec2 = UVec2::new(64, 48);
/// For what another thread does on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(60);

const BALL: &str = r#"
[camera]
eye = [0.0, 1.0, 4.0]
[grid]
cells = 24
[light_grid]
cells = 24
[[light]]
kind = "directional"
direction = [0.4, -1.0, -0.25]
[[model]]
shape = "icosphere"
subdivisions = 2
"#;

fn receive(session: &mut Session, path: &Path, reason: Reason) {
    let result = loader::load(Some(path), &[], None, &session.world);
    session.receive(Answer { number: 0, reason, path: Some(path.to_owned()), result });
}

fn has_error(session: &Session, text: &str) -> bool {
    session.notices.shown().iter().any(|n| n.severity == Severity::Error && n.text.contains(text))
}

/// The window's renderer on a device, and what its waiter tells.
struct Stage<'g> {
    gpu: &'g Gpu,
    pictures: Pictures,
    done: Receiver<Result<(), String>>,
}

impl<'g> Stage<'g> {
    fn new(gpu: &'g Gpu) -> Self {
        let (sender, done) = channel();
        let pictures = Pictures::new(gpu, move |result| drop(sender.send(result))).unwrap();
        Self { gpu, pictures, done }
    }

    /// The sharp picture.
    fn picture(&mut self, session: &Session) -> Result<Vec<[u8; 4]>, GpuError> {
        let wish = Wish { sharp: true, ..Wish::default() };
        while self.pictures.advance(self.gpu, session, SIZE, wish)? != Next::AtRest {
            self.done.recv_timeout(PATIENCE).unwrap().map_err(GpuError::Lost)?;
            self.pictures.finished(self.gpu);
        }
        buffer::read_texture(self.gpu, self.pictures.picture().unwrap())
    }
}

#[test]
fn a_lost_device_is_told_of_and_another_goes_on_with_every_edit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.toml");
    std::fs::write(&path, BALL).unwrap();
    let mut session = Session::default();
    receive(&mut session, &path, Reason::Open);
    let lost = Gpu::open(&AdapterChoice::Software).unwrap();
    lost.device.on_uncaptured_error(std::sync::Arc::new(|_| {}));
    let mut stage = Stage::new(&lost);
    let before = stage.picture(&session).unwrap();
    assert!(lost.check().is_ok());

    session.scene.effect.exposure = 0.25;
    session.observe_edits(false);
    lost.device.destroy();
    let told = stage.picture(&session);
    assert!(matches!(told, Err(GpuError::Lost(_))), "{told:?}");
    assert!(matches!(lost.check(), Err(GpuError::Lost(_))));

    let mut another = Stage::new(gpu());
    assert!(another.picture(&session).unwrap() != before && session.is_edited(), "the edit is lost");
    session.undo();
    assert!(another.picture(&session).unwrap() == before, "another device shows another picture");
}

#[test]
fn edits_are_rescued_when_the_program_has_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.toml");
    std::fs::write(&path, BALL).unwrap();
    let mut session = Session::default();
    receive(&mut session, &path, Reason::Open);
    assert_eq!(session.rescue(), None, "there is nothing to rescue");
    session.scene.effect.max_events = 3;
    let rescued = session.rescue().unwrap();
    assert_eq!(rescued, folder.path().join("ball-rescued.toml"));
    let mut again = Session::default();
    receive(&mut again, &rescued, Reason::Open);
    assert_eq!(again.scene, session.scene);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), BALL, "the scene's own file was touched");
}

/// A triangle with a picture on it, in three files.
fn write_model(folder: &Path) {
    let floats: [f32; 15] = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.5, 1.0];
    std::fs::write(folder.join("leaf.bin"), floats.map(f32::to_le_bytes).concat()).unwrap();
    write_texture(&folder.join("leaf.png"), 40);
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": "leaf.png"}],
        "buffers": [{"byteLength": 60, "uri": "leaf.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}]}"#;
    std::fs::write(folder.join("leaf.gltf"), gltf).unwrap();
}

fn write_texture(path: &Path, value: u8) {
    let picture = murrine::image::Picture { width: 2, height: 2, rgb8: vec![[value, 90, 30]; 4] };
    murrine::image::write_png(path, &picture).unwrap();
}

/// Watches what a session shows; what changed.
struct Watched {
    watcher: Watcher,
    changes: Receiver<Change>,
}

impl Watched {
    fn new() -> Self {
        let (sender, changes) = channel();
        // Nobody listens any more once the claim is made.
        let told = move |change| sender.send(change).unwrap_or_default();
        Self { watcher: Watcher::start(told).unwrap(), changes }
    }

    /// Changes a file and waits until the watcher tells, with all that it has to tell.
    fn change(&mut self, file: &Path, bytes: &[u8]) -> Change {
        while self.changes.try_recv().is_ok() {}
        std::fs::write(file, bytes).unwrap();
        let change =
            self.changes.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{} changed unseen", file.display()));
        while self.changes.recv_timeout(Duration::from_millis(300)).is_ok() {}
        change
    }
}

#[test]
fn the_scene_its_model_its_texture_and_its_environment_reload_and_keep_the_last_good_state() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| -> PathBuf { folder.path().canonicalize().unwrap().join(name) };
    write_model(folder.path());
    let sky: &[u8] = include_bytes!("../fuzz/corpus/environment/seed.hdr");
    std::fs::write(file("sky.hdr"), sky).unwrap();
    let scene =
        "[background]\nkind = \"environment\"\nfile = \"sky.hdr\"\n[[model]]\nname = \"leaf\"\nfile = \"leaf.gltf\"\n";
    std::fs::write(file("leaf.toml"), scene).unwrap();
    let mut session = Session::default();
    receive(&mut session, &file("leaf.toml"), Reason::Open);
    assert!(session.is_open && session.notices.shown().iter().all(|n| n.severity != Severity::Error));
    let mut watched = Watched::new();
    watched.watcher.watch_files(session.files()).unwrap();

    let good = |name: &str| std::fs::read(file(name)).unwrap();
    let brighter = {
        write_texture(&file("other.png"), 200);
        good("other.png")
    };
    let model = String::from_utf8(good("leaf.gltf")).unwrap();
    let moved = model.replace("{\"mesh\": 0}", "{\"mesh\": 0, \"translation\": [0, 3, 0]}").into_bytes();
    let mut darker_sky = sky.to_vec();
    *darker_sky.last_mut().unwrap() ^= 1;
    for (name, changed, broken) in [
        ("leaf.toml", format!("[effect]\nmax_events = 3\n{scene}").into_bytes(), b"[effect\n".to_vec()),
        ("leaf.gltf", moved, b"{\"asset\"".to_vec()),
        ("leaf.png", brighter, b"no picture".to_vec()),
        ("sky.hdr", darker_sky, b"no sky".to_vec()),
    ] {
        let (before, number) = (good(name), session.world_number);
        assert_eq!(watched.change(&file(name), &broken), Change::Scene);
        let scene_before = session.scene.clone();
        receive(&mut session, &file("leaf.toml"), Reason::Changed);
        let told = if name == "leaf.png" { "leaf.gltf: image 0" } else { name };
        assert!(has_error(&session, told), "{name}: {:?}", session.notices.shown());
        let state = (session.world_number, &session.scene);
        assert_eq!(state, (number, &scene_before), "{name} went bad, and the state too");

        assert_eq!(watched.change(&file(name), &changed), Change::Scene);
        receive(&mut session, &file("leaf.toml"), Reason::Changed);
        assert!(session.notices.shown().is_empty(), "{name} is mended: {:?}", session.notices.shown());
        assert!(session.world_number > number || session.scene != scene_before, "a changed {name} is not shown");
        assert_ne!(before, good(name), "the control changed nothing");
    }
    // A file that is not of the scene is not told of.
    std::fs::write(file("other.png"), b"x").unwrap();
    assert!(watched.changes.recv_timeout(Duration::from_millis(400)).is_err());
}

fn copy_shaders(to: &Path) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    for name in ShaderLibrary::Folder(from.clone()).names().unwrap() {
        std::fs::create_dir_all(to.join(&name).parent().unwrap()).unwrap();
        std::fs::copy(from.join(&name), to.join(&name)).unwrap();
    }
}

#[test]
fn a_shader_reloads_and_a_wrong_one_leaves_the_old_picture_with_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let shaders = folder.path().canonicalize().unwrap().join("shaders");
    copy_shaders(&shaders);
    let scene = folder.path().join("ball.toml");
    std::fs::write(&scene, BALL).unwrap();
    let mut session = Session::default();
    receive(&mut session, &scene, Reason::Open);
    let mut stage = Stage::new(gpu());
    let before = stage.picture(&session).unwrap();
    let mut watched = Watched::new();
    watched.watcher.watch_shaders(&shaders).unwrap();
    let library = ShaderLibrary::Folder(shaders.clone());
    let compile = || Pictures::compile(&gpu().with_shaders(library.clone()));

    let file = shaders.join("compose.wgsl");
    let text = std::fs::read_to_string(&file).unwrap();
    assert_eq!(watched.change(&file, text.replace("fn encode(", "fn encode(oops").as_bytes()), Change::Shader);
    let told = compile().unwrap_err().to_string();
    assert!(told.contains("compose.wgsl:"), "{told}");
    assert!(stage.picture(&session).unwrap() == before, "a wrong shader took the picture away");

    let darker = text.replace("compose_settings.exposure *", "0.25 * compose_settings.exposure *");
    assert_ne!(darker, text);
    assert_eq!(watched.change(&file, darker.as_bytes()), Change::Shader);
    stage.pictures.replace(compile().unwrap());
    assert!(stage.pictures.picture().is_some(), "the old picture is gone before there is a new one");
    assert!(stage.picture(&session).unwrap() != before, "a changed shader changes nothing");
    assert_eq!(watched.change(&shaders.join("lib/tone_map.inc.wgsl"), b"no shader"), Change::Shader);
    assert!(compile().is_err(), "a wrong include passes");
}
