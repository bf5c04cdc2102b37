use super::*;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

fn chart(x: &'static str, y: &'static str, curves: Vec<Curve>) -> Chart {
    Chart { title: "a < b & c".into(), x, y, log_from: None, curves }
}

fn line(columns: usize) -> Drawing {
    Drawing::Pictures(Pictures {
        title: "line".into(),
        view: "x right",
        axes: [Vector3::x(), Vector3::z()],
        columns,
        pictures: vec![Picture {
            caption: "t = 0".into(),
            fibers: vec![vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0)]],
        }],
    })
}

/// The value of an attribute.
fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let (_, rest) = element.split_once(&format!(" {name}=\"")).expect("an attribute");
    rest.split('"').next().expect("its end")
}

/// A circle of lengths is drawn as one, and a long name in the legend ends in the drawing.
#[test]
fn shapes_keep_their_shape_and_legends_are_whole() {
    let circle = |i: u32| (TAU * f64::from(i) / 100.0).sin_cos();
    let points = (0..=100).map(circle).map(|(x, y)| [x, y]).collect();
    let name = "a long name of a curve that must not be cut at the edge of the drawing";
    let curves = vec![Curve { name: name.into(), points }];
    let drawn = svg(&[Drawing::Chart(chart("across (mm)", "height (mm)", curves))]).expect("drawn");
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let all = drawn.lines().filter(|line| line.starts_with("<polyline"));
    let longest = all.map(|line| attribute(line, "points")).max_by_key(|list| list.len());
    let pairs = longest.expect("a curve").split(' ').filter_map(|pair| pair.split_once(','));
    let (xs, ys): (Vec<f64>, Vec<f64>) = pairs.map(|(x, y)| (number(x), number(y))).unzip();
    let [x, y] = [xs, ys].map(|values| range(values.into_iter()));
    assert!(((x[1] - x[0]) - (y[1] - y[0])).abs() <= 4.0, "{x:?} {y:?}");
    let before = drawn.split(name).next().and_then(|text| text.lines().next_back());
    let at = 0.1 * number(attribute(before.expect("a legend"), "x"));
    assert!(at + 6.0 * name.chars().count() as f64 <= WIDTH, "{at}");
}

#[test]
fn parts_stand_below_each_other_and_all_numbers_are_kept() {
    let curve = |name: &str| Curve { name: name.into(), points: vec![[0.0, 1.0], [1.0, 1.0]] };
    let chart = Drawing::Chart(chart("time (s)", "height (m)", vec![curve("a"), curve("b")]));
    let pictures = line(2);
    assert_eq!(chart.csv().lines().count(), 5);
    assert_eq!(pictures.csv().lines().nth(2), Some("\"t = 0\",0,1.000000,0.000000,0.000000"));
    let both = [chart, pictures];
    let drawn = svg(&both).expect("drawn");
    assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
    let at = |text: &str| drawn.find(text).expect("is drawn");
    assert!(at("a &lt; b &amp; c") < at("line\n") && drawn.contains("time (s)"));
    assert!(drawn.starts_with("<svg width=\"960\" ") && drawn.ends_with("</svg>\n"));
    assert_eq!(drawn, svg(&both).expect("drawn again"));
}

/// Nothing to draw, numbers that are none, and intervals without width have a drawing.
#[test]
fn any_numbers_are_drawn() {
    let values = [f64::NAN, f64::INFINITY, 0.0, 1e-300, 1.0, 1e300, -1e300, 1e17];
    for log_from in [None, Some(1e-10)] {
        for a in values {
            for b in values {
                let points = vec![[a, b], [b, a], [b, b]];
                let curves = vec![Curve { name: String::new(), points }];
                let drawing = Chart { log_from, ..chart("x (m)", "y (m)", curves) };
                let drawn = svg(&[Drawing::Chart(drawing)]).expect("drawn");
                assert!(!drawn.contains("NaN"), "{a} {b}");
            }
        }
    }
    assert!(svg(&[]).is_ok() && svg(&[Drawing::Chart(chart("", "", Vec::new()))]).is_ok());
    assert!(matches!(svg(&[line(0)]), Err(PlotError::NoColumns)));
}

/// Images stand in their frames, below what is drawn before them; pixels that fill no rows are
/// refused.
#[test]
fn images_are_drawn_whole() {
    let image = |pixels| Image { caption: "i".into(), width: 2, pixels };
    let images = |columns, pixels| {
        let (title, legend) = ("images".into(), "none".into());
        Drawing::Images(Images { title, legend, pixel: 1e-3, columns, images: vec![image(pixels)] })
    };
    let pixels = vec![[255; 3], [0; 3], [1, 2, 3], [255; 3], [255; 3], [255; 3]];
    let both = [line(1), images(2, pixels.clone())];
    let drawn = svg(&both).expect("drawn");
    let elements: Vec<_> = drawn.lines().filter(|line| line.starts_with("<image")).collect();
    assert!(elements.len() == 1 && drawn.ends_with("</svg>\n"), "{drawn}");
    let number = |name| 0.1 * attribute(elements[0], name).parse::<f64>().expect("a number");
    let [above, whole] = [&both[..1], &both].map(|part| {
        let drawn = svg(part).expect("drawn");
        attribute(&drawn, "height").parse::<f64>().expect("a number")
    });
    assert!(number("y") > above && number("y") + number("height") < whole, "{drawn}");
    assert!((number("height") / number("width") - 1.5).abs() < 1e-2, "{drawn}");
    assert!(attribute(elements[0], "href").starts_with("data:image/png;base64,iVBORw0KGgo"));
    // Two of six pixels of a square millimeter.
    let table = both[1].csv();
    assert_eq!(table.lines().nth(1), Some("\"i\",0.002000,0.003000,0.00000200"));
    assert!(matches!(svg(&[images(0, pixels.clone())]), Err(PlotError::NoColumns)));
    for broken in [pixels[1..].to_vec(), Vec::new()] {
        let refused = svg(&[images(1, broken)]).expect_err("refused");
        assert!(matches!(refused, PlotError::Image { .. }), "{refused}");
    }
}
