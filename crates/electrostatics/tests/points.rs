//! Point charges: the methods against each other and against exact fields.

mod common;

use common::{charges, cube, hair, relative};
use rapunzel_electrostatics::{Accuracy, BarnesHut, Direct, Method, Multipole, Plan};

/// Barnes and Hut's method and the multipole method converge to the direct sum as the order grows.
#[test]
fn methods_converge_to_the_direct_sum() {
    for points in [cube(5000, 1), hair(50, 100, 2).concat()] {
        let charges = charges(points.len(), false, 3);
        let exact = Direct.fields(&points, &charges, &points).expect("valid");
        let mut last = [1.0; 2];
        for order in [2, 5, 8, 11, 14] {
            let methods: [&dyn Method; 2] = [
                &Multipole { accuracy: Accuracy::Order(order) },
                &BarnesHut { opening: 0.5, order },
            ];
            for (k, method) in methods.iter().enumerate() {
                let fields = method.fields(&points, &charges, &points).expect("valid");
                let error = relative(&fields.fields, &exact.fields);
                assert!(error < 0.5 * last[k], "method {k}, order {order}: {error}");
                let worst = fields.potentials.iter().zip(&exact.potentials);
                let worst = worst.map(|(a, e)| (a / e - 1.0).abs()).fold(0.0, f64::max);
                assert!(worst < error, "potentials are smoother than fields: {worst}");
                last[k] = error;
            }
        }
        assert!(last[0] < 3e-5 && last[1] < 1e-5, "{last:?}");
    }
}
