//! Gauss's method with four stages (Hairer, Lubich and Wanner 2006, II.1.3).
//!
//! Of order eight; symmetric, so that rods under strong tension, whose variations grow and decay in
//! lengths far below that of a step, do no harm.

/// Number of stages.
pub(crate) const STAGES: usize = 4;
/// Positions of the stages in the step, as fractions of its length.
pub(crate) const NODES: [f64; STAGES] = [
    0.069_431_844_202_973_71,
    0.330_009_478_207_571_9,
    0.669_990_521_792_428_1,
    0.930_568_155_797_026_3,
];
/// Coefficients of the rates of all stages (columns) in the value at each stage (rows).
pub(crate) const STEPS: [[f64; STAGES]; STAGES] = [
    [
        0.086_963_711_284_363_46,
        -0.026_604_180_084_998_79,
        0.012_627_462_689_404_72,
        -0.003_555_149_685_795_683,
    ],
    [
        0.188_118_117_499_868_07,
        0.163_036_288_715_636_54,
        -0.027_880_428_602_470_895,
        0.006_735_500_594_538_155,
    ],
    [
        0.167_191_921_974_188_77,
        0.353_953_006_033_743_97,
        0.163_036_288_715_636_54,
        -0.014_190_694_931_141_143,
    ],
    [
        0.177_482_572_254_522_6,
        0.313_445_114_741_868_35,
        0.352_676_757_516_271_87,
        0.086_963_711_284_363_46,
    ],
];
/// Weights of the rates of the stages in the value at the end of the step.
pub(crate) const WEIGHTS: [f64; STAGES] = [
    0.173_927_422_568_726_93,
    0.326_072_577_431_273_07,
    0.326_072_577_431_273_07,
    0.173_927_422_568_726_93,
];
/// Coefficients of the stages in the Legendre polynomial of degree three.
pub(crate) const CUBIC: [f64; STAGES] = [
    -0.371_027_003_401_947_3,
    0.939_772_470_377_753,
    -0.939_772_470_377_753,
    0.371_027_003_401_947_3,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_consistent() {
        for (steps, node) in STEPS.iter().zip(NODES) {
            assert!((steps.iter().sum::<f64>() - node).abs() < 1e-15, "{node}");
        }
        assert!((WEIGHTS.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
