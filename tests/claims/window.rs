//! The window: its parts that need no display, and a real one on a display of its own.

use egui::{Key, Modifiers};
use glam::{DVec3, UVec2, Vec2, Vec3};
use murrine::app::actions::{self, ACTIONS, ActionId, CLICKER_KEYS, Group};
use murrine::app::history::History;
use murrine::app::notices::{Notices, Severity, Topic};
use murrine::app::painter::{Painted, without_texture};
use murrine::app::panels::{self, Chrome, Leaving, Stage};
use murrine::app::parts::{PART_MS, Parts};
use murrine::app::pictures::Measured;
use murrine::app::resolution::{GOOD_SCALE, Resolution, SLOWEST_MS, SMOOTH_MS, STEPS};
use murrine::app::session::{Session, neighbour};
use murrine::app::timeline::Timeline;
use murrine::app::{fallback, loader, orbit};
use murrine::gpu::{Recorder, Timing};
use murrine::march::take_rows;
use murrine::scene::description::{Bounds, Camera, LightKind};
use murrine::scene::{Scene, World};
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const CTRL: Modifiers = Modifiers { command: true, ctrl: true, ..Modifiers::NONE };
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..CTRL };

#[test]
fn no_key_means_two_actions() {
    for (i, a) in ACTIONS.iter().enumerate() {
        for b in &ACTIONS[i + 1..] {
            for (x, y) in a.keys.iter().flat_map(|x| b.keys.iter().map(move |y| (x, y))) {
                assert!(!x.collides(y), "{} means both \"{}\" and \"{}\"", x.text(), a.name, b.name);
            }
        }
    }
    let undo = actions::action_of(ActionId::Undo).unwrap();
    assert!(undo.keys[0].collides(&undo.keys[0]), "a key collides with itself");
}

#[test]
fn every_action_has_a_key_and_a_line_in_the_help() {
    let lines: Vec<_> = Group::ALL.iter().flat_map(|(group, _)| actions::help_lines(*group)).collect();
    assert_eq!(lines.len(), ACTIONS.len());
    for action in ACTIONS {
        assert!(!action.keys.is_empty(), "\"{}\" has no key", action.name);
        let line = lines.iter().find(|l| l.name == action.name).unwrap();
        for key in action.keys {
            assert!(line.keys.contains(&key.text()), "the help of \"{}\" lacks {}", action.name, key.text());
        }
    }
}

#[test]
fn the_keys_that_users_bring_with_them_do_what_they_expect() {
    let shift = Modifiers { shift: true, ..Modifiers::NONE };
    for (key, modifiers, action) in [
        (Key::Space, Modifiers::NONE, ActionId::PlayPause),
        (Key::Period, Modifiers::NONE, ActionId::FrameAll),
        (Key::H, Modifiers::NONE, ActionId::Help),
        (Key::Questionmark, shift, ActionId::Help),
        (Key::F11, Modifiers::NONE, ActionId::FullScreen),
        (Key::F12, Modifiers::NONE, ActionId::Screenshot),
        (Key::Tab, Modifiers::NONE, ActionId::Panels),
        (Key::Z, CTRL, ActionId::Undo),
        (Key::Z, CTRL_SHIFT, ActionId::Redo),
        (Key::S, CTRL, ActionId::Save),
    ] {
        assert_eq!(actions::of_key(key, modifiers), Some(action), "{key:?}");
    }
    assert_eq!(actions::of_key(Key::Z, Modifiers::NONE), None, "a bare z undoes nothing");
    for key in CLICKER_KEYS {
        assert!(actions::of_key(*key, Modifiers::NONE).is_some(), "a clicker's {key:?} does nothing");
    }
}

#[test]
fn orbiting_keeps_the_distance_and_never_passes_a_pole() {
    let mut camera = Camera { eye: Vec3::new(3.0, 1.0, 2.0), target: Vec3::new(0.5, 0.5, 0.0), ..Camera::default() };
    let distance = (camera.eye - camera.target).length();
    for step in 0..400 {
        orbit::orbit(&mut camera, 0.07, if step < 200 { 0.5 } else { -0.5 });
        let back = camera.eye - camera.target;
        assert!((back.length() - distance).abs() < 1e-3 * distance, "the distance is {}", back.length());
        assert!(back.angle_between(camera.up) > 0.01 && back.angle_between(-camera.up) > 0.01, "at a pole");
    }
    let before = camera;
    orbit::orbit(&mut camera, 0.3, 0.0);
    assert_ne!(camera, before, "an orbit moves the eye");
}

