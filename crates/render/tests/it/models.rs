use crate::common::{direction, hair, midpoints, random};
use rapunzel_fiber::Section;
use rapunzel_render::{FarField, FiberBsdf, NearField};
use std::f64::consts::PI;
use std::time::Instant;

#[test]
fn explore() {
    for (bm, bn, al, sig) in [(0.3, 0.3, 3.0, 0.0), (0.3, 0.3, 0.0, 0.0), (0.1, 0.2, 3.0, 0.1), (0.9, 0.9, 3.0, 0.0)] {
        let optics = hair(sig, bm, bn, al);
        let t = Instant::now();
        let far = FarField::new(optics).expect("far");
        let t1 = t.elapsed();
        let t = Instant::now();
        let near = NearField::new(optics, &Section::Circle { radius: 1.0 }).expect("near");
        println!("{bm} {bn} {al}: build far {t1:?} near {:?}", t.elapsed());
        for theta in [-85.0_f64, -60.0, -30.0, 0.0, 30.0, 60.0, 85.0] {
            let from = direction(theta.to_radians(), 0.3);
            let a = far.arrive(0.0, &from);
            // furnace by quadrature
            let (mut f, mut pdf) = (0.0, 0.0);
            let (nt, np) = (1200, 120);
            let mut lobes = [0.0; 5];
            for th in midpoints(-PI / 2.0, PI / 2.0, nt) {
                for ph in midpoints(-PI, PI, np) {
                    let to = direction(th, ph);
                    let w = th.cos() * PI / f64::from(nt) * 2.0 * PI / f64::from(np);
                    let s = far.evaluate(&a, &to);
                    f += s.value.x * th.cos() * w;
                    pdf += s.pdf * w;
                    far.lobes(&a, &to).iter().zip(&mut lobes).for_each(|(l, s)| *s += l.x * th.cos() * w);
                }
            }
            let mut rng = random(1);
            let (mut mean, mut lo, mut hi) = (0.0, f64::INFINITY, 0.0_f64);
            let (mut nm, mut nlo, mut nhi) = (0.0, f64::INFINITY, 0.0_f64);
            let count = 20000;
            for _ in 0..count {
                if let Some(s) = far.sample(&a, &mut rng) {
                    mean += s.weight.mean() / f64::from(count);
                    lo = lo.min(s.weight.mean());
                    hi = hi.max(s.weight.mean());
                }
                let h = 2.0 * rng() - 1.0;
                let b = near.arrive(h, &from);
                if let Some(s) = near.sample(&b, &mut rng) {
                    nm += s.weight.mean() / f64::from(count);
                    nlo = nlo.min(s.weight.mean());
                    nhi = nhi.max(s.weight.mean());
                }
            }
            println!("{theta}: furnace {f:.6} alb {:.6} pdf {pdf:.6} w {mean:.4} [{lo:.4} {hi:.4}] near {nm:.4} [{nlo:.3} {nhi:.3}] lobes {lobes:.4?}", far.albedo(theta.to_radians()).x);
        }
    }
}
