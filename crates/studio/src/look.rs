use crate::StudioError;
use nalgebra::Vector3;
use rapunzel_fiber::Section;
use rapunzel_render::FiberLook;
use rapunzel_scattering::{
    ChiangField, FarField, FiberBsdf, FiberOptics, NearField, Pigments, absorption_of_color,
};
use std::str::FromStr;

/// How hair scatters light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairLook {
    /// What colors it.
    pub pigments: Pigments,
    /// Roughness along and around the fibre, as it is felt, in `[0, 1]`.
    pub roughness: [f64; 2],
    /// Angle of the scales of the cuticle, rad.
    pub scales: f64,
    /// The model.
    pub model: HairModel,
}

/// A model of the scattering of one fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HairModel {
    /// By the offset of every hit; round or elliptical fibres.
    #[default]
    Near,
    /// Its mean over the width of the fibre; round fibres.
    Far,
    /// That of today's renderers, to compare with.
    Chiang,
}

impl Default for HairLook {
    /// Brown hair.
    fn default() -> Self {
        let (pigments, scales) = (Pigments::BROWN, 3.0_f64.to_radians());
        Self { pigments, roughness: [0.3, 0.3], scales, model: HairModel::Near }
    }
}

impl FromStr for HairModel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "near" => Ok(Self::Near),
            "far" => Ok(Self::Far),
            "chiang" => Ok(Self::Chiang),
            _ => Err(format!("\"{text}\" is no model: take near, far or chiang")),
        }
    }
}

/// The pigments of a named color of hair.
///
/// # Errors
/// A sentence that lists the names.
pub fn pigments(name: &str) -> Result<Pigments, String> {
    match name {
        "white" => Ok(Pigments::WHITE),
        "blond" => Ok(Pigments::BLOND),
        "brown" => Ok(Pigments::BROWN),
        "red" => Ok(Pigments::RED),
        "black" => Ok(Pigments::BLACK),
        _ => Err(format!("\"{name}\" is no color: take white, blond, brown, red or black")),
    }
}

impl HairLook {
    /// White hair that is dyed to a color, linear red, green and blue in `(0, 1]`.
    ///
    /// # Errors
    /// [`StudioError::Look`] if a color is outside its range.
    pub fn dyed(self, color: &Vector3<f64>) -> Result<Self, StudioError> {
        let dye = absorption_of_color(color, self.roughness[1])?;
        Ok(Self { pigments: Pigments::WHITE.dyed(dye), ..self })
    }

    /// The scattering of fibres whose second semi-axis has the ratio `ratio` to the first.
    pub(crate) fn fiber_look(&self, ratio: Option<f64>) -> Result<FiberLook, StudioError> {
        let absorption = self.pigments.absorption()?;
        let [along, around] = self.roughness;
        let optics = FiberOptics::hair(absorption, along, around, self.scales)?;
        // The size does not matter: absorption is per radius.
        let section = match ratio {
            Some(ratio) => Section::Ellipse { a: 1.0, b: ratio },
            None => Section::Circle { radius: 1.0 },
        };
        let bsdf: Box<dyn FiberBsdf + Send + Sync> = match self.model {
            HairModel::Near => Box::new(NearField::new(optics, &section)?),
            HairModel::Far => Box::new(FarField::new(optics)?),
            HairModel::Chiang => Box::new(ChiangField::new(optics)?),
        };
        // What a path through the middle of a fibre transmits.
        let albedo = absorption.map(|sigma| (-2.0 * sigma).exp());
        Ok(FiberLook::Scattering { bsdf, albedo })
    }
}