#[test]
fn a_turn_there_and_back_ends_where_it_began() {
    let mut camera = Camera { eye: Vec3::new(1.0, 2.0, 4.0), ..Camera::default() };
    let before = camera;
    orbit::orbit(&mut camera, 0.9, 0.0);
    orbit::orbit(&mut camera, -0.9, 0.0);
    assert!((camera.eye - before.eye).length() < 1e-5);
    orbit::pan(&mut camera, Vec2::new(0.2, -0.1));
    assert!((camera.target - before.target).length() > 0.1, "a pan moves the target");
    orbit::pan(&mut camera, Vec2::new(-0.2, 0.1));
    assert!((camera.eye - before.eye).length() < 1e-5);
}

#[test]
fn a_pan_by_the_pictures_height_moves_what_is_looked_at_by_it() {
    let mut camera = Camera::default();
    orbit::pan(&mut camera, Vec2::new(0.0, 1.0));
    let height = 2.0 * 5.0 * 15f32.to_radians().tan();
    assert!((camera.target.y - height).abs() < 1e-5, "dragging down lifts the camera: {}", camera.target);
}

#[test]
fn no_camera_breaks_the_controls() {
    for eye in [Vec3::ZERO, Vec3::Y * 5.0, Vec3::NAN, Vec3::splat(1e30)] {
        let mut camera = Camera { eye, ..Camera::default() };
        orbit::orbit(&mut camera, 0.1, 0.1);
        orbit::pan(&mut camera, Vec2::new(0.1, 0.1));
        orbit::zoom(&mut camera, 0.5);
        orbit::zoom(&mut camera, f32::NAN);
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        orbit::frame(&mut camera, &bounds, 0.0);
        assert!(camera.eye.is_finite() && camera.target.is_finite(), "{eye} became {camera:?}");
    }
}

#[test]
fn framing_shows_the_body_whole_in_wide_and_narrow_pictures() {
    let bounds = Bounds { min: DVec3::new(-4.0, 0.0, -1.0), max: DVec3::new(6.0, 2.0, 1.0) };
    for aspect in [0.3, 1.0, 2.0f32] {
        let mut camera = Camera { eye: Vec3::new(2.0, 3.0, 4.0), ..Camera::default() };
        orbit::frame(&mut camera, &bounds, aspect);
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let tan = (camera.fov_deg.to_radians() * 0.5).tan();
        for corner in bounds.corners() {
            let p = corner.as_vec3() - camera.eye;
            let (x, y) = (p.dot(right) / p.dot(forward), p.dot(right.cross(forward)) / p.dot(forward));
            assert!(y.abs() <= tan && x.abs() <= tan * aspect, "aspect {aspect}: {corner} is outside");
        }
    }
}

fn scene_with_exposure(exposure: f32) -> Scene {
    let mut scene = fallback::scene();
    scene.effect.exposure = exposure;
    scene
}

#[test]
fn a_drag_is_one_edit_that_can_be_taken_back_and_made_again() {
    let mut scene = scene_with_exposure(1.0);
    let mut world = World::default();
    let mut history = History::new(&scene, &world);
    for exposure in [1.1, 1.2, 1.3] {
        scene.effect.exposure = exposure;
        history.observe(&scene, &world, true);
    }
    history.observe(&scene, &world, false);
    scene.effect.max_events = 2;
    history.observe(&scene, &world, false);
    assert!(history.undo(&mut scene, &mut world));
    assert_eq!((scene.effect.exposure, scene.effect.max_events), (1.3, 8));
    assert!(history.undo(&mut scene, &mut world));
    assert_eq!(scene.effect.exposure, 1.0, "the whole drag is taken back");
    assert!(!history.undo(&mut scene, &mut world), "there is nothing more to take back");
    assert!(history.redo(&mut scene, &mut world) && history.redo(&mut scene, &mut world));
    assert_eq!((scene.effect.exposure, scene.effect.max_events), (1.3, 2));
    assert!(!history.redo(&mut scene, &mut world));
}

#[test]
fn a_camera_move_is_no_edit_and_survives_undo() {
    let mut scene = scene_with_exposure(1.0);
    let mut world = World::default();
    let mut history = History::new(&scene, &world);
    scene.camera.eye = Vec3::new(9.0, 9.0, 9.0);
    history.observe(&scene, &world, false);
    assert!(!history.can_undo(), "moving the camera made an edit");
    scene.effect.exposure = 2.0;
    history.observe(&scene, &world, false);
    assert!(history.undo(&mut scene, &mut world));
    assert_eq!((scene.effect.exposure, scene.camera.eye), (1.0, Vec3::new(9.0, 9.0, 9.0)));
}

