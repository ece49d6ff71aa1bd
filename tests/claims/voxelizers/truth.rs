//! `cpu-exact` against rules written down another way.

use super::{BOTH, Triangle, count, faults, soup, sphere, torus, turned};
use glam::{DVec3, UVec3};
use murrine::grid::Grid;
use murrine::scene::description::Separability;
use murrine::voxelize::exact_voxels;

/// The words of all cells for which `meets(grid-space triangle, lower corner)` holds for some triangle.
fn brute_force(grid: &Grid, triangles: &[Triangle], meets: impl Fn(&[DVec3; 3], DVec3) -> bool) -> Vec<u32> {
    let mut words = vec![0; grid.word_count() as usize];
    let grid_from_world = grid.grid_from_world.as_dmat4();
    for triangle in triangles {
        let t = triangle.map(|p| grid_from_world.transform_point3(p.as_dvec3()));
        let lo = t[0].min(t[1]).min(t[2]).floor() - 1.0;
        let hi = t[0].max(t[1]).max(t[2]).floor() + 1.0;
        for z in 0..grid.cells.z {
            for y in 0..grid.cells.y {
                for x in 0..grid.cells.x {
                    let corner = UVec3::new(x, y, z).as_dvec3();
                    if corner.cmpge(lo).all() && corner.cmple(hi).all() && meets(&t, corner) {
                        words[grid.word_of([x, y, z])] |= 1 << (z & 31);
                    }
                }
            }
        }
    }
    words
}

/// Cuts a triangle by the six planes of a cell: true if something is left (Sutherland–Hodgman).
fn something_is_left(triangle: &[DVec3; 3], corner: DVec3) -> bool {
    let mut polygon = triangle.to_vec();
    for axis in 0..3 {
        for (sign, bound) in [(1.0, corner[axis]), (-1.0, -corner[axis] - 1.0)] {
            let inside = |p: &DVec3| sign * p[axis] - bound;
            let mut cut = Vec::new();
            for (i, a) in polygon.iter().enumerate() {
                let b = &polygon[(i + 1) % polygon.len()];
                let (da, db) = (inside(a), inside(b));
                if da >= 0.0 {
                    cut.push(*a);
                }
                if (da < 0.0) != (db < 0.0) {
                    cut.push(a.lerp(*b, da / (da - db)));
                }
            }
            polygon = cut;
        }
    }
    !polygon.is_empty()
}

/// RB's thin rule with the Appendix's indices put right: distances from the corner p, edge normals turned inwards by the
/// sign of the triangle's normal.
fn thin_as_printed(v: &[DVec3; 3], p: DVec3) -> bool {
    let e = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
    let n = e[0].cross(e[1]);
    let box_meets = (0..3).all(|a| {
        let (lo, hi) = (v[0].min(v[1]).min(v[2])[a], v[0].max(v[1]).max(v[2])[a]);
        lo <= p[a] + 1.0 && hi >= p[a]
    });
    let plane = (n.dot(p + 0.5 - v[0])).abs() <= 0.5 * n.abs().max_element();
    box_meets
        && plane
        && [(0, 1, 2), (1, 2, 0), (2, 0, 1)].into_iter().all(|(a, b, c)| {
            (0..3).all(|i| {
                let n_e = [-e[i][b] * n[c].signum(), e[i][a] * n[c].signum()];
                let d = n_e[0] * (0.5 - v[i][a]) + n_e[1] * (0.5 - v[i][b]) + 0.5 * n_e[0].abs().max(n_e[1].abs());
                n_e[0] * p[a] + n_e[1] * p[b] + d >= 0.0
            })
        })
}

#[test]
fn the_truth_is_what_cutting_triangles_to_voxels_leaves() {
    let grid = turned(UVec3::new(31, 24, 40));
    let triangles = soup(300);
    let truth = exact_voxels(&grid, &triangles, Separability::TwentySix);
    let cut = brute_force(&grid, &triangles, something_is_left);
    let difference = faults(&cut, &truth);
    assert_eq!((difference.missing, difference.spurious), (0, 0), "of {}", count(&cut));
    assert!(count(&truth.ties) * 200 < count(&truth.words), "{} ties", count(&truth.ties));
}

#[test]
fn the_thin_truth_is_the_papers_rule() {
    let grid = turned(UVec3::new(31, 24, 40));
    let triangles = soup(300);
    let truth = exact_voxels(&grid, &triangles, Separability::Six);
    let printed = brute_force(&grid, &triangles, thin_as_printed);
    let difference = faults(&printed, &truth);
    assert_eq!((difference.missing, difference.spurious), (0, 0), "of {}", count(&printed));
    assert!(count(&truth.ties) * 50 < count(&truth.words), "{} ties", count(&truth.ties));
}

/// Cells that a walk over faces (6) or over faces, edges and corners (26) reaches from cell (0, 0, 0).
fn reached(grid: &Grid, words: &[u32], neighbours: &[[i32; 3]]) -> Vec<bool> {
    let n = grid.cells.as_ivec3().to_array();
    let index = |c: [i32; 3]| usize::try_from((c[2] * n[1] + c[1]) * n[0] + c[0]).unwrap();
    let mut seen = vec![false; index([0, 0, n[2]])];
    let mut stack = vec![[0; 3]];
    while let Some(cell) = stack.pop() {
        let inside = (0..3).all(|a| (0..n[a]).contains(&cell[a]));
        if !inside || seen[index(cell)] || words[grid.word_of(cell.map(i32::cast_unsigned))] >> (cell[2] & 31) & 1 == 1
        {
            continue;
        }
        seen[index(cell)] = true;
        stack.extend(neighbours.iter().map(|d| [cell[0] + d[0], cell[1] + d[1], cell[2] + d[2]]));
    }
    seen
}

#[test]
fn no_path_leaks_into_a_closed_body() {
    let faces: Vec<[i32; 3]> = vec![[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    let all: Vec<[i32; 3]> = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]).collect();
    let grid = turned(UVec3::new(48, 50, 52));
    for (name, body) in [("sphere", sphere()), ("torus", torus())] {
        // A point inside each: the sphere's centre, the middle of the torus's tube.
        let inside = if name == "sphere" { DVec3::ZERO } else { DVec3::new(0.7, 0.0, 0.0) };
        let cell = grid.grid_from_world.as_dmat4().transform_point3(inside).as_uvec3();
        let index = ((cell.z * grid.cells.y + cell.y) * grid.cells.x + cell.x) as usize;
        let [thick, thin] = BOTH.map(|s| exact_voxels(&grid, &body, s).words);
        assert!(thin.iter().zip(&thick).all(|(thin, thick)| thin & !thick == 0), "{name}: thin is part of thick");
        assert!(count(&thin) < count(&thick) * 3 / 4, "{name}: {} of {}", count(&thin), count(&thick));
        assert!(!reached(&grid, &thick, &all)[index], "{name}: 26-separating leaks");
        assert!(!reached(&grid, &thin, &faces)[index], "{name}: 6-separating leaks");
        assert!(reached(&grid, &thin, &all)[index], "{name}: a thin shell lets corner paths through");
    }
}
