use super::check::check_count;
use super::report::StyleReport;
use super::room::ScalpRoom;
use super::spec::{FlowSpec, ScalpField, Style};
use super::surfaces::{ReadFile, StyleSurfaces};
use crate::growth::{
    DiscField, GreyImage, GrowthFlow, GrowthOptions, GrowthRegion, ScalpMesh, Whorl,
};
use crate::surface::bounds;
use crate::{
    DensityHistogram, HairCurves, HairDensity, HairReport, HairgenError, Pore, Region, VoxelFrame,
    dips_by_height, grow_hairs, grow_pre_guides, place_guides,
};
use nalgebra::{Point2, Vector3};

/// A part of the work on a style, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GrowthStage {
    /// Head, scalp and the surface of the hair, and their distances.
    Surfaces,
    /// The map of the scalp and the pores.
    Pores,
    /// Pre-guides.
    PreGuides,
    /// Guides.
    Guides,
    /// All hairs.
    Hairs,
}

/// A hairstyle that has grown.
#[derive(Debug, Clone)]
pub struct Hairstyle {
    /// The pores, a hair each.
    pub pores: Vec<Pore>,
    /// Center lines of the hairs (world), m, in the order of the pores; without points where a hair
    /// found no place.
    pub hairs: HairCurves,
    /// The surfaces between which they grew.
    pub surfaces: StyleSurfaces,
    /// What was found.
    pub report: StyleReport,
}

impl Style {
    /// Grows the style (thesis 5.3). Files are asked of `read`, by their paths in the style; every
    /// part of the work is told to `at` when it begins.
    ///
    /// # Errors
    /// [`HairgenError`] of the part that cannot be made.
    pub fn grow(
        &self,
        read: ReadFile<'_>,
        at: &dyn Fn(GrowthStage),
    ) -> Result<Hairstyle, HairgenError> {
        at(GrowthStage::Surfaces);
        self.check()?;
        let surfaces = StyleSurfaces::of(self, read)?;
        at(GrowthStage::Pores);
        let scalp = ScalpMesh::new(surfaces.scalp.clone())?;
        let area = scalp.area();
        let room = ScalpRoom::of(&surfaces, &scalp)?;
        let growth = GrowthRegion::new(scalp, self.growth(read)?)?;
        let count = self.hairs.unwrap_or_else(|| growth.count());
        check_count(count)?;
        // The first pores are as evenly spread as all: they take pre-guides and guides.
        let pores = growth.pores(count, self.seed)?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let pre_count = (self.pre_guides * area).round().clamp(3.0, 1e5) as usize;
        let pre_pores = &pores[..pre_count.min(count)];
        let guide_pores = &pores[..self.guides.min(count)];

        at(GrowthStage::PreGuides);
        let region = Region { head: &surfaces.head_field, hull: &surfaces.hull_field };
        let heights: Vec<f64> = pre_pores.iter().map(|p| growth.geodesic_height(&p.disc)).collect();
        let dips = dips_by_height(&heights, self.dips[0], self.dips[1]);
        let options = &self.guide.options;
        let pre = grow_pre_guides(pre_pores, &dips, region, options)?;

        at(GrowthStage::Guides);
        let frame = frame(&surfaces, self.guide.voxel.0)?;
        let mut density = self.guide.density.map(|model| HairDensity::new(frame, model));
        let guides = place_guides(guide_pores, &pre, region, density.as_mut(), options)?;
        if guides.guides.is_empty() {
            let [low, high] = bounds(&surfaces.hull);
            let (guides, length) = (guide_pores.len(), pores[0].length);
            return Err(HairgenError::NoPlace { guides, length, size: (high - low).norm() });
        }

        at(GrowthStage::Hairs);
        let mut hairs = grow_hairs(&pores, &guides.guides, guide_pores, region, &self.strands)?;
        if let Some(height) = self.trim {
            hairs = hairs.trimmed(height);
        }
        let lines = guides.guides.iter().map(|guide| &guide.curve[..]);
        let report = StyleReport {
            scalp_area: area,
            scalp_off: room.off,
            bare: room.bare,
            asked: pores.iter().map(|pore| pore.length).sum(),
            hairs: HairReport::of(&hairs, region, self.strands.outside),
            count,
            pre_guides: pre.len(),
            pre_guides_without_place: pre.iter().filter(|guide| !guide.placed).count(),
            guides: guides.guides.len(),
            guides_without_place: guides.without_place,
            equilibria: guides.guides.iter().map(|guide| guide.equilibria).sum(),
            histogram: DensityHistogram::of(lines, region, frame),
            fit: surfaces.fit.clone(),
            mended: surfaces.mended.clone(),
            crossed: surfaces.crossed.clone(),
        };
        Ok(Hairstyle { pores, hairs, surfaces, report })
    }

    /// What grows where.
    fn growth(&self, read: ReadFile<'_>) -> Result<GrowthOptions, HairgenError> {
        let flow = match &self.flow {
            FlowSpec::Whorl { place, turn, reach } => GrowthFlow::Whorl(Whorl {
                place: place.map(Point2::from),
                turn: turn.to_radians(),
                reach: *reach,
            }),
            FlowSpec::Angle(field) => GrowthFlow::Angle(field.disc(read, f64::to_radians)?),
        };
        let tilt = self.tilt.as_ref().map(|field| field.disc(read, f64::to_radians));
        Ok(GrowthOptions {
            density: self.density.disc(read, |x| x)?,
            length: self.length.disc(read, |x| x)?,
            flow,
            tilt: tilt.transpose()?,
            ..GrowthOptions::default()
        })
    }
}

impl ScalpField {
    /// The field on the disc, its values in another unit.
    fn disc(
        &self,
        read: ReadFile<'_>,
        unit: impl Fn(f64) -> f64,
    ) -> Result<DiscField, HairgenError> {
        match self {
            Self::Constant(value) => Ok(DiscField::Constant(unit(*value))),
            Self::Image { file, black, white } => {
                let failed = |problem: String| HairgenError::File { file: file.clone(), problem };
                let bytes = read(file).map_err(|error| failed(error.to_string()))?;
                let image = GreyImage::from_png(&bytes);
                let image = image.map_err(|error| failed(error.to_string()))?;
                Ok(DiscField::image(image, unit(*black), unit(*white)))
            }
        }
    }
}

/// The voxels around all that hair can fill.
fn frame(surfaces: &StyleSurfaces, spacing: f64) -> Result<VoxelFrame, HairgenError> {
    let ([low, high], [l, h]) = (bounds(&surfaces.hull), surfaces.head.bounds());
    let margin = Vector3::repeat(2.0 * spacing);
    VoxelFrame::new(low.inf(&l) - margin, high.sup(&h) + margin, spacing)
}