#[test]
fn an_edit_after_an_undo_forgets_what_was_undone() {
    let mut scene = scene_with_exposure(1.0);
    let mut world = World::default();
    let mut history = History::new(&scene, &world);
    scene.effect.exposure = 2.0;
    history.observe(&scene, &world, false);
    history.undo(&mut scene, &mut world);
    scene.effect.exposure = 3.0;
    history.observe(&scene, &world, false);
    assert!(!history.redo(&mut scene, &mut world));
    assert_eq!(scene.effect.exposure, 3.0);
}

/// Runs the controller against an adapter that takes `fixed + per_pixel · pixels`; returns the last 50 frames' steps
/// and times.
fn held(fixed_ms: f64, per_pixel_ms: f64, full: UVec2) -> Vec<(f32, f64)> {
    let mut resolution = Resolution::default();
    let mut seen = Vec::new();
    for frame in 0..200u32 {
        let size = resolution.moving_size(full);
        let noise = 1.0 + 0.1 * (f64::from(frame * 7919 % 13) / 6.0 - 1.0);
        let ms = (fixed_ms + per_pixel_ms * f64::from(size.x * size.y)) * noise;
        resolution.measured(full, size, ms);
        seen.push((resolution.scale(), ms));
    }
    seen.split_off(150)
}

#[test]
fn the_resolution_holds_the_frame_time_without_hunting() {
    let full = UVec2::new(960, 760);
    let slow = held(14.0, 60.0 / 256.0 / 256.0, full);
    assert!(slow.iter().all(|(_, ms)| *ms < 1.25 * SLOWEST_MS), "a moving frame takes too long: {slow:?}");
    assert!(slow.iter().any(|(_, ms)| *ms > 0.6 * SLOWEST_MS), "the picture is coarser than need be: {slow:?}");
    let scales: std::collections::BTreeSet<u32> = slow.iter().map(|(s, _)| s.to_bits()).collect();
    assert!(scales.len() <= 2, "it hunts between {} sizes", scales.len());
    assert!(held(1.0, 1e-6, full).iter().all(|(s, _)| *s == 1.0), "a fast adapter is not used whole");
}

#[test]
fn a_picture_is_made_good_before_it_is_made_smooth_and_smooth_before_it_is_made_fine() {
    let full = UVec2::new(960, 760);
    let mut last = 0.0;
    for per_pixel_ms in [2e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5, 2e-5] {
        let seen = held(10.0, per_pixel_ms, full);
        let scale = seen.iter().map(|(s, _)| *s).fold(0.0, f32::max);
        let longest = seen.iter().map(|(_, ms)| *ms).fold(0.0, f64::max);
        assert!(longest < 1.25 * if scale > GOOD_SCALE { SMOOTH_MS } else { SLOWEST_MS }, "{scale} takes {longest} ms");
        assert!(scale >= last, "a faster adapter gives a coarser picture");
        last = scale;
    }
    assert_eq!(last, 1.0);
    assert!(
        held(10.0, 3e-4, full).iter().all(|(s, _)| *s == GOOD_SCALE),
        "the good step is where time is given for it"
    );
}

#[test]
fn an_input_waits_for_one_part_of_the_sharp_picture_and_not_for_all_of_it() {
    let size = UVec2::new(1124, 763);
    // Rows in the middle, where the glass is, take ten times as long as those of the sky.
    let ms_of = |row: u32| if (200..500).contains(&row) { 3.0 } else { 0.3 };
    for expected_ms in [0.0, 100.0, 1000.0, 2000.0] {
        let mut parts = Parts::of(size, expected_ms);
        let (mut left, mut longest, mut count, mut sum) = (0..size.y, 0.0f64, 0, 0.0);
        while !left.is_empty() {
            let ms: f64 = take_rows(&mut left, parts.rows()).map(ms_of).sum();
            parts.measured(ms);
            longest = longest.max(ms);
            count += 1;
            sum += ms;
        }
        assert!((parts.spent_ms() - sum).abs() < 1e-6);
        assert!(count > 10 && count < 120, "{count} parts, expecting {expected_ms} ms");
        // Where nothing is known, or little, the first step into the glass may take longer.
        let most = if expected_ms < 500.0 { 10.0 } else { 2.0 };
        assert!(longest < most * PART_MS, "{longest} ms, expecting {expected_ms} ms");
    }
    // Where every part takes long, whatever it has to do, smaller ones would not help.
    let (mut parts, mut left, mut count) = (Parts::of(size, 9e3), 0..size.y, 0);
    while !left.is_empty() {
        parts.measured(60.0 + take_rows(&mut left, parts.rows()).map(ms_of).sum::<f64>());
        count += 1;
    }
    assert!((16..=48).contains(&count), "{count} parts");
    assert!(Parts::of(size, 0.9 * PART_MS).rows() >= size.y, "a short frame is cut in pieces");
}

