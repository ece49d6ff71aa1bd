//! A ray tracer of triangles, on the host and in double precision: what rays through the volume are held against.

use crate::support::{glass, render, scene_of};
use glam::{DVec3, UVec2, Vec3};
use murrine::march::Channel;
use murrine::scene::description::{Camera, Cells, Shape, Source};
use murrine::scene::material::Material;
use murrine::scene::pose::pose_vertices;
use murrine::scene::{Scene, World};

/// Triangles in a tree of boxes.
struct Mesh {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    materials: Vec<Material>,
}

#[derive(Clone, Copy)]
struct Triangle {
    corners: [DVec3; 3],
    normals: [DVec3; 3],
    part: usize,
}

struct Node {
    lo: DVec3,
    hi: DVec3,
    first: usize,
    count: usize,
    second_child: usize,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
struct Hit {
    t: f64,
    normal: DVec3,
    front: bool,
    part: usize,
}

impl Mesh {
    fn of(scene: &Scene, time_secs: f64) -> Self {
        let world = World::load(scene, None).unwrap();
        let pose = world.pose(scene, time_secs);
        let posed = pose_vertices(&world, scene, &pose);
        let mut triangles = Vec::new();
        let (mut first_vertex, mut first_part) = (0, 0);
        for geometry in &world.models {
            for (number, part) in geometry.parts.iter().enumerate() {
                let range = part.triangles.start as usize..part.triangles.end as usize;
                for t in geometry.triangles[range].iter().filter(|_| part.plane_half.is_none()) {
                    let at = t.map(|v| posed[first_vertex + v as usize]);
                    triangles.push(Triangle {
                        corners: at.map(|v| v.0.as_dvec3()),
                        normals: at.map(|v| v.1.as_dvec3()),
                        part: first_part + number,
                    });
                }
            }
            first_vertex += geometry.vertices.len();
            first_part += geometry.parts.len();
        }
        let mut mesh = Self { triangles, nodes: Vec::new(), materials: world.materials(scene) };
        mesh.split(0, mesh.triangles.len());
        mesh
    }

    fn split(&mut self, first: usize, count: usize) -> usize {
        let range = &mut self.triangles[first..first + count];
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in range.iter().flat_map(|t| t.corners) {
            lo = lo.min(p);
            hi = hi.max(p);
        }
        let number = self.nodes.len();
        self.nodes.push(Node { lo, hi, first, count, second_child: 0 });
        if count > 4 {
            let size = hi - lo;
            let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap();
            let middle = |t: &Triangle| t.corners[0][axis] + t.corners[1][axis] + t.corners[2][axis];
            range.select_nth_unstable_by(count / 2, |a, b| middle(a).total_cmp(&middle(b)));
            self.split(first, count / 2);
            let second = self.split(first + count / 2, count - count / 2);
            self.nodes[number].second_child = second;
        }
        number
    }

    fn first_hit(&self, origin: DVec3, direction: DVec3, t_min: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut stack = vec![0];
        while let Some(number) = stack.pop() {
            let node = &self.nodes[number];
            let t_max = best.map_or(f64::INFINITY, |h| h.t);
            let (a, b) = ((node.lo - origin) / direction, (node.hi - origin) / direction);
            if a.min(b).max_element().max(t_min) > a.max(b).min_element().min(t_max) {
                continue;
            }
            if node.second_child > 0 {
                stack.extend([number + 1, node.second_child]);
                continue;
            }
            for t in &self.triangles[node.first..node.first + node.count] {
                let [p0, p1, p2] = t.corners;
                let (e1, e2) = (p1 - p0, p2 - p0);
                let n = e1.cross(e2);
                let cosine = n.dot(direction);
                let along = n.dot(p0 - origin) / cosine;
                if cosine == 0.0 || along <= t_min || along >= best.map_or(f64::INFINITY, |h| h.t) {
                    continue;
                }
                let v = origin + along * direction - p0;
                let (u, w) = (v.cross(e2).dot(n) / n.dot(n), e1.cross(v).dot(n) / n.dot(n));
                if u < 0.0 || w < 0.0 || u + w > 1.0 {
                    continue;
                }
                let normal = ((1.0 - u - w) * t.normals[0] + u * t.normals[1] + w * t.normals[2]).normalize();
                let outward = if n.dot(t.normals[0] + t.normals[1] + t.normals[2]) < 0.0 { -n } else { n };
                best = Some(Hit { t: along, normal, front: outward.dot(direction) < 0.0, part: t.part });
            }
        }
        best
    }

