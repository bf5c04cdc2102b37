use super::*;
use proptest::prelude::*;
use rapunzel_collision::Capsule;
use std::f64::consts::TAU;

/// Rounding of what is computed from coordinates and lengths of up to 100.
const ROUNDING: f64 = 1e-12;

/// A section and how it lies about its axis: its semi-axes, between 0.01 and 1, and an angle, rad.
type Section = (f64, f64, f64);

fn section() -> impl Strategy<Value = Section> {
    let semi_axis =
        || prop_oneof![Just(0.01), Just(1.0), (-2.0..0.0_f64).prop_map(|x| 10_f64.powf(x))];
    let angle = prop_oneof![(0..8_u8).prop_map(|k| f64::from(k) * TAU / 8.0), 0.0..TAU];
    (semi_axis(), semi_axis(), angle)
}

fn unit() -> impl Strategy<Value = Vector3<f64>> {
    let x = || prop_oneof![(-1..=1_i8).prop_map(f64::from), -1.0..1.0_f64];
    [x(), x(), x()].prop_filter_map("a direction", |v| Vector3::from(v).try_normalize(1e-3))
}

/// A direction across another.
fn across(direction: &Vector3<f64>) -> Vector3<f64> {
    direction.cross(&Vector3::ith(direction.iamin(), 1.0)).normalize()
}

fn segment(start: Vector3<f64>, axis: Vector3<f64>, (a, b, angle): Section) -> EllipticSegment {
    let along = axis.try_normalize(0.0).unwrap_or_else(Vector3::z);
    let aside = across(&along);
    let d1 = aside * angle.cos() + along.cross(&aside) * angle.sin();
    let axes = [(d1, a * a), (along.cross(&d1), b * b), (along, a * b)];
    let shape = axes.into_iter().map(|(d, square)| d * square * d.transpose()).sum();
    let sharpest = a.min(b).powi(2) / a.max(b);
    EllipticSegment { start: start.into(), axis, shape, sharpest }
}

/// Where the axes are closest, as detection finds it.
fn of_axes(SegmentPair(pair): &SegmentPair) -> FacingPlace {
    let [first, second] =
        pair.map(|one| Capsule { start: one.start, end: one.start + one.axis, radius: 1.0 });
    let closest = first.closest(&second);
    let normal = closest.offset.try_normalize(f64::MIN_POSITIVE);
    let any = across(&pair[0].axis.try_normalize(0.0).unwrap_or_else(Vector3::z));
    FacingPlace { fractions: closest.fractions, normal: normal.unwrap_or(any) }
}

/// From where a plane touches the first of a pair to where one touches the second, m.
fn between(pair: &SegmentPair, place: &FacingPlace) -> Vector3<f64> {
    pair.offset(place.fractions) - reach(&pair.shapes(), &place.normal)
}

/// How far planes across a normal that have all of one on either side are apart, m: at most the
/// distance of the two.
fn apart(pair: &SegmentPair, normal: &Vector3<f64>) -> f64 {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let separations =
        corners.map(|fractions| pair.separation(&FacingPlace { fractions, normal: *normal }));
    separations.into_iter().fold(f64::INFINITY, f64::min)
}

/// Directions all over the sphere.
fn directions(count: u32) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |k| {
        let z = 2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0;
        let angle = f64::from(k) * TAU * 0.618_033_988_749_894_9;
        let aside = (1.0 - z * z).sqrt();
        Vector3::new(aside * angle.cos(), aside * angle.sin(), z)
    })
}

/// Poses of all kinds: parallel, crossed, end to end, points.
fn pair() -> impl Strategy<Value = SegmentPair> {
    let place = || prop::array::uniform3(prop_oneof![(-2..=2_i8).prop_map(f64::from), -3.0..3.0]);
    let axis = || {
        let some = (unit(), 0.1..50.0_f64).prop_map(|(direction, length)| direction * length);
        prop_oneof![8 => some, 1 => Just(Vector3::zeros())]
    };
    let turned = prop_oneof![
        2 => axis().prop_map(|axis| (axis, 1.0)),
        1 => axis().prop_map(|axis| (axis, 0.0)),
        1 => (axis(), -12.0..0.0_f64).prop_map(|(axis, x)| (axis, 10_f64.powf(x))),
    ];
    (place(), axis(), section(), turned, section()).prop_map(|(at, first, one, turned, other)| {
        let second = first + (turned.0 - first) * turned.1;
        let from = -0.5 * first;
        SegmentPair([
            segment(from, first, one),
            segment(Vector3::from(at) - 0.5 * second, second, other),
        ])
    })
}

