//! Figure 6.6: rays through a circle, and how R, TT and TRT spread over azimuths.

use crate::draw::{chart, curve, midpoints, samples};
use crate::studio::hair;
use crate::trace::{INDEX, exit, light};
use crate::wavy::RADIUS;
use nalgebra::{Point3, Vector3};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Picture, Pictures};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_scattering::{
    BravaisIndices, CirclePaths, CuticleTilt, FiberBsdf, FiberOptics, MarschnerField, OrderShares,
    Pigments, Polarization, gaussian, normal_scattering,
};
use std::f64::consts::{FRAC_PI_2, PI};

const LABELS: [&str; 2] = ["change of azimuth (degrees)", "N_p (1/rad)"];

/// Rays of one order in the normal plane.
fn circle(name: &str, order: u32) -> Picture {
    let rim = samples(0.0, 2.0 * PI, 96).map(|phi| Point3::new(phi.cos(), phi.sin(), 0.0));
    // The axis, a dot from here.
    let mut fibers = vec![vec![Point3::origin(), Point3::new(0.0, 0.0, 1.0)], rim.collect()];
    for h in samples(-0.98, 0.98, 28) {
        let ray = exit(0.0, h, order);
        let before = ray.points[0] + light(0.0) * (2.6 - ray.points[0].x);
        let all = std::iter::once(before).chain(ray.points).chain([ray.at + ray.direction * 2.0]);
        fibers.push(all.map(Point3::from).collect());
    }
    fibers.iter_mut().flatten().for_each(|p| *p *= RADIUS);
    Picture { caption: name.into(), fibers }
}

/// `N_p` of a smooth fibre that does not absorb; infinite at caustics.
fn plain(name: &str, theta: f64, order: u32) -> Fallible<Curve> {
    let paths = CirclePaths::new(INDEX, theta)?;
    let at = |degrees: f64| {
        let azimuth = degrees.to_radians();
        let n = normal_scattering(&paths, order, azimuth, 0.0, Polarization::Averaged)?;
        Ok([degrees, n])
    };
    let points = midpoints(-180.0, 180.0, 1440).map(at).collect::<Fallible<Vec<_>>>()?;
    Ok(curve(name, points))
}

/// `N_p` with a finite width, and its integral.
fn folded(name: &str, roughness: f64, order: usize) -> Fallible<(Curve, f64)> {
    let optics = FiberOptics { tilt: CuticleTilt::NONE, ..hair(&Pigments::WHITE, roughness)? };
    let field = MarschnerField::new(optics)?;
    let arrival = field.arrive(0.0, &Vector3::x());
    // In level light (6.14) is M N, and M is half of the normal distribution.
    let m = 0.5 * gaussian(0.5 * optics.variance[order].sqrt(), 0.0)?;
    let at = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [degrees, field.lobes(&arrival, &Vector3::new(cos, sin, 0.0))[order].x / m]
    };
    let points: Vec<[f64; 2]> = midpoints(-180.0, 180.0, 1440).map(at).collect();
    let integral = points.iter().map(|p| p[1]).sum::<f64>() * 2.0 * PI / points.len() as f64;
    Ok((curve(name, points), integral))
}

/// What R, TT, TRT and all later orders scatter of the light at an inclination, rad.
fn energies(theta: f64) -> Fallible<[f64; 4]> {
    let paths = CirclePaths::new(INDEX, theta)?;
    let mut sums = [0.0; 4];
    let count = 2000;
    for gamma in midpoints(0.0, FRAC_PI_2, count) {
        let shares = OrderShares::new(&paths, gamma.sin(), Polarization::Averaged);
        let [r, tt, trt] = shares.first;
        let measure = gamma.cos() * FRAC_PI_2 / f64::from(count);
        sums.iter_mut().zip([r, tt, trt, shares.later]).for_each(|(sum, s)| *sum += s * measure);
    }
    Ok(sums)
}

/// Changes of azimuth of rays that are traced, degrees, from the middle to the edge on one side.
fn traced(theta: f64, order: u32) -> impl Iterator<Item = f64> {
    let rays = samples(0.0, FRAC_PI_2, 20_000);
    rays.map(move |gamma| exit(theta, gamma.sin(), order).azimuth().to_degrees())
}

/// The azimuth up to which rays of TRT turn on one side, degrees: its glint.
fn traced_glint(theta: f64) -> f64 {
    traced(theta, 2).fold(0.0, f64::max)
}

/// Where (6.11) has roots in level light, against rays that are traced.
fn roots() -> Fallible<Vec<ClaimCheck>> {
    let paths = CirclePaths::new(INDEX, 0.0)?;
    let counts = |order: u32| {
        midpoints(0.0, 180.0, 3600)
            .map(move |degrees| (degrees, paths.roots(order, degrees.to_radians()).len()))
    };
    let first = counts(1).find(|c| c.1 > 0).map_or(f64::NAN, |c| c.0);
    let last = counts(2).filter(|c| c.1 > 0).map(|c| c.0).last().unwrap_or(f64::NAN);
    let three = counts(2).filter(|c| c.1 == 3).map(|c| c.0).last().unwrap_or(f64::NAN);
    let tt = traced(0.0, 1).map(f64::abs).fold(180.0, f64::min);
    let farthest = traced(0.0, 2).map(f64::abs).fold(0.0, f64::max);
    let near = |x: f64| {
        let x = (100.0 * x).round() / 100.0;
        Criterion::Within(x - 0.06, x + 0.06)
    };
    let told = "TRT has one root or three";
    Ok(vec![
        check("TT: has no root below", first, "degrees", near(tt), "TT has exactly one root"),
        check("TRT: has three roots up to", three, "degrees", near(traced_glint(0.0)), told),
        check("TRT: has none beyond", last, "degrees", near(farthest), told),
    ])
}

