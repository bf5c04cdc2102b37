use nalgebra::Vector3;

/// Luminance of light in the primaries of sRGB (ITU-R BT.709-6, table 3: `E_Y`).
pub(crate) fn luminance(light: &Vector3<f64>) -> f64 {
    light.dot(&Vector3::new(0.2126, 0.7152, 0.0722))
}