    /// Which way a ray leaves glass of one priority; `None` where it meets none, ends on opaque matter or would take more
    /// than `max_events` events.
    fn exit(&self, eye: DVec3, d: DVec3, max_events: u32) -> Option<DVec3> {
        let (mut origin, mut direction, mut t_min) = (eye, d, 0.0);
        let mut inside = vec![0_i32; self.materials.len()];
        let (mut events, mut exit) = (0, None);
        for _ in 0..96 {
            let Some(hit) = self.first_hit(origin, direction, t_min) else { break };
            let ruling = |inside: &[i32]| inside.iter().rposition(|n| *n > 0);
            let before = ruling(&inside);
            let material = &self.materials[hit.part];
            exit = None;
            if material.opaque {
                break;
            }
            origin += hit.t * direction;
            t_min = 1e-7;
            if material.thin_wall {
                continue;
            }
            let mut entered = inside.clone();
            entered[hit.part] = (entered[hit.part] + if hit.front { 1 } else { -1 }).max(0);
            let ior = |part: Option<usize>| part.map_or(1.0, |p| f64::from(self.materials[p].ior));
            let (from, to) = (ior(before), ior(ruling(&entered)));
            #[expect(clippy::float_cmp, reason = "the same number")]
            let bends = from != to;
            if bends {
                if events >= max_events {
                    break;
                }
                events += 1;
                let mut n = if hit.front { hit.normal } else { -hit.normal };
                let c = n.dot(direction);
                if c > -1e-3 {
                    n = (n - (c + 1e-3) * direction).normalize();
                }
                let (eta, c) = (from / to, -n.dot(direction));
                let k = 1.0 - eta * eta * (1.0 - c * c);
                if k <= 0.0 {
                    direction += 2.0 * c * n;
                } else {
                    direction = (eta * direction + (eta * c - k.sqrt()) * n).normalize();
                    inside = entered;
                }
            } else {
                inside = entered;
            }
            if inside.iter().all(|n| *n == 0) && !hit.front {
                exit = Some(direction);
            }
        }
        exit
    }
}

/// Eye and direction of a pixel's ray.
fn pixel_ray(scene: &Scene, size: UVec2, x: u32, y: u32) -> (DVec3, DVec3) {
    let camera = &scene.camera;
    let (eye, target) = (camera.eye.as_dvec3(), camera.target.as_dvec3());
    let forward = (target - eye).normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let tan = (f64::from(camera.fov_deg).to_radians() * 0.5).tan();
    let (w, h) = (f64::from(size.x), f64::from(size.y));
    let u = ((f64::from(x) + 0.5) / w * 2.0 - 1.0) * tan * w / h;
    let v = (1.0 - (f64::from(y) + 0.5) / h * 2.0) * tan;
    (eye, (forward + u * right + v * up).normalize())
}

/// Share of the rays through glass that leave it more than `degrees` off the way of the mesh's own.
fn share_astray(scene: &Scene, mesh: &Mesh, size: UVec2, degrees: f64) -> f64 {
    let ways = render(scene, size, Channel::ExitDirection);
    let (mut rays, mut astray) = (0.0, 0.0);
    for (x, y) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y))) {
        let (eye, d) = pixel_ray(scene, size, x, y);
        if let Some(way) = mesh.exit(eye, d, scene.effect.max_events) {
            let got = ways.channel_at(x, y);
            rays += 1.0;
            astray += if got.dot(way) > degrees.to_radians().cos() { 0.0 } else { 1.0 };
        }
    }
    assert!(rays > 500.0, "{rays} rays go through glass");
    astray / rays
}

#[test]
fn rays_through_voxels_that_hold_many_triangles_leave_where_the_meshs_own_do() {
    let ring = Shape::Torus { radius: 1.0, tube: 0.42, segments: 128 };
    let mut scene = scene_of(vec![glass("ring", ring, 1.5, Vec3::ZERO)]);
    scene.models[0].rotate_deg = Vec3::new(50.0, 20.0, 0.0);
    scene.grid.cells = Cells::Longest(48);
    scene.effect.fill_questionable = false;
    let size = UVec2::splat(72);
    let astray = share_astray(&scene, &Mesh::of(&scene, 0.0), size, 1.0);
    assert!(astray < 0.005, "{astray} of the rays through the ring go astray");
    let mut other = scene.clone();
    other.models[0].materials[0].ior = Some(1.45);
    let wrong = share_astray(&scene, &Mesh::of(&other, 0.0), size, 1.0);
    assert!(wrong > 0.5, "rays through another glass are told apart: {wrong}");
}

#[test]
fn rays_through_thin_fins_and_a_bent_body_leave_where_the_meshs_own_do() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/fish.glb");
    let mut fish = glass("fish", Shape::Icosphere { radius: 1.0, subdivisions: 0 }, 1.5, Vec3::ZERO);
    fish.source = Source::File(file);
    fish.materials[0].part = "glass".to_owned();
    fish.rotate_deg = Vec3::new(0.0, -28.0, 0.0);
    let mut scene = scene_of(vec![fish]);
    scene.camera = Camera { eye: Vec3::new(0.0, 1.2, 5.2), fov_deg: 31.0, ..Camera::default() };
    scene.effect.fill_questionable = false;
    let (size, mesh) = (UVec2::new(120, 80), Mesh::of(&scene, 0.0));
    let astray = share_astray(&scene, &mesh, size, 3.0);
    assert!(astray < 0.006, "{astray} of the rays through the fish go astray");
    scene.models[0].materials[0].ior = Some(1.45);
    let wrong = share_astray(&scene, &mesh, size, 3.0);
    assert!(wrong > 0.2, "rays through another glass are told apart: {wrong}");
}