/// Glints over the inclination, and what is said of them.
fn glints() -> Fallible<(Curve, Vec<ClaimCheck>)> {
    let caustic = |degrees: f64| {
        let paths = CirclePaths::new(INDEX, degrees.to_radians())?;
        Fallible::Ok(paths.caustic(2).map(|c| c.azimuth.to_degrees().abs()))
    };
    let (mut points, mut off) = (Vec::new(), 0.0_f64);
    for degrees in samples(0.0, 46.5, 93) {
        let glint = caustic(degrees)?.ok_or("no caustic")?;
        points.push([degrees, glint]);
        if degrees.rem_euclid(5.0) == 0.0 {
            off = off.max((glint - traced_glint(degrees.to_radians())).abs());
        }
    }
    let grows = points.windows(2).map(|p| p[1][1] - p[0][1]).fold(f64::MIN, f64::max);
    let [mut low, mut high] = [0.0, 80.0];
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if caustic(middle)?.is_some() { low = middle } else { high = middle }
    }
    let index = BravaisIndices::new(INDEX, low.to_radians())?.perpendicular;
    let checks = vec![
        check(
            "glints: largest error against traced rays, 0 to 45 degrees",
            off,
            "degrees",
            Criterion::AtMost(0.01),
            "h^2 = (4 - n'^2) / 3",
        ),
        check(
            "glints: largest step of the azimuth as the inclination grows",
            grows,
            "degrees",
            Criterion::AtMost(0.0),
            "come nearer to the plane of incidence (printed: normal plane)",
        ),
        check(
            "glints: n' where both meet",
            index,
            "",
            Criterion::Within(1.9999, 2.0001),
            "meet where n' is 2",
        ),
        check("glints: inclination where both meet", low, "degrees", Criterion::Told, "not told"),
    ];
    Ok((curve("glints of TRT", points), checks))
}

pub(crate) fn curves() -> Fallible<Figure> {
    let names = ["R", "TT", "TRT"];
    let pictures = (0..3).map(|p| circle(names[p as usize], p)).collect();
    let parts = (0..3).map(|p| plain(names[p as usize], 0.0, p)).collect::<Fallible<Vec<_>>>()?;
    let inclined = [0.0, 15.0, 30.0, 45.0, 60.0_f64];
    let trt = inclined
        .map(|degrees| plain(&format!("TRT, {degrees:.0} degrees"), degrees.to_radians(), 2))
        .into_iter()
        .collect::<Fallible<Vec<_>>>()?;
    let (wide, energy) = folded("TRT, roughness 0.3", 0.3, 2)?;
    let (narrow, sharp) = folded("TRT, roughness 0.1", 0.1, 2)?;
    let level = energies(0.0)?;
    let steep = energies(75.0_f64.to_radians())?;
    let (glint, told) = glints()?;
    let mut checks = roots()?;
    checks.extend(told);
    for (name, found) in [("0.1", sharp), ("0.3", energy)] {
        checks.push(check(
            format!("TRT: energy with a roughness of {name} over that of the rays, less 1"),
            100.0 * (found / level[2] - 1.0),
            "%",
            Criterion::Within(-0.5, 0.5),
            "caustics are removed so that energy is kept",
        ));
    }
    for (name, sums, most) in [("0", level, 1.0), ("75", steep, 10.0)] {
        checks.push(check(
            format!("energy of all orders after TRT, {name} degrees"),
            100.0 * sums[3],
            "%",
            Criterion::Within(0.1, most),
            "left out",
        ));
    }
    let logarithmic = |title: &str, curves| {
        let [x, y] = LABELS;
        Drawing::Chart(Chart { title: title.into(), x, y, log_from: Some(1e-3), curves })
    };
    let circles = Drawing::Pictures(Pictures {
        title: "6.6 R, TT and TRT in a circle".into(),
        view: "along the fibre, light from the right",
        axes: [Vector3::x(), Vector3::y()],
        columns: 3,
        pictures,
    });
    Ok(Figure {
        scene: "a smooth round fibre, n = 1.55, without absorption",
        parameters: "29 rays; N_p by (6.11) at 1440 azimuths; widths by the logistic distribution",
        drawings: vec![
            circles,
            logarithmic("6.6 Normal scattering, level light", parts.clone()),
            logarithmic("6.6 TRT under several inclinations", trt),
            chart("6.6 TRT with a finite width", LABELS, clipped(&parts[2], [narrow, wide])),
            chart(
                "6.6 Azimuth of the glints",
                ["inclination of the light (degrees)", "change of azimuth (degrees)"],
                vec![glint],
            ),
        ],
        checks,
    })
}

/// The smooth curve, without the tips of its caustics, beside others, within 60 degrees.
fn clipped(smooth: &Curve, others: [Curve; 2]) -> Vec<Curve> {
    let top = 2.5 * others[0].points.iter().map(|p| p[1]).fold(0.0, f64::max);
    let cut = |c: &Curve, name: &str| {
        let inside = c.points.iter().filter(|p| p[0].abs() < 60.0);
        curve(name, inside.map(|p| [p[0], p[1].min(top)]))
    };
    let first = cut(smooth, "TRT, smooth (tips cut off)");
    std::iter::once(first).chain(others.iter().map(|c| cut(c, &c.name))).collect()
}
