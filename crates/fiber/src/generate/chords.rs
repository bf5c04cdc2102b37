use nalgebra::Point3;

/// Halvings of an interval in which a node is searched: to the last bit.
const HALVINGS: usize = 60;

/// Nodes on a curve, from its start on, whose segments are chords of given `lengths`, m. `curve`
/// gives the point at an arc length, m; it must not turn back within two lengths.
pub(super) fn chords(lengths: &[f64], curve: impl Fn(f64) -> Point3<f64>) -> Vec<Point3<f64>> {
    let mut at = 0.0;
    let mut nodes = vec![curve(at)];
    for length in lengths {
        let here = nodes[nodes.len() - 1];
        // A chord is longer, the farther it reaches along the curve.
        let (mut low, mut high) = (at, at + 2.0 * length);
        for _ in 0..HALVINGS {
            at = 0.5 * (low + high);
            let reach = (curve(at) - here).norm();
            *if reach < *length { &mut low } else { &mut high } = at;
        }
        nodes.push(curve(at));
    }
    nodes
}