#[test]
fn a_fixed_part_that_is_too_long_does_not_drive_the_picture_to_nothing() {
    let full = UVec2::new(960, 760);
    let mean = held(120.0, 30.0 / 256.0 / 256.0, full).iter().map(|(s, _)| f64::from(*s)).sum::<f64>() / 50.0;
    assert!(mean >= 0.3, "the side is down to {mean}, which gains next to nothing");
}

#[test]
fn no_size_is_nothing_and_none_is_larger_than_the_window() {
    for full in [UVec2::ZERO, UVec2::ONE, UVec2::new(1, 2000), UVec2::new(50, 3), UVec2::new(4000, 3000)] {
        let mut resolution = Resolution::default();
        for ms in [500.0, 0.0, f64::NAN, 1e9, 1.0] {
            let size = resolution.moving_size(full);
            assert!(size.min_element() >= 1 && size.cmple(full.max(UVec2::ONE)).all(), "{full} became {size}");
            resolution.measured(full, size, ms);
            assert!(STEPS.contains(&resolution.scale()));
        }
    }
}

#[test]
fn time_plays_loops_and_stays_within_its_bounds() {
    let mut timeline = Timeline { playing: true, duration_secs: 2.0, ..Timeline::default() };
    timeline.advance(0.2);
    timeline.advance(1e6);
    assert!(timeline.time_secs < 1.0, "a stall made the picture jump by {} s", timeline.time_secs);
    timeline.time_secs = 4.5;
    assert_eq!(timeline.phase_secs(), 0.5);
    timeline.step(-100.0);
    assert_eq!((timeline.time_secs, timeline.playing), (0.0, false));
    timeline.advance(0.1);
    assert_eq!(timeline.time_secs, 0.0, "paused time stands still");
    let still = Timeline { playing: true, ..Timeline::default() };
    assert!(!still.is_running(), "a scene in which nothing moves is never rendered twice");
}

#[test]
fn a_notice_is_shown_once_until_it_changes() {
    let mut notices = Notices::default();
    let warn = |notices: &mut Notices, text: &str| {
        notices.set(Topic::FrameWarnings, Severity::Warning, [text.to_owned(), text.to_owned()]);
    };
    warn(&mut notices, "odd");
    warn(&mut notices, "odd");
    assert_eq!(notices.shown().len(), 1);
    notices.dismiss(0);
    warn(&mut notices, "odd");
    assert!(notices.shown().is_empty(), "a dismissed warning came back");
    warn(&mut notices, "odder");
    assert_eq!(notices.shown().len(), 1);
    notices.clear(Topic::FrameWarnings);
    warn(&mut notices, "odd");
    assert_eq!(notices.shown().len(), 1, "one that was mended and broke again is news");
}

fn opened(path: Option<&std::path::Path>, reason: loader::Reason, session: &mut Session) {
    let result = loader::load(path, &[], None, &session.world);
    let path = path.map(ToOwned::to_owned);
    session.receive(loader::Answer { number: 0, reason, path, result });
}

#[test]
fn a_bad_file_keeps_the_last_good_scene_and_tells() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.toml");
    std::fs::write(&path, "[camera]\nfov = 3\n").unwrap();
    let mut session = Session::default();
    opened(None, loader::Reason::Open, &mut session);
    let before = session.scene.clone();
    opened(Some(&path), loader::Reason::Open, &mut session);
    assert_eq!(session.scene, before);
    let told = &session.notices.shown()[0];
    assert_eq!(told.severity, Severity::Error);
    assert!(told.text.contains("bad.toml:2:"), "{}", told.text);
    std::fs::write(&path, "[[model]]\nshape = \"icosphere\"\n").unwrap();
    opened(Some(&path), loader::Reason::Open, &mut session);
    assert!(session.notices.shown().is_empty(), "a mended file still shows its error");
    assert_eq!(session.path.as_deref(), Some(path.as_path()));
}

