//! probe
mod common;
use nalgebra::Vector3;
use rapunzel_fiber::Fiber;
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator};

fn run(fiber: Fiber, gravity: Vector3<f64>, rho: f64, dt: f64, duration: f64) {
    let root = *fiber.root();
    let mut integrator = BoxIntegrator::new(Rod::new(fiber), BoxOptions::with_damping(rho).expect("ok")).expect("ok");
    let conditions = |_: f64| Instant::clamped(root, gravity);
    let (mut it, mut halv, mut n, mut worst) = (0, 0, 0, 0);
    let start = std::time::Instant::now();
    while integrator.time() < duration {
        match integrator.step(dt, &conditions) {
            Ok(r) => { it += r.iterations; halv += r.halvings; n += 1; worst = worst.max(r.iterations); }
            Err(e) => { eprintln!("  FAILED {e}"); break; }
        }
    }
    let el = start.elapsed().as_secs_f64();
    let e = integrator.energy(&gravity);
    eprintln!("rho {rho} dt {dt:.4} mean it {:.2} worst {worst} halvings {halv} steps {n} ms/step {:.3} us/it {:.1} energy {:.3}", it as f64/n as f64, el*1e3/n as f64, el*1e6/it as f64, e.total()/(9.81*0.3*integrator.rod().fiber.mass()));
}

#[test]
fn probe() {
    let g = common::GRAVITY;
    for rho in [0.8, 0.5, 0.0, 1.0] {
        for dt in [1.0/30.0, 0.01] {
            run(common::hair(100), g, rho, dt, 10.0);
        }
    }
    eprintln!("3D");
    for rho in [0.8, 0.5, 0.0] {
        for dt in [1.0/30.0, 0.01] {
            let f = common::hair(100).with_natural_curvature(|_| Vector3::new(0.0, 4.0, 12.0)/0.3).expect("ok");
            run(f, g + 0.2*9.81*Vector3::z(), rho, dt, 10.0);
        }
    }
}
