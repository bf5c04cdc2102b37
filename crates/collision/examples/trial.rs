use rapunzel_collision::{Candidates, Tree, Update, contacts, scenes, squared_distances};
use std::time::Instant;
fn median(mut f: impl FnMut()) -> f64 {
    let mut t: Vec<f64> = (0..21)
        .map(|_| {
            let s = Instant::now();
            f();
            s.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    t.sort_by(f64::total_cmp);
    t[5]
}
fn main() {
    if std::env::args().nth(1).is_some() {
        let s = scenes::wavy(1000);
        let c = s.capsules().unwrap();
        let mut t = Tree::new(&c, 0.0);
        let mut p = Vec::new();
        for _ in 0..600 {
            t.pairs(&mut p);
        }
        return;
    }
    for (name, scene) in [("wavy", scenes::wavy(1000)), ("clump", scenes::clump(1000))] {
        let moved = scene.advanced(1.0);
        let (a, b) = (scene.capsules().unwrap(), moved.capsules().unwrap());
        let mut tree = Tree::new(&a, 0.0);
        let mut pairs = Vec::new();
        let build = median(|| tree = Tree::new(&a, 0.0));
        let detect = median(|| tree.pairs(&mut pairs));
        let n = pairs.len();
        let refit = median(|| tree.refit(&b, 0.0).unwrap());
        tree.pairs(&mut pairs);
        println!(
            "{name} build {build:.2} refit {refit:.2} pairs {detect:.2} ms; {n} {}",
            pairs.len()
        );
        println!("{:?}", tree.shape());
        tree.refit(&a, 0.0).unwrap(); tree.pairs(&mut pairs);
        let mut d = Vec::new();
        let mut plain = vec![0.0; pairs.len()];
        let slow = median(|| for (d, &[i, j]) in plain.iter_mut().zip(&pairs) { *d = loop_distance(&scene.positions, i, j); });
        let fast = median(|| squared_distances(&a, &pairs, &mut d));
        let mut found = Vec::new();
        let touch = median(|| contacts(&a, &pairs, 0.0, &mut found));
        println!("plain {:.1} fast {:.1} M/s; contacts {touch:.2} ms {}", pairs.len() as f64 / slow * 1e-3, pairs.len() as f64 / fast * 1e-3, found.len());
        for margin in [100e-6, 150e-6, 200e-6, 300e-6, 400e-6] {
            let mut list = Candidates::new(0.0, margin).unwrap();
            list.update(&a).unwrap();
            let (mut time, mut kept, mut refit, mut size, mut worst) = (0.0, 0, 0, 0, 0.0f64);
            let mut keep = 0.0;
            for step in 1..=100 {
                let now = scene.advanced(f64::from(step));
                let now = now.capsules().unwrap();
                let s = Instant::now();
                let update = list.update(&now).unwrap();
                let t = s.elapsed().as_secs_f64() * 1e3;
                time += t;
                worst = worst.max(t);
                match update { Update::Kept => { kept += 1; keep += t } Update::Refitted => refit += 1, Update::Rebuilt => {} }
                size += list.pairs().len();
            }
            println!("margin {margin} mean {:.2} ms worst {worst:.2} kept {kept} ({:.2}) refit {refit} pairs {}", time / 100.0, keep / kept as f64, size / 100);
        }
    }
}

fn loop_distance(p: &[nalgebra::Point3<f64>], i: u32, j: u32) -> f64 {
    let at = |s: u32| { let k = s as usize + s as usize / 100; (p[k], p[k + 1]) };
    let ((p1, q1), (p2, q2)) = (at(i), at(j));
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f, b, c) = (d1.dot(&d1), d2.dot(&d2), d2.dot(&r), d1.dot(&d2), d1.dot(&r));
    let den = a * e - b * b;
    let mut s = if den > 0.0 { ((b * f - c * e) / den).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (b * s + f) / e;
    if t < 0.0 { t = 0.0; s = (-c / a).clamp(0.0, 1.0); } else if t > 1.0 { t = 1.0; s = ((b - c) / a).clamp(0.0, 1.0); }
    (r + s * d1 - t * d2).norm_squared()
}