#[test]
fn a_dropped_environment_lights_the_scene_and_a_broken_one_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (good, bad) = (folder.path().join("sky.hdr"), folder.path().join("bad.hdr"));
    std::fs::write(&good, include_bytes!("../fuzz/corpus/environment/seed.hdr")).unwrap();
    std::fs::write(&bad, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4").unwrap();
    let mut session = Session::default();
    opened(None, loader::Reason::Open, &mut session);
    let before = session.scene.clone();
    let drop = |file: &std::path::Path, session: &mut Session| {
        let background = Some(session.surrounded_by(file));
        let result = loader::load(None, &[], background, &session.world);
        session.receive(loader::Answer { number: 0, reason: loader::Reason::Background, path: None, result });
        session.observe_edits(false);
    };
    drop(&bad, &mut session);
    assert_eq!(session.scene, before, "a broken picture changed the scene");
    assert!(session.notices.shown()[0].text.contains("bad.hdr"), "{}", session.notices.shown()[0].text);
    drop(&good, &mut session);
    assert!(session.world.environment.is_some() && session.is_edited() && session.notices.shown().is_empty());
    opened(None, loader::Reason::Changed, &mut session);
    assert!(session.world.environment.is_some(), "a reload of the file's models took the dropped picture away");
    session.undo();
    assert!(session.world.environment.is_none() && session.scene == before);
}

#[test]
fn edits_that_would_be_lost_are_asked_after() {
    let mut session = Session::default();
    opened(None, loader::Reason::Open, &mut session);
    let mut chrome = Chrome { leaving: Some(Leaving::Open("fox.glb".into())), ..Chrome::default() };
    let mut said = |label: &str, session: &mut Session| click(label, session, &mut chrome);
    assert_eq!(said("Save", &mut session), [panels::Command::SaveAndLeave]);
    assert_eq!(said("Discard", &mut session), [panels::Command::Leave]);
    assert_eq!(said("Cancel", &mut session), [panels::Command::Stay]);
    chrome.leaving = None;
    assert_eq!(click("Discard", &mut session, &mut chrome), [], "it asks without need");
}

#[test]
fn a_saved_scene_is_whole_and_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("saved.toml");
    let mut session = Session::default();
    opened(None, loader::Reason::Open, &mut session);
    session.scene.effect.exposure = 1.75;
    assert!(session.is_edited());
    session.save(&path);
    assert!(!session.is_edited());
    let entries = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(entries, 1, "a temporary file was left behind");
    let saved = loader::load(Some(&path), &[], None, &World::default()).unwrap();
    assert_eq!(saved.scene.effect, session.scene.effect);
    assert_eq!(saved.scene.models, session.scene.models);
    session.save(&folder.path().join("no such folder/x.toml"));
    assert_eq!(session.notices.shown().last().unwrap().severity, Severity::Error);
    assert_eq!(session.path.as_deref(), Some(path.as_path()), "a failed save changed the file");
}

#[test]
fn a_reload_takes_the_file_and_leaves_a_moved_camera() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = |exposure: f32| format!("[effect]\nexposure = {exposure:?}\n[[model]]\nshape = \"icosphere\"\n");
    std::fs::write(&path, text(1.0)).unwrap();
    let mut session = Session::default();
    opened(Some(&path), loader::Reason::Open, &mut session);
    session.scene.camera.eye = Vec3::new(1.0, 2.0, 3.0);
    session.scene.effect.max_events = 3;
    opened(Some(&path), loader::Reason::Changed, &mut session);
    assert_eq!(session.scene.effect.max_events, 3, "a file that says the same as before took an edit away");
    std::fs::write(&path, text(2.0)).unwrap();
    opened(Some(&path), loader::Reason::Changed, &mut session);
    assert_eq!((session.scene.effect.exposure, session.scene.effect.max_events), (2.0, 8));
    assert_eq!(session.scene.camera.eye, Vec3::new(1.0, 2.0, 3.0));
    session.undo();
    assert_eq!(session.scene.effect.max_events, 3, "a reload can be taken back");
}

