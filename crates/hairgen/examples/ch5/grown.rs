//! Styles that ship, and the steps between surfaces and hairs one by one.

use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Mesh;
use rapunzel_hairgen::growth::{DiscField, GrowthOptions, GrowthRegion, ScalpMesh};
use rapunzel_hairgen::head::{HairVolume, Hairline, HeadMeasures, ParametricHead};
use rapunzel_hairgen::style::{Hairstyle, Style};
use rapunzel_hairgen::{
    FieldResolution, GuideOptions, Pore, PreGuide, Region, SurfaceField, VoxelFrame,
    dips_by_height, grow_pre_guides,
};
use rapunzel_repro::Fallible;
use ron::extensions::Extensions;
use std::fs;
use std::path::Path;

/// How many hairs and guides there are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Size {
    Reduced,
    /// As in the thesis.
    Full,
}

impl Size {
    /// This number in the thesis's size, or a reduced one.
    pub(crate) fn of(self, full: usize, reduced: usize) -> usize {
        if self == Self::Full { full } else { reduced }
    }
}

/// A style of the folder `scenes/style`.
pub(crate) fn shipped(name: &str) -> Fallible<Style> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/style");
    let text = fs::read_to_string(folder.join(name).with_extension("ron"))?;
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    Ok(options.from_str(&text)?)
}

/// Grows a style.
pub(crate) fn grow(style: &Style) -> Fallible<Hairstyle> {
    Ok(style.grow(&|path| fs::read(path), &|_| {})?)
}

/// The parametric head with a volume of hair, up to the pre-guides.
pub(crate) struct Ground {
    pub(crate) head: Mesh,
    pub(crate) hull: Mesh,
    pub(crate) pores: Vec<Pore>,
    pub(crate) pre: Vec<PreGuide>,
    head_field: SurfaceField,
    hull_field: SurfaceField,
}

impl Ground {
    /// With `count` pores of hairs of a length, m, and a pre-guide on each square centimeter.
    pub(crate) fn new(volume: &HairVolume, length: f64, count: usize) -> Fallible<Self> {
        let own = ParametricHead::new(HeadMeasures::default(), Hairline::default())?;
        let [head, hull] = [Mesh::new(own.mesh())?, Mesh::new(own.hull(volume)?)?];
        let resolution = FieldResolution::default();
        let head_field = SurfaceField::solid("the head", &head, resolution)?;
        let hull_field = SurfaceField::solid("the hair", &hull, resolution)?;
        let options =
            GrowthOptions { length: DiscField::Constant(length), ..GrowthOptions::default() };
        let growth = GrowthRegion::new(ScalpMesh::new(own.scalp(120, 40)?)?, options)?;
        let pores = growth.pores(count, 1)?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundred")]
        let few = &pores[..count.min((1e4 * growth.mesh().area()).round() as usize)];
        let heights: Vec<f64> = few.iter().map(|p| growth.geodesic_height(&p.disc)).collect();
        let dips = dips_by_height(&heights, 0.1, 0.7);
        let region = Region { head: &head_field, hull: &hull_field };
        let pre = grow_pre_guides(few, &dips, region, &GuideOptions::default())?;
        Ok(Self { head, hull, pores, pre, head_field, hull_field })
    }

    pub(crate) fn region(&self) -> Region<'_> {
        Region { head: &self.head_field, hull: &self.hull_field }
    }
}

/// Cubic voxels around some points with sides of `spacing`, m.
pub(crate) fn voxels(points: &[Point3<f64>], spacing: f64) -> Fallible<VoxelFrame> {
    let far = Vector3::repeat(f64::INFINITY);
    let (low, high) =
        points.iter().fold((far, -far), |(low, high), p| (low.inf(&p.coords), high.sup(&p.coords)));
    let margin = Vector3::repeat(spacing);
    Ok(VoxelFrame::new(Point3::from(low - margin), Point3::from(high + margin), spacing)?)
}
