//! What a scene that is wrong is told: where, which field, and what is allowed.

use proptest::prelude::*;
use rapunzel_sim::scene::{SceneError, SceneProblem};
use rapunzel_sim::{Scene, World};

const SOUND: &str = "(
    format: 1,
    duration: 0.1,
    fibers: [
        (
            length: 0.2,
            segments: 10,
            section: Circle(radius: 4e-5),
            motion: Fixed,
            tip: Free,
        ),
    ],
    stepper: (dt: 0.001),
    output: (probes: [(fiber: 0, quantity: Position)]),
)";

/// The problems of the sound scene with a text in it replaced.
fn problems(from: &str, to: &str) -> Vec<SceneProblem> {
    assert_eq!(SOUND.matches(from).count(), 1, "{from} is in the scene once");
    match Scene::from_ron(&SOUND.replace(from, to)) {
        Err(SceneError { problems, .. }) => problems,
        other => panic!("{to} was not refused as a scene: {other:?}"),
    }
}

#[test]
fn the_scene_is_sound() {
    Scene::from_ron(SOUND).expect("a sound scene");
}

#[test]
fn every_problem_has_its_line_column_path_and_range() {
    for (from, to, line, column, path, message) in [
        ("format: 1", "format: 2", 2, 13, "format", "is 2, but this version reads format 1"),
        ("length: 0.2", "length: -0.2", 6, 21, "fibers[0].length", "between 1e-6 and 1000.0 (m)"),
        ("length: 0.2", "length: NaN", 6, 21, "fibers[0].length", "is NaN, but must be"),
        ("length: 0.2", "length: inf", 6, 21, "fibers[0].length", "is inf, but must be"),
        ("segments: 10", "segments: 0", 7, 23, "fibers[0].segments", "between 2 and 100000"),
        (
            "4e-5",
            "0",
            8,
            37,
            "fibers[0].section.radius",
            "is 0.0, but must be between 1e-10 and 10000.0 (m)",
        ),
        ("4e-5", "-4e-5", 8, 37, "fibers[0].section.radius", "is -4e-5, but must be between"),
        ("4e-5", "0.1", 8, 37, "fibers[0].section.radius", "a fibre is slender"),
        ("0.001", "0", 13, 19, "stepper.dt", "is 0.0, but must be between 1e-9 and 60.0 (s)"),
        ("0.001", "-1e-3", 13, 19, "stepper.dt", "is -0.001"),
        ("duration: 0.1", "duration: 0", 3, 15, "duration", "is 0.0"),
        ("fiber: 0", "fiber: 7", 14, 31, "output.probes[0].fiber", "no such fibre"),
        (
            "Free",
            "Pulled(velocity: (0, NaN, 0), until: 1)",
            10,
            39,
            "fibers[0].tip.velocity[1]",
            "",
        ),
        (
            "Free",
            "Driven(velocity: (0, 0, 0), until: 1, twist: 90, joint: Ball())",
            10,
            63,
            "fibers[0].tip.twist",
            "only a clamp turns the fibre",
        ),
        (
            "motion: Fixed",
            "root_joint: Ball(moment: (value: (0, inf, 0)))",
            9,
            50,
            "fibers[0].root_joint.moment.value[1]",
            "is inf",
        ),
        (
            "(dt: 0.001)",
            "(dt: 0.001), environment: (gravity: (0, 0, -1e300))",
            13,
            57,
            "environment.gravity[2]",
            "between -1000000.0 and",
        ),
        (
            "Fixed",
            "Swing(angle: 9, radius: 0.1, period: 0)",
            9,
            58,
            "fibers[0].motion.period",
            "is 0.0, but must be between 1e-9 and 1e9 (s)",
        ),
        // Fields and variants that do not exist, and values of the wrong kind.
        (
            "length: 0.2",
            "lenght: 0.2",
            6,
            13,
            "fibers[0].lenght",
            "Unexpected field named `lenght`",
        ),
        ("duration: 0.1,", "", 15, 1, "", "the field `duration` is missing"),
        ("Circle(radius", "Square(side", 8, 22, "fibers[0].section", "variant named `Square`"),
        ("segments: 10", "segments: -3", 7, 23, "fibers[0].segments", "or negative"),
        ("length: 0.2", "length: \"long\"", 6, 21, "fibers[0].length", "Expected float"),
        ("length: 0.2,", "length: 0.2", 7, 13, "fibers[0]", "Expected"),
    ] {
        let found = problems(from, to);
        let [problem] = &found[..] else { panic!("{to}: one problem, not {found:#?}") };
        let place = problem.place.as_ref().expect("a place in the text");
        let found = (place.line, place.column, problem.path.as_str());
        assert_eq!(found, (line, column, path), "{to}: {problem}");
        assert!(problem.message.contains(message), "{to}: {problem}");
    }
}

#[test]
fn a_decimal_comma_is_named() {
    for (from, to) in [
        ("length: 0.2", "length: 0,2"),
        ("duration: 0.1", "duration: 0,15"),
        ("tip: Free", "velocity: (0,5, 0, 0)"),
        ("tip: Free", "root: (position: (0, 1, 2,5))"),
        ("tip: Free", "arrangement: Ellipse(semi_axes: (0,1, 0.1), count: 3)"),
    ] {
        let found = problems(from, to);
        assert!(found[0].message.contains("not a comma"), "{to}: {}", found[0]);
    }
    let list = problems("tip: Free", "velocity: (0, 1, 2, 3)");
    assert!(!list[0].message.contains("comma"), "{}", list[0]);
}