#[test]
fn the_scenes_of_a_folder_follow_each_other_round_and_round() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.toml", "b.toml", "c.toml", "fox.glb", "notes.txt"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let next = |name: &str, by| neighbour(&folder.path().join(name), by).unwrap();
    assert_eq!(next("a.toml", 1), folder.path().join("b.toml"));
    assert_eq!(next("c.toml", 1), folder.path().join("a.toml"));
    assert_eq!(next("a.toml", -1), folder.path().join("c.toml"));
    assert_eq!(next("fox.glb", 1), folder.path().join("fox.glb"), "models follow models");
}

/// One painting of the panels: what they ask for, and every text with its place.
fn run_panels(
    context: &egui::Context,
    session: &mut Session,
    chrome: &mut Chrome,
    events: Vec<egui::Event>,
) -> (Vec<panels::Command>, Vec<(String, egui::Pos2)>) {
    let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1400.0, 3000.0));
    let input = egui::RawInput { screen_rect: Some(rect), events, ..Default::default() };
    let measured = &Measured::default();
    let mut stage = Stage { session, chrome, measured, frame: None, adapter: "none", commands: Vec::new() };
    let mut output = context.run_ui(input, |ui| {
        panels::show(ui, &mut stage);
    });
    let texts = std::mem::take(&mut output.shapes).into_iter().filter_map(|shape| match shape.shape {
        egui::Shape::Text(text) => Some((text.galley.text().to_owned(), text.visual_bounding_rect().center())),
        _ => None,
    });
    let texts = texts.collect();
    output.drop_without_applying_deltas();
    (stage.commands, texts)
}

