//! Room for what a grid holds comes and goes, and what it holds does not depend on how the room came to be.

use super::{around_unit_ball, contents, soup, spot, wavy};
use crate::gpu;
use crate::stages::Stages;
use glam::{DVec3, UVec3, Vec3};
use murrine::grid::Grid;
use murrine::volume::Record;

/// Renders until everything has room, and returns how many frames that took.
fn settled(stages: &mut Stages, grids: &[Grid]) -> u32 {
    for frames in 1..6 {
        stages.render(grids);
        if stages.volume.settle(gpu()).unwrap() {
            return frames;
        }
    }
    panic!("five frames were too few");
}

fn bytes(stages: &Stages) -> u64 {
    stages.volume.memory().iter().map(|(_, bytes)| bytes).sum()
}

#[test]
fn after_a_large_grid_a_small_one_holds_what_it_would_in_a_fresh_volume_and_memory_comes_back() {
    let small = Grid::world_aligned(DVec3::splat(-1.3), 2.6 / 40.0, UVec3::splat(40));
    let large = Grid::world_aligned(DVec3::splat(-1.3), 2.6 / 200.0, UVec3::splat(200));
    let mut fresh = wavy(0.1);
    settled(&mut fresh, &[small]);
    let truth = contents(&fresh);
    assert!(truth.3.len() > 10, "there are further sheets to lose");

    let mut stages = wavy(0.1);
    settled(&mut stages, &[large]);
    let (grown, other) = (bytes(&stages), contents(&stages));
    assert!(other != truth, "another grid holds something else");
    settled(&mut stages, &[small]);
    assert!(contents(&stages) == truth, "in a region that is too large");
    assert_eq!(bytes(&stages), grown, "a moment is no reason to give memory back");
    for _ in 0..150 {
        stages.volume.fit(gpu(), &[small]).unwrap();
    }
    settled(&mut stages, &[small]);
    assert!(bytes(&stages) * 3 < grown, "{} bytes of {grown} are kept", bytes(&stages));
    assert!(contents(&stages) == truth, "in a region that shrank");
    settled(&mut stages, &[large]);
    assert!(contents(&stages) == other, "grown once more");
}

#[test]
fn a_grid_without_room_harms_none_beside_it_and_all_end_as_in_a_fresh_volume() {
    let crowded = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(16));
    let roomy = Grid::world_aligned(DVec3::splat(-60.0), 1.0, UVec3::splat(128));
    let grids = [roomy, crowded, roomy];
    let of = |stages: &Stages, grid: usize| (stages.records(grid), stages.extras(grid));
    let mut stages = soup();
    stages.render(&grids);
    assert!(!stages.volume.settle(gpu()).unwrap(), "the crowded grid must not have room at once");
    let first = of(&stages, 0);
    assert!(first == of(&stages, 2));
    let estimated = stages.volume.grids[1].record_capacity;
    assert!(settled(&mut stages, &grids) <= 2);
    assert!(stages.volume.grids[1].record_capacity > estimated);
    // A fresh volume whose grids are asked for in another order and number.
    let mut alone = soup();
    settled(&mut alone, &[crowded]);
    assert!(of(&stages, 1) == of(&alone, 0));
    assert!(of(&stages, 0) == first && of(&stages, 2) == first);
    assert!(of(&stages, 1) != first, "the grids differ");
}

#[test]
fn more_or_fewer_grids_leave_each_ones_bytes_as_they_are() {
    let grids = [around_unit_ball(40), spot(UVec3::new(44, 36, 40)), around_unit_ball(90)];
    let mut stages = wavy(0.05);
    let mut held: Vec<(UVec3, Vec<u32>, [Vec<Record>; 2])> = Vec::new();
    for some in [&grids[..1], &grids[..], &grids[..2], &grids[1..], &grids[..]] {
        settled(&mut stages, some);
        for (number, grid) in some.iter().enumerate() {
            let words = stages.words(&stages.volume.occupancy, number);
            let now = (grid.cells, words, [stages.records(number), stages.extras(number)]);
            match held.iter().find(|(cells, ..)| *cells == grid.cells) {
                Some(before) => assert!(*before == now, "{} has changed", grid.cells),
                None => held.push(now),
            }
        }
    }
    assert_eq!(held.len(), 3);
}

#[test]
fn a_full_queue_of_large_triangles_changes_no_record_and_no_interior() {
    // Each over more columns than a thread takes alone; the queue holds 65,535.
    let corners = [Vec3::new(1.2, 1.3, 2.1), Vec3::new(14.7, 2.2, 9.4), Vec3::new(3.1, 14.6, 13.3)];
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(16));
    let copies = 65_535 + 4_000_u32;
    let mut one = Stages::standing(&[corners]);
    let mut many = Stages::standing(&vec![corners; copies as usize]);
    settled(&mut one, &[grid]);
    settled(&mut many, &[grid]);
    let (one_holds, many_hold) = (contents(&one), contents(&many));
    assert!(one_holds.0 == many_hold.0 && one_holds.2.len() > 64);
    assert_eq!(one_holds.2.len(), many_hold.2.len());
    for (a, b) in one_holds.2.iter().zip(&many_hold.2) {
        assert_eq!((a.normal, a.point), (b.normal, b.point));
        assert_eq!((a.triangle, b.triangle), (0, copies - 1), "of equals the last wins");
    }
    // An odd number of copies leaves the parity of one.
    assert_eq!(copies % 2, 1);
    let filled = one.filled(grid, false);
    assert!(filled.iter().any(|w| *w != 0));
    assert!(filled == many.filled(grid, false));
    let mut even = Stages::standing(&vec![corners; copies as usize - 1]);
    assert!(even.filled(grid, false).iter().all(|w| *w == 0), "an even number of crossings is outside");
}
