use rapunzel_collision::{Tree, scenes};
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
        let refit = median(|| tree.refit(&b, 0.0));
        tree.pairs(&mut pairs);
        println!(
            "{name} build {build:.2} refit {refit:.2} pairs {detect:.2} ms; {n} {}",
            pairs.len()
        );
        println!("{:?}", tree.shape());
    }
}
