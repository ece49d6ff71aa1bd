//! A picture may be marched in parts, so that a window can answer in between.

use crate::gpu;
use glam::{UVec2, Vec3};
use murrine::compose::DebugView;
use murrine::frame::{Frame, Request};
use murrine::gpu::{Timing, buffer};
use murrine::headless;
use murrine::march::{Channel, take_rows};
use murrine::scene::{Scene, World};
use std::path::Path;

const SIZE: UVec2 = UVec2::new(96, 67);
/// Rows a part.
const ROWS: u32 = 16;

fn request<'a>(scene: &'a Scene, world: &'a World, channel: Channel) -> Request<'a> {
    let view = DebugView::None;
    Request { scene, world, time_secs: 0.3, size: SIZE, picture_size: SIZE, channel, view, timing: Timing::Off }
}

type Left = (Vec<[u8; 4]>, Vec<[u32; 4]>, Vec<[u32; 4]>);

/// Everything that a frame leaves behind: the picture, the radiance and the channel, bit by bit.
fn bytes(frame: &Frame) -> Left {
    let floats = |texture| buffer::read_texture::<[u32; 4]>(gpu(), texture).unwrap();
    let radiance = frame.radiance();
    let picture = buffer::read_texture(gpu(), frame.picture()).unwrap();
    (picture, floats(&radiance.radiance), floats(&radiance.channel))
}

fn whole(frame: &mut Frame, request: &Request<'_>) {
    for _ in 0..4 {
        frame.render(gpu(), request).unwrap();
        if frame.settle(gpu()).unwrap() {
            return;
        }
    }
}

/// Renders by parts of `rows`; the number of parts.
fn by_parts(frame: &mut Frame, request: &Request<'_>, rows: u32) -> u32 {
    for parts in 1..100 {
        frame.render_part(gpu(), request, rows).unwrap();
        if frame.settle(gpu()).unwrap() && frame.is_whole() {
            return parts;
        }
    }
    panic!("it never ends");
}

#[test]
fn a_picture_marched_in_parts_holds_the_same_bytes() {
    // A checkered floor (whose filter looks at pixels beside), an open shell (whose rays are mended from pixels
    // around), and every way to march.
    let cases = [
        ("scenes/fish.toml", &["grid.cells=48", "light_grid.cells=48"][..], Channel::Thickness),
        ("scenes/shell.toml", &["grid.cells=48"], Channel::Questionable),
        ("scenes/shell.toml", &["grid.cells=48", "effect.hit=voxel"], Channel::Beauty),
        ("scenes/shell.toml", &["grid.cells=48", "effect.refraction=two-surface"], Channel::GroundLight),
    ];
    let mut frame = Frame::new(gpu()).unwrap();
    for (file, sets, channel) in cases {
        let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
        let (scene, world, _) = headless::open(Path::new(file), &sets).unwrap();
        let request = request(&scene, &world, channel);
        frame.forget();
        whole(&mut frame, &request);
        let at_once = bytes(&frame);
        frame.forget();
        let parts = by_parts(&mut frame, &request, ROWS);
        assert!(parts >= SIZE.y / ROWS, "{parts} parts of {ROWS} rows");
        assert!(bytes(&frame) == at_once, "{file} {sets:?}: parts of {ROWS} rows give another picture");
        let mut turned = scene.clone();
        turned.camera.eye += Vec3::new(0.1, 0.0, 0.0);
        whole(&mut frame, &Request { scene: &turned, ..request });
        assert!(bytes(&frame) != at_once, "{file}: another camera gives the same picture");
    }
}

#[test]
fn a_picture_that_is_given_up_half_way_leaves_the_old_one_and_no_trace_in_the_next() {
    let sets = ["grid.cells=48".to_owned(), "light_grid.cells=48".to_owned()];
    let (scene, world, _) = headless::open(Path::new("scenes/shell.toml"), &sets).unwrap();
    let mut turned = scene.clone();
    turned.camera.eye += Vec3::new(0.3, 0.1, 0.0);
    let (first, second) = (request(&scene, &world, Channel::Beauty), request(&turned, &world, Channel::Beauty));
    let mut frame = Frame::new(gpu()).unwrap();
    whole(&mut frame, &second);
    let expected = bytes(&frame);
    whole(&mut frame, &first);
    let before = bytes(&frame).0;

    frame.render_part(gpu(), &second, 24).unwrap();
    assert!(!frame.is_whole());
    assert!(bytes(&frame).0 == before, "an unfinished picture is shown");
    whole(&mut frame, &first);
    assert!(frame.is_whole() && bytes(&frame).0 == before, "what was given up left a trace");
    by_parts(&mut frame, &second, 24);
    assert!(bytes(&frame) == expected && expected.0 != before);
}

#[test]
fn the_parts_of_a_picture_are_all_its_rows_once() {
    for (rows, most) in [(101, 8), (101, 0), (101, u32::MAX), (7, 64), (1080, 90), (0, 8)] {
        let (mut left, mut end) = (0..rows, 0);
        while !left.is_empty() {
            let part = take_rows(&mut left, most);
            assert!(part.start == end && part.end > end && part.start.is_multiple_of(8), "{part:?} of {rows}");
            assert!(part.len() <= most.max(8) as usize);
            end = part.end;
        }
        assert_eq!(end, rows);
    }
}