/// Clicks on the topmost text that says this; what the panels then ask for.
fn click(label: &str, session: &mut Session, chrome: &mut Chrome) -> Vec<panels::Command> {
    let context = egui::Context::default();
    let mut run = |events| run_panels(&context, session, chrome, events);
    run(Vec::new());
    let (_, texts) = run(Vec::new());
    let Some((_, pos)) = texts.iter().rfind(|(text, _)| text == label) else { return Vec::new() };
    let button = |pressed| egui::Event::PointerButton {
        pos: *pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    run(vec![egui::Event::PointerMoved(*pos)]);
    run(vec![button(true)]);
    run(vec![button(false)]).0
}

#[test]
fn looking_at_every_panel_edits_nothing() {
    let mut session = Session::default();
    opened(None, loader::Reason::Open, &mut session);
    session.scene.lights[0].kind =
        LightKind::Directional { direction: Vec3::new(0.712_345_6, -0.654_321, 0.253_1).normalize() };
    session.scene.effect.exposure = 1.234_567_8;
    session.scene.camera.fov_deg = 33.333_333;
    let before = session.scene.clone();
    let mut chrome = Chrome { unfolded: true, ..Chrome::default() };
    let context = egui::Context::default();
    let mut run = |session: &mut Session, events| run_panels(&context, session, &mut chrome, events).0;
    for _ in 0..5 {
        assert!(run(&mut session, Vec::new()).is_empty());
    }
    assert_eq!(session.scene, before, "showing the panels changed the scene");
    // A wheel turn over the picture, as a control: it does change the camera.
    let at = egui::pos2(300.0, 1500.0);
    let wheel = egui::Event::MouseWheel {
        source: egui::MouseWheelSource::Wheel,
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, 60.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    };
    for events in [vec![egui::Event::PointerMoved(at)], vec![wheel], Vec::new(), Vec::new()] {
        run(&mut session, events);
    }
    assert_ne!(session.scene.camera, before.camera, "the wheel did not zoom");
}

/// A display of its own with the program's window on it; both end when it is dropped.
struct Screen {
    server: Child,
    display: String,
    program: Option<Child>,
    folder: tempfile::TempDir,
}

impl Drop for Screen {
    fn drop(&mut self) {
        for child in self.program.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Screen {
    fn new() -> Self {
        let missing = "is missing: run `sh tools/setup.sh test` (on Debian: apt install xvfb xdotool x11-apps)";
        for tool in ["xdotool", "xwd"] {
            assert!(Command::new(tool).arg("-version").output().is_ok(), "{tool} {missing}");
        }
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1000x700x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|e| panic!("Xvfb {missing} ({e})"));
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let screen = Self { server, display: format!(":{}", number.trim()), program: None, folder };
        assert!(!number.trim().is_empty(), "Xvfb did not start");
        screen
    }

    fn start(&mut self, arguments: &[&str]) {
        let program = Command::new(env!("CARGO_BIN_EXE_murrine"))
            .args(["--adapter", "software"])
            .args(arguments)
            .current_dir(self.folder.path())
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env("MURRINE_LOG", "error")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        self.program = Some(program);
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool").env("DISPLAY", &self.display).args(arguments).output().unwrap();
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    fn is_running(&mut self) -> bool {
        self.program.as_mut().unwrap().try_wait().unwrap().is_none()
    }

    /// Waits until `found` finds something, and no longer than a slow machine needs.
    fn wait_for<T>(&mut self, what: &str, mut found: impl FnMut(&Self) -> Option<T>) -> T {
        let started = Instant::now();
        loop {
            if let Some(it) = found(self) {
                return it;
            }
            assert!(self.is_running(), "the program ended while waiting for {what}: {}", self.told());
            assert!(started.elapsed() < PATIENCE, "no {what} after {PATIENCE:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn told(&mut self) -> String {
        let mut text = String::new();
        if let Some(stderr) = self.program.as_mut().and_then(|p| p.stderr.take()) {
            let _ = BufReader::new(stderr).read_to_string(&mut text);
        }
        text
    }

    /// Presses F12 and reads the picture that it writes.
    fn shoot(&mut self, number: u32) -> murrine::image::Picture {
        self.xdotool(&["key", "F12"]);
        let path = self.folder.path().join(format!("ball-{number:04}.png"));
        self.wait_for("screenshot", |_| murrine::image::read_png(&path).ok())
    }

    /// The screen as it is shown: width, height, RGB rows.
    fn dump(&self) -> (usize, Vec<[u8; 3]>) {
        let output = Command::new("xwd").args(["-root", "-silent", "-display", &self.display]).output().unwrap();
        let bytes = output.stdout;
        let word = |i: usize| u32::from_be_bytes(bytes[i * 4..i * 4 + 4].try_into().unwrap()) as usize;
        let (header, width, height, line, colors) = (word(0), word(4), word(5), word(12), word(19));
        assert_eq!((word(7), word(11)), (0, 32), "little-endian, 32 bits a pixel");
        let start = header + colors * 12;
        let rows = (0..height).flat_map(|y| bytes[start + y * line..][..width * 4].chunks_exact(4));
        (width, rows.map(|p| [p[2], p[1], p[0]]).collect())
    }
}

/// For anything the window does, on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(120);

/// Small, so that software renders it at once; nothing moves in it.
const BALL: &str = r#"
[camera]
eye = [0.0, 1.0, 4.0]
[grid]
cells = 32
[light_grid]
cells = 32
[effect]
max_events = 2
[[light]]
kind = "directional"
direction = [0.4, -1.0, -0.25]
[[model]]
name = "ball"
shape = "icosphere"
subdivisions = 2
[[model.material]]
attenuation_color = [0.9, 0.4, 0.2]
attenuation_distance = 0.5
[[model]]
shape = "plane"
size = 20.0
translate = [0.0, -1.0, 0.0]
[[model.material]]
opaque = true
"#;

fn colors_of(picture: &murrine::image::Picture) -> usize {
    picture.rgb8.iter().collect::<std::collections::BTreeSet<_>>().len()
}

#[test]
fn a_real_window_shows_the_picture_answers_and_survives_every_size() {
    let mut screen = Screen::new();
    let scene = screen.folder.path().join("ball.toml");
    std::fs::write(&scene, BALL).unwrap();
    screen.start(&[scene.to_str().unwrap()]);
    let find = |s: &Screen| Some(s.xdotool(&["search", "--name", "^ball"])).filter(|id| !id.is_empty());
    let window = screen.wait_for("window named by its scene", find);
    screen.xdotool(&["windowfocus", &window]);

    let beside_panels = screen.shoot(1);
    assert!(colors_of(&beside_panels) > 100, "the picture is blank: {} colours", colors_of(&beside_panels));

    // What is on the screen is what the PNG holds, byte for byte (below the notice that tells of the shot).
    let (width, dumped) = screen.dump();
    let (w, h) = (beside_panels.width as usize, beside_panels.height as usize);
    let differing = |expected: fn([u8; 3]) -> [u8; 3]| {
        let lower = (h / 2..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        lower.filter(|(x, y)| dumped[y * width + x] != expected(beside_panels.rgb8[y * w + x])).count()
    };
    assert_eq!(differing(|rgb| rgb), 0, "the window shows other colours than the picture holds");
    assert!(differing(|[r, g, b]| [b, g, r]) > w * h / 8, "swapped colours pass for the same");
    assert_ne!(dumped[10 * width + w + 20], [0, 0, 0], "the panels are not there");

    screen.xdotool(&["key", "Tab"]);
    let whole = screen.shoot(2);
    assert!(whole.width > beside_panels.width, "Tab did not hide the panels");

    screen.xdotool(&["mousemove", "300", "300", "mousedown", "1"]);
    for x in ["340", "380", "420"] {
        std::thread::sleep(Duration::from_millis(60));
        screen.xdotool(&["mousemove", x, "330"]);
    }
    std::thread::sleep(Duration::from_millis(60));
    screen.xdotool(&["mouseup", "1"]);
    let turned = screen.shoot(3);
    assert_eq!(turned.width, whole.width);
    assert_ne!(turned.rgb8, whole.rgb8, "dragging did not turn the view");

    for (w, h) in [("1", "1"), ("300", "2"), ("320", "240")] {
        screen.xdotool(&["windowsize", &window, w, h]);
        std::thread::sleep(Duration::from_millis(300));
        assert!(screen.is_running(), "a window of {w}×{h} ended the program: {}", screen.told());
    }
    screen.xdotool(&["key", "Escape"]);
    let small = screen.shoot(4);
    assert_eq!((small.width, small.height), (320, 240));
    assert!(colors_of(&small) > 50, "the picture did not come back after the window was next to nothing");

    // A file that goes bad keeps the picture; when it is mended, the picture follows it.
    std::fs::write(&scene, "[camera\n").unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert!(screen.is_running(), "a bad scene file ended the program: {}", screen.told());
    std::fs::write(&scene, BALL.replace("[0.9, 0.4, 0.2]", "[0.2, 0.4, 0.9]")).unwrap();
    let mut number = 5;
    let changed = screen.shoot(number);
    let mut differs = changed.rgb8 != small.rgb8;
    while !differs && number < 12 {
        number += 1;
        std::thread::sleep(Duration::from_millis(500));
        differs = screen.shoot(number).rgb8 != small.rgb8;
    }
    assert!(differs, "a changed scene file is not shown");
    assert!(screen.is_running());
}

#[test]
fn the_window_closes_cleanly() {
    let mut screen = Screen::new();
    let scene = screen.folder.path().join("ball.toml");
    std::fs::write(&scene, BALL).unwrap();
    screen.start(&[scene.to_str().unwrap(), "--quit-after", "3"]);
    let started = Instant::now();
    while screen.is_running() {
        assert!(started.elapsed() < PATIENCE, "it did not end after three paintings");
        std::thread::sleep(Duration::from_millis(50));
    }
    let status = screen.program.as_mut().unwrap().wait().unwrap();
    let told = screen.told();
    assert!(status.success(), "{status}: {told}");
    assert!(!told.contains("ERROR"), "{told}");
}

#[test]
fn without_a_display_it_says_what_to_do_and_exits_with_2() {
    let output = Command::new(env!("CARGO_BIN_EXE_murrine"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("DISPLAY") && told.contains("murrine render"), "{told}");
}

#[test]
fn a_surface_that_fails_is_tried_again_configured_again_or_made_again() {
    use wgpu::CurrentSurfaceTexture as Status;
    assert_eq!(without_texture(&Status::Timeout), (Painted::Again, true));
    assert_eq!(without_texture(&Status::Occluded), (Painted::Nowhere, true), "a hidden window paints nothing");
    assert_eq!(without_texture(&Status::Outdated), (Painted::Again, false));
    assert_eq!(without_texture(&Status::Validation), (Painted::Again, false));
    assert_eq!(without_texture(&Status::Lost), (Painted::Lost, false));
}

#[test]
fn timestamps_are_used_only_where_they_are_true() {
    let gpu = crate::gpu();
    let is_true = gpu.clock.is_true(gpu).unwrap();
    assert_eq!(gpu.clock.is_true(gpu).unwrap(), is_true, "the answer changed");
    if gpu.info.driver_info.contains("Mesa 22.") {
        assert!(!is_true, "lavapipe of Mesa 22 lays a stage's time to another");
    }
    let mut last = Vec::new();
    for _ in 0..3 {
        let mut rec = Recorder::new(gpu, Timing::Timestamps);
        rec.stage("first").unwrap();
        rec.stage("second").unwrap();
        last = rec.finish().unwrap();
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }
    let names: Vec<_> = last.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, if is_true { vec!["first", "second"] } else { Vec::new() });
}
