//! What is a disc and what is not.

use super::{Cloth, SCALPS, bowl, cap, cloth, flat, mesh, scan};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{Soup, SurfaceTree, shapes};
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::growth::ScalpMesh;
use std::f64::consts::PI;

fn refused(soup: Soup) -> HairgenError {
    ScalpMesh::new(soup).expect_err("refused")
}

fn surface(error: HairgenError) -> CollisionError {
    let HairgenError::Surface { what: "the scalp", source } = error else { panic!("{error}") };
    source
}

#[test]
fn what_is_no_disc_is_refused_with_the_place() {
    let change = |change: &dyn Fn(&mut Soup)| {
        let mut soup = flat(6, 3);
        change(&mut soup);
        refused(soup)
    };
    assert_eq!(refused(Soup::default()), HairgenError::EmptyScalp);
    let error = surface(change(&|soup| soup.vertices[3].y = f64::NAN));
    assert!(matches!(error, CollisionError::Vertex { vertex: 3, .. }));
    let error = surface(change(&|soup| soup.triangles[4][1] = 99));
    assert!(matches!(error, CollisionError::Face { face: 4, .. }));
    let error = surface(change(&|soup| soup.triangles[4][1] = soup.triangles[4][0]));
    assert!(matches!(error, CollisionError::Face { face: 4, .. }));
    let error = surface(change(&|soup| soup.vertices.iter_mut().for_each(|p| *p *= 1e200)));
    assert!(matches!(error, CollisionError::Face { face: 0, .. }));
    let error = surface(change(&|soup| soup.triangles[5].swap(0, 1)));
    assert!(error.to_string().contains("orientation"), "{error}");
    let error = surface(change(&|soup| {
        soup.vertices.push(Point3::new(0.0, 1.0, 0.0));
        soup.triangles.push([0, 1, 19]);
    }));
    assert!(error.to_string().contains("more than two"), "{error}");
    // A hole of two triangles; one whose rim meets the border in a vertex.
    let error = change(&|soup| drop(soup.triangles.drain(6..8)));
    assert!(matches!(error, HairgenError::ScalpHoles { loops: 2, .. }), "{error}");
    let error = change(&|soup| {
        soup.triangles.remove(19);
    });
    assert!(matches!(error, HairgenError::ScalpPinch { .. }), "{error}");
    assert_eq!(refused(shapes::sphere(1.0, 3)), HairgenError::ClosedScalp);
}

#[test]
fn parts_pinches_and_handles_are_told() {
    let mut two = flat(5, 2);
    let other = flat(5, 1);
    let count = u32::try_from(two.vertices.len()).expect("few");
    two.vertices.extend(other.vertices.iter().map(|p| p + Vector3::new(9.0, 0.0, 0.0)));
    two.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + count)));
    assert_eq!(refused(two.clone()), HairgenError::ScalpParts { parts: 2, vertex: count });
    // Both meet at a vertex, inside of the one and at the border of the other, or at both borders.
    for [from, to] in [[count, 1], [0, count + 2], [count, 0], [count + 1, 7]] {
        let mut soup = two.clone();
        for v in soup.triangles.as_flattened_mut() {
            *v = if *v == from { to } else { *v };
        }
        let error = refused(soup);
        assert!(matches!(error, HairgenError::ScalpPinch { .. }), "{error}");
    }
    // A torus without one triangle.
    let mut torus = shapes::torus(1.0, 0.3, [7, 5]);
    torus.triangles.pop();
    assert_eq!(refused(torus), HairgenError::ScalpHandles { handles: 1 });
}

#[test]
fn a_cap_has_its_area_normals_and_border() {
    let scalp = mesh(cap(0.1, 0.5 * PI, 60, 40));
    let area = 2.0 * PI * 0.01;
    // Inscribed triangles miss about a twelfth of the squared angle of an edge each way.
    assert!((scalp.area() / area - 1.0).abs() < 4e-3 && scalp.area() < area);
    for (p, normal) in scalp.vertices().iter().zip(scalp.normals()) {
        let off = normal.angle(&p.coords);
        // At the border triangles are on one side only.
        assert!(off < if p.y < 1e-6 { 0.05 } else { 5e-3 }, "{off} at {p}");
    }
    let border = scalp.border();
    assert_eq!(border.len(), 60);
    // Counter-clockwise seen from above: about y, from z to x.
    let turns = |k: usize| {
        let [a, b] = [k, (k + 1) % 60].map(|k| scalp.vertices()[border[k] as usize]);
        a.coords.cross(&b.coords).y
    };
    assert!((0..60).all(|k| turns(k) > 0.0));
    assert!((scalp.size() - 0.3).abs() < 1e-3);
}

#[test]
fn vertices_without_triangles_are_left_out() {
    let mut soup = flat(5, 2);
    soup.vertices.insert(0, Point3::new(1e3, 0.0, 0.0));
    soup.triangles.as_flattened_mut().iter_mut().for_each(|v| *v += 1);
    assert_eq!(mesh(soup.clone()).vertices(), mesh(flat(5, 2)).vertices());
    // Errors still call vertices by the numbers that were given.
    soup.triangles.swap_remove(5);
    soup.triangles.push([0, 1, 2]);
    let named = |error| matches!(error, HairgenError::Surface { .. });
    assert!(named(refused(soup)));
}

#[test]
fn one_triangle_is_a_disc() {
    let soup = Soup { vertices: bowl(3, &[[1.0, 0.0]]).vertices, triangles: vec![[1, 2, 3]] };
    assert_eq!(mesh(soup).border().len(), 3);
}

#[test]
fn scanned_scalps_are_discs() {
    for scalp in SCALPS.into_iter().filter_map(scan) {
        assert_eq!(scalp.border().len(), 516);
        assert!((0.049..0.059).contains(&scalp.area()), "{}", scalp.area());
    }
}

proptest! {
    #[test]
    fn cloths_are_discs_with_borders_around(cloth in cloth(3.0)) {
        let scalp = mesh(cloth.soup());
        let Cloth { squares: [columns, rows], .. } = cloth;
        prop_assert_eq!(scalp.border().len(), 2 * (columns + rows));
        prop_assert!(scalp.normals().iter().all(|n| (n.norm() - 1.0).abs() < 1e-12));
    }

    /// Against all triangles.
    #[test]
    fn nothing_is_nearer(
        cloth in cloth(1.0),
        point in prop::array::uniform3(-3.0..12.0_f64),
    ) {
        let scalp = mesh(cloth.soup());
        let point = Point3::from(point);
        let found = scalp.nearest(&point);
        let distance = (scalp.position(&found) - point).norm();
        for face in (0..).take(scalp.triangles().len()) {
            let corners = scalp.corners(face).to_vec();
            let alone = Soup { vertices: corners, triangles: vec![[0, 1, 2]] };
            let other = SurfaceTree::new(&alone).expect("a triangle").nearest(&point).distance;
            prop_assert!(distance <= other + 1e-12);
        }
    }
}