/// Where a segment touches, by its fraction, and how steeply it leads away if it is an end.
fn touches() -> impl Strategy<Value = (f64, f64)> {
    prop_oneof![
        (0.0..1.0).prop_map(|fraction| (fraction, 0.0)),
        (0.0..2.0).prop_map(|steep| (0.0, steep)),
        (0.0..2.0_f64).prop_map(|steep| (1.0, -steep)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Two are put so that their surfaces face each other where it is known: apart, or less deep in
    /// each other than any of their radii of curvature, so that there is no shallower way out. That
    /// is found from where their axes are closest.
    #[test]
    fn the_closest_place_is_found(
        normal in unit(),
        turns in [0.0..TAU, 0.0..TAU],
        lengths in [0.1..50.0_f64, 0.1..50.0],
        kinds in [touches(), touches()],
        sections in [section(), section()],
        gap in -1.0..1.0_f64,
    ) {
        let aside = across(&normal);
        let axis = |side: usize| {
            let away = if side == 0 { -kinds[0].1 } else { kinds[1].1 };
            let along = aside * turns[side].cos() + normal.cross(&aside) * turns[side].sin();
            (along + normal * away).normalize() * lengths[side]
        };
        let [first, second] =
            [0, 1].map(|side| segment(Vector3::zeros(), axis(side), sections[side]));
        let gap = if gap < 0.0 { 0.9 * gap * (first.sharpest + second.sharpest) } else { gap };
        let fractions = kinds.map(|kind| kind.0);
        let mut pair = SegmentPair([first, second]);
        let place = FacingPlace { fractions, normal };
        pair.0[1].start += normal * gap - between(&pair, &place);
        let found = pair.closest(&of_axes(&pair));
        let separation = pair.separation(&found);
        prop_assert!((separation - gap).abs() < ROUNDING, "{separation} of {gap}, {found:?}");
        // By how much places move where they are flattest, with a radius of curvature of 100 each.
        let open = LAST_STEP * 2.0 * 100.0;
        prop_assert!((between(&pair, &found) - gap * found.normal).norm() < open, "{found:?}");
    }

    /// In any pose no plane parts two that are said to be in each other, and what is said of others
    /// is proved: two points of them are so far apart, and two planes have them on either side.
    #[test]
    fn a_separation_is_the_distance(pair in pair()) {
        let found = pair.closest(&of_axes(&pair));
        let separation = pair.separation(&found);
        prop_assert!((found.normal.norm() - 1.0).abs() < 1e-14);
        prop_assert!(found.fractions.iter().all(|part| (0.0..=1.0).contains(part)), "{found:?}");
        if separation > 0.0 {
            let planes = apart(&pair, &found.normal);
            let level = pair.level(&found);
            prop_assert!((planes - separation).abs() < 2.0 * level, "{planes}, {separation}");
            let points = between(&pair, &found).norm();
            prop_assert!((points - separation).abs() < 1e2 * ROUNDING, "{points}, {separation}");
        } else {
            let most = directions(2000).map(|normal| apart(&pair, &normal)).fold(-1e9, f64::max);
            prop_assert!(most < ROUNDING, "{most} for {separation}");
        }
    }

    /// Of the places that have a fraction along one side none is closer.
    #[test]
    fn a_place_beside_is_the_closest_there(
        pair in pair(),
        side in 0..2_usize,
        fraction in 0.0..1.0_f64,
    ) {
        let found = pair.beside(side, fraction, &of_axes(&pair).normal);
        let separation = pair.separation(&found);
        prop_assert_eq!(found.fractions[side], fraction);
        prop_assert!(found.fractions.iter().all(|part| (0.0..=1.0).contains(part)), "{found:?}");
        let mut range = [[fraction; 2]; 2];
        range[1 - side] = [0.0, 1.0];
        let most = directions(2000).map(|normal| pair.parted(&normal, range)).fold(-1e9, f64::max);
        prop_assert!(most < separation.max(0.0) + pair.level(&found), "{most} for {separation}");
        if separation > 0.0 {
            let points = between(&pair, &found).norm();
            prop_assert!((points - separation).abs() < 1e2 * ROUNDING, "{points}, {separation}");
        }
    }

    /// Neither order is better.
    #[test]
    fn both_see_the_same(pair in pair()) {
        let turned = SegmentPair([pair.0[1], pair.0[0]]);
        let places = [&pair, &turned].map(|pair| pair.closest(&of_axes(pair)));
        let [one, other] = [pair.separation(&places[0]), turned.separation(&places[1])];
        let level = pair.level(&places[0]);
        let overlap = one < 0.0 && other < 0.0;
        prop_assert!(overlap || (one - other).abs() < 2.0 * level, "{one}, {other}");
    }

    /// Round ones are as far from each other as their axes, less their radii.
    #[test]
    fn round_ones_are_tubes(pair in pair(), radii in [0.01..1.0_f64, 0.01..1.0]) {
        let SegmentPair(mut pair) = pair;
        pair.iter_mut().zip(radii).for_each(|(one, r)| {
            (one.shape, one.sharpest) = (Matrix3::identity() * (r * r), r);
        });
        let pair = SegmentPair(pair);
        let axes = of_axes(&pair);
        let expected = pair.offset(axes.fractions).norm() - radii[0] - radii[1];
        let found = pair.separation(&pair.closest(&axes));
        // Of axes that are parallel by their products none but ends are looked at.
        let lengths: f64 = pair.axes().map(|axis| axis.norm()).iter().sum();
        let open = 1e2 * ROUNDING + f64::EPSILON.sqrt() * lengths;
        prop_assert!((found - expected).abs() < open, "{found} of {expected}");
    }
}
