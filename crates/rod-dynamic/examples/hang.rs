#![allow(clippy::all, clippy::print_stdout)]
//! x
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::*;
fn main() {
    for n in [100usize, 400] {
        let root = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        let pose = Isometry3::from_parts(Translation3::identity(), root);
        let fiber = Fiber::uniform(0.3, n, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .unwrap()
            .with_root(pose);
        let rod = Rod::new(fiber);
        let start = Staggered::new(rod.clone()).unwrap().state();
        let c = Instant::clamped(pose, Vector3::new(0.0, 0.0, -9.81));
        let mut best = f64::MAX;
        let mut rep = StepReport::default();
        for _ in 0..300 {
            let t = std::time::Instant::now();
            rep = equilibrium(&rod, &c, &start).unwrap().1;
            best = best.min(t.elapsed().as_secs_f64());
        }
        println!("{n}: {:.3} ms least, {rep:?}", best * 1e3);
        let mut best = f64::MAX;
        for _ in 0..300 {
            let t = std::time::Instant::now();
            let _ = std::hint::black_box(StaggeredBatch::new(vec![rod.clone()], 0.0).unwrap());
            best = best.min(t.elapsed().as_secs_f64());
        }
        println!("{n}: build {:.3} ms least", best * 1e3);
    }
}
