//! Scenes that a seed makes: nobody has seen those of a new seed, so nothing can have been tuned to them.

use glam::DVec3;
use rays::Mix;
use scene::authored::{Material, Mesh};
use std::f64::consts::{PI, TAU};

/// A scene's name, its meshes and their materials.
pub type Made = (&'static str, Vec<Mesh>, Vec<Material>);

/// One scene of each kind.
pub fn scenes(seed: u64) -> Vec<Made> {
    let mut made = Vec::new();
    let mut add = |name: &'static str, fill: fn(&mut Maker)| {
        let mut maker = Maker {
            dice: Mix(seed.wrapping_mul(31).wrapping_add(made.len() as u64)),
            meshes: Vec::new(),
        };
        fill(&mut maker);
        let materials = (0..4).map(|_| maker.material()).collect();
        made.push((name, maker.meshes, materials));
    };
    add("room", room);
    add("yard", yard);
    add("terrain", terrain);
    add("shelf", shelf);
    add("vault", vault);
    made
}

struct Maker {
    dice: Mix,
    meshes: Vec<Mesh>,
}

impl Maker {
    /// A number between two.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.dice.unit()
    }

    fn material(&mut self) -> Material {
        let mut material = Material::default();
        material.albedo = [0; 3].map(|_| self.between(0.1, 0.8) as f32);
        material.specular = [self.between(0.0, 0.2) as f32; 3];
        material.exponent = 10.0_f64.powf(self.between(0.5, 3.0));
        material
    }

    fn add(&mut self, positions: Vec<DVec3>, triangles: Vec<[u32; 3]>, normals: Vec<DVec3>) {
        let mut mesh = Mesh::default();
        mesh.name = format!("part {}", self.meshes.len());
        mesh.positions = positions.iter().map(|p| p.as_vec3().to_array()).collect();
        mesh.normals = normals.iter().map(|n| n.as_vec3().to_array()).collect();
        mesh.triangles = triangles;
        mesh.material = self.meshes.len() % 4;
        self.meshes.push(mesh);
    }

    /// A box that stands on `foot`, turned about the vertical.
    fn block(&mut self, foot: DVec3, size: DVec3, angle: f64) {
        let turn = glam::DQuat::from_rotation_y(angle);
        let corner = |k: u32| {
            let bit = |axis: u32| f64::from(k >> axis & 1);
            let at = DVec3::new(bit(0) - 0.5, bit(1), bit(2) - 0.5) * size;
            foot + turn * at
        };
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let positions = quads.iter().flatten().map(|&k| corner(k)).collect();
        let two = |k: u32| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]];
        self.add(positions, (0..6).flat_map(two).collect(), Vec::new());
    }

    /// A surface over the unit square in `n` by `n` quads; smooth where it has normals across its differences.
    fn sheet(&mut self, n: u32, smooth: bool, surface: impl Fn(f64, f64) -> DVec3) {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(n));
            positions.push(surface(u, v));
            if smooth {
                let across = surface(u + 1e-4, v) - surface(u - 1e-4, v);
                let along = surface(u, v + 1e-4) - surface(u, v - 1e-4);
                normals.push(across.cross(along).normalize_or(DVec3::Y));
            }
        }
        let quad = |(i, j): (u32, u32)| {
            let a = i * (n + 1) + j;
            [[a, a + n + 1, a + n + 2], [a, a + n + 2, a + 1]]
        };
        let quads = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        self.add(positions, quads.flat_map(quad).collect(), normals);
    }

    /// A flat rectangle from a corner along two sides, its front where their cross product points.
    fn flat(&mut self, corner: DVec3, a: DVec3, b: DVec3) {
        self.sheet(1, false, |u, v| corner + u * a + v * b);
    }

    /// A standing column with smooth sides.
    fn column(&mut self, foot: DVec3, radius: f64, height: f64) {
        self.sheet(12, true, |u, v| {
            let (sin, cos) = (u * TAU).sin_cos();
            foot + DVec3::new(radius * sin, height * v, radius * cos)
        });
    }

    /// A ball with this half axis along each direction.
    fn ball(&mut self, middle: DVec3, half: DVec3) {
        self.sheet(14, true, |u, v| {
            let ((sin, cos), (up, out)) = ((u * TAU).sin_cos(), (PI * (v - 0.5)).sin_cos());
            let out = out.max(1e-9);
            middle + half * DVec3::new(out * sin, up, out * cos)
        });
    }
}

/// Four walls, one with a window, a ceiling, and furniture.
fn room(maker: &mut Maker) {
    let (w, h, d) = (
        maker.between(3.0, 6.0),
        maker.between(2.3, 3.2),
        maker.between(3.0, 6.0),
    );
    let (x, y, z) = (DVec3::X * w, DVec3::Y * h, DVec3::Z * d);
    maker.flat(DVec3::ZERO, z, x);
    maker.flat(y, x, z);
    maker.flat(DVec3::ZERO, y, z);
    maker.flat(x, z, y);
    maker.flat(z, y, x);
    // The wall at z = 0 about its window.
    let low = maker.between(0.2, 0.4);
    let [left, right] = [low, maker.between(0.6, 0.9)];
    let [sill, lintel] = [maker.between(0.2, 0.4), maker.between(0.7, 0.9)];
    maker.flat(DVec3::ZERO, left * x, y);
    maker.flat(right * x, (1.0 - right) * x, y);
    maker.flat(left * x, (right - left) * x, sill * y);
    maker.flat(
        left * x + lintel * y,
        (right - left) * x,
        (1.0 - lintel) * y,
    );
    for _ in 0..6 {
        let size = DVec3::new(
            maker.between(0.2, 1.0),
            maker.between(0.2, 1.4),
            maker.between(0.2, 0.8),
        );
        let foot = DVec3::new(
            maker.between(0.15, 0.85) * w,
            0.0,
            maker.between(0.15, 0.85) * d,
        );
        let angle = maker.between(0.0, PI);
        maker.block(foot, size, angle);
    }
    let radius = maker.between(0.15, 0.4);
    let middle = DVec3::new(0.5 * w, maker.between(1.5, 2.0), 0.5 * d);
    maker.ball(middle, DVec3::splat(radius));
}

