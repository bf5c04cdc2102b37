use nalgebra::Vector3;

/// How radiance becomes the values of a screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tone {
    /// The curve of sRGB alone (IEC 61966-2-1): true colors up to 1, at which light is cut off.
    #[default]
    Srgb,
    /// A film's: light is compressed toward white before the curve of sRGB, by the fit to the
    /// reference rendering of ACES `x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14)` (Narkowicz
    /// 2016, "ACES filmic tone mapping curve"); white is reached at 7.24.
    Filmic,
}

impl Tone {
    /// Values of a screen, in `[0, 1]`, of radiance taken `2^exposure` times, each color by itself.
    /// They rise with radiance; what is negative or NaN is black.
    #[must_use]
    pub fn encoded(self, radiance: &Vector3<f64>, exposure: f64) -> [f64; 3] {
        let scale = exposure.exp2();
        [radiance.x, radiance.y, radiance.z].map(|light| {
            let light = light * scale;
            // Beyond white no curve changes.
            let light = if light > 0.0 { light.min(16.0) } else { 0.0 };
            srgb(match self {
                Self::Srgb => light,
                Self::Filmic => narkowicz(light),
            })
        })
    }
}

fn narkowicz(x: f64) -> f64 {
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The transfer function of sRGB, of light cut off at 1.
fn srgb(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        12.92 * light
    } else if light < 1.0 {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(tone: Tone, light: f64, exposure: f64) -> f64 {
        tone.encoded(&Vector3::new(0.0, light, 0.0), exposure)[1]
    }

    #[test]
    fn curves_have_their_known_values() {
        // Middle grey is 117.6 of 255; the line ends at 0.04045.
        assert!((of(Tone::Srgb, 0.18, 0.0) - 0.461_356_129).abs() < 1e-9);
        assert!((of(Tone::Srgb, 0.003_130_8, 0.0) - 0.040_449_936).abs() < 1e-9);
        // (2.51 + 0.03) / (2.43 + 0.59 + 0.14).
        let at_1 = srgb(2.54 / 3.16);
        assert!((of(Tone::Filmic, 1.0, 0.0) - at_1).abs() < 1e-15);
        assert!((of(Tone::Filmic, 0.25, 2.0) - at_1).abs() < 1e-15);
        for tone in [Tone::Srgb, Tone::Filmic] {
            assert_eq!([0.0, -1.0, f64::NAN].map(|x| of(tone, x, 3.0)), [0.0; 3]);
            assert_eq!([7.25, 1e300, f64::INFINITY].map(|x| of(tone, x, 0.0)), [1.0; 3]);
            assert_eq!(of(tone, 1.0, f64::INFINITY), 1.0);
        }
        assert!(of(Tone::Filmic, 7.2, 0.0) < 1.0);
    }

    #[test]
    fn more_light_is_never_darker() {
        for tone in [Tone::Srgb, Tone::Filmic] {
            let values: Vec<f64> =
                (0..20_000).map(|k| of(tone, f64::from(k) * 5e-4, 0.0)).collect();
            assert!(values.is_sorted(), "{tone:?}");
        }
    }
}