/// Where a number is meant, one without a point is one.
#[test]
fn integers_are_numbers_everywhere() {
    let whole = "initial: Helix(radius: 1, pitch: 0), velocity: (0, 1, 0), damping_time: 0, \
        charge: (amount: Fiber(0), along: [(0, 1), (1, 1)]), \
        tip: Loaded(force: (value: (0, 0, 0), profile: Linear(points: [(0, 0), (1, 1)]))), \
        material: Elastic(density: 1000, youngs_modulus: 1_000_000, shear_modulus: 400000)";
    let text = SOUND.replace("tip: Free", whole).replace("dt: 0.001", "dt: 1, tolerance: 1");
    let environment = "format: 1, contact: None, environment: (gravity: (0, 0, -9), viscosity: 0, \
        climate: (humidity: [(0, 1)], temperature: 20)),";
    let text = text.replace("format: 1,", environment);
    let error = Scene::from_ron(&text).expect_err("a charge without charging").to_string();
    assert!(error.starts_with("the scene has a problem:") && error.contains("charging"), "{error}");
}

#[test]
fn a_root_cannot_jump() {
    let keyframes = |points: &str| problems("Fixed", &format!("Keyframes(points: [{points}])"));
    let jump = "(time: 0), (time: 0.1, translation: (0.01, 0, 0)), (time: 0.1)";
    let found = keyframes(jump);
    assert_eq!(found[0].path, "fibers[0].motion.points[2].time");
    assert!(found[0].message.contains("a root cannot jump"), "{}", found[0]);

    let fast = "(time: 0), (time: 0.001, translation: (1, 0, 0))";
    assert!(keyframes(fast)[0].message.contains("at most 100 m/s"), "{}", keyframes(fast)[0]);
    let start = "(time: 0, translation: (1, 0, 0))";
    assert!(keyframes(start)[0].message.contains("jump at the start"), "{}", keyframes(start)[0]);
    assert!(keyframes("")[0].message.contains("is empty"), "{}", keyframes("")[0]);
}

#[test]
fn an_end_cannot_jump() {
    let turned = "(time: 0), (time: 0.0001, rotation: (0, 90, 0))";
    for (from, to, field) in [
        ("Fixed", "Translate(velocity: (0, 1e5, 0), until: 1)", "motion.velocity"),
        ("Fixed", "Shake(amplitude: (0, 0, 0.1), frequency: 1e6)", "motion.frequency"),
        ("Fixed", "Rotate(axis: (0, 0, 1), rate: -1e9, until: 1)", "motion.rate"),
        ("Fixed", "Swing(angle: 90, radius: 1, period: 1e-3)", "motion.period"),
        ("Fixed", &format!("Keyframes(points: [{turned}])"), "motion.points[1]"),
        ("Free", "Pulled(velocity: (0, 0, -101), until: 1)", "tip.velocity"),
        ("Free", "Driven(velocity: (0, 0, -101), until: 1)", "tip.velocity"),
    ] {
        let found = problems(from, to);
        assert_eq!(found[0].path, format!("fibers[0].{field}"), "{to}");
        assert!(found[0].message.contains("a jump; at most"), "{}", found[0]);
    }
}

#[test]
fn all_problems_are_told_at_once() {
    let text = SOUND.replace("0.2", "0").replace("4e-5", "NaN").replace("0.001", "90");
    let error = Scene::from_ron(&text).expect_err("three problems").to_string();
    assert!(error.starts_with("the scene has 3 problems:"), "{error}");
    assert!(error.contains("\n  line 8, column 37: fibers[0].section.radius: is NaN"), "{error}");
}

#[test]
fn what_only_does_not_fit_together_names_the_bundle() {
    let wave = "tip: Free, shape: Sine(amplitude: 0.1, wavelength: 0.01)";
    let scene = Scene::from_ron(&SOUND.replace("tip: Free", wave)).expect("each number is sound");
    let error = World::build(&scene).err().expect("10 segments cannot resolve it").to_string();
    assert!(error.starts_with("fibers[0]: "), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is typed into a scene, it is read or refused at a place in its text.
    #[test]
    fn any_typing_error_has_its_place(
        at in 0..SOUND.len(),
        removed in 0..30_usize,
        typed in r#"[ -~]{0,6}|[(\[{)\]},:"/é\n]{0,3}|-?[0-9]{1,3}|NaN|inf|1e999|//|/\*"#,
    ) {
        let end = (at + removed).min(SOUND.len());
        let text = format!("{}{typed}{}", &SOUND[..at], &SOUND[end..]);
        if let Err(SceneError { problems, .. }) = Scene::from_ron(&text) {
            prop_assert!(!problems.is_empty());
            for problem in problems {
                let place = problem.place.expect("a place");
                prop_assert!(text.get(place.span.clone()).is_some(), "{text}: {place:?}");
                prop_assert!(place.line <= 1 + text.matches('\n').count());
            }
        }
    }
}