/// A ground with columns and heaps of boxes, each on the one below.
fn yard(maker: &mut Maker) {
    maker.flat(
        DVec3::new(-5.0, 0.0, -5.0),
        DVec3::Z * 10.0,
        DVec3::X * 10.0,
    );
    for _ in 0..5 {
        let mut foot = DVec3::new(maker.between(-4.0, 4.0), 0.0, maker.between(-4.0, 4.0));
        let mut side = maker.between(0.6, 1.4);
        for _ in 0..3 {
            let (height, angle) = (maker.between(0.3, 0.8), maker.between(0.0, PI));
            maker.block(foot, DVec3::new(side, height, side), angle);
            foot.y += height;
            side *= 0.7;
        }
    }
    for _ in 0..4 {
        let foot = DVec3::new(maker.between(-4.0, 4.0), 0.0, maker.between(-4.0, 4.0));
        let (radius, height) = (maker.between(0.1, 0.4), maker.between(1.0, 3.0));
        maker.column(foot, radius, height);
    }
}

/// Hills, and rocks that are sunk in them.
fn terrain(maker: &mut Maker) {
    let waves: Vec<[f64; 4]> = (0..5)
        .map(|k| {
            let angle = maker.between(0.0, TAU);
            let fast = 0.6 * 1.6_f64.powi(k);
            [
                fast * angle.cos(),
                fast * angle.sin(),
                maker.between(0.0, TAU),
                0.8 / fast,
            ]
        })
        .collect();
    let height = |x: f64, z: f64| -> f64 {
        let wave = |[a, b, phase, size]: &[f64; 4]| 0.5 * size * (a * x + b * z + phase).sin();
        waves.iter().map(wave).sum()
    };
    maker.sheet(48, true, |u, v| {
        let [x, z] = [10.0 * v - 5.0, 10.0 * u - 5.0];
        DVec3::new(x, height(x, z), z)
    });
    for _ in 0..8 {
        let [x, z] = [maker.between(-4.0, 4.0), maker.between(-4.0, 4.0)];
        let half = DVec3::new(
            maker.between(0.2, 0.8),
            maker.between(0.2, 0.8),
            maker.between(0.2, 0.8),
        );
        let sunk = maker.between(-0.3, 0.7) * half.y;
        maker.ball(DVec3::new(x, height(x, z) + sunk, z), half);
    }
}

/// Boards between two sides before a wall, with books.
fn shelf(maker: &mut Maker) {
    maker.flat(DVec3::new(-3.0, 0.0, 0.0), DVec3::Z * 3.0, DVec3::X * 6.0);
    maker.flat(DVec3::new(-3.0, 0.0, 0.0), DVec3::X * 6.0, DVec3::Y * 3.0);
    let (width, depth) = (maker.between(1.6, 2.4), maker.between(0.25, 0.4));
    let middle = 0.5 * depth + 0.01;
    for side in [-0.5, 0.5] {
        let foot = DVec3::new(side * (width + 0.04), 0.0, middle);
        maker.block(foot, DVec3::new(0.04, 2.2, depth), 0.0);
    }
    for board in 0..5 {
        let y = 0.1 + 0.5 * f64::from(board);
        maker.block(
            DVec3::new(0.0, y, middle),
            DVec3::new(width, 0.03, depth),
            0.0,
        );
        if board == 4 {
            break;
        }
        let mut x = -0.5 * width;
        loop {
            let (thick, high) = (maker.between(0.02, 0.08), maker.between(0.2, 0.42));
            x += thick + maker.between(0.0, 0.05);
            if x > 0.5 * width - 0.1 {
                break;
            }
            let deep = maker.between(0.5, 0.9) * depth;
            let foot = DVec3::new(x - 0.5 * thick, y + 0.03, middle);
            maker.block(foot, DVec3::new(thick, high, deep), 0.0);
        }
    }
}

/// A barrel vault that is open at one end, with columns.
fn vault(maker: &mut Maker) {
    let (radius, length) = (maker.between(1.5, 2.5), maker.between(4.0, 7.0));
    let (x, z) = (DVec3::X * radius, DVec3::Z * length);
    maker.flat(-x, z, 2.0 * x);
    maker.sheet(24, true, |u, v| {
        let (sin, cos) = (PI * v).sin_cos();
        DVec3::new(-radius * cos, radius * sin, length * u)
    });
    maker.flat(-x, 2.0 * x, DVec3::Y * radius);
    for k in 0..6 {
        let side = if k % 2 == 0 { -0.6 } else { 0.6 };
        let foot = DVec3::new(side * radius, 0.0, length * (0.2 + 0.3 * f64::from(k / 2)));
        let thick = maker.between(0.08, 0.25);
        maker.column(foot, thick, 0.8 * radius);
    }
}
