//! What a film between two things pulls with.

use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use rapunzel_contact::{ContactError, Cylinders};
use rapunzel_fiber::Assembly;
use rapunzel_scene::Adhesion;

/// Pieces of the table of a force that depends on the gap.
const PIECES: usize = 256;
/// How far neighbours along a pair are apart at most, in segments: each segment between has a
/// touch.
const NEIGHBORS: f64 = 2.0;
/// Largest gap that a liquid may reach across, in radii.
const MOST_REACH: f64 = 10.0;
/// Gauss's rule with three points: places and weights.
const RULE: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// A film: its pull per length by the gap, and where fibres cross.
#[derive(Debug, Clone)]
pub(super) struct AdhesiveFilm {
    /// Pulls per length at even gaps from none to the range, N/m.
    pulls: Vec<f64>,
    /// Largest gap across which it pulls along fibres, m.
    range: f64,
    /// Liquid where fibres cross, m^3.
    crossing: Option<(Cylinders, f64)>,
}

impl AdhesiveFilm {
    /// The film of a scene, if it has one, between fibres of a `radius`, m.
    pub(super) fn new(adhesion: Adhesion, radius: f64) -> Result<Option<Self>, ContactError> {
        Ok(match adhesion {
            Adhesion::Bonds { .. } | Adhesion::Spray { .. } => None,
            Adhesion::Line { force, range } => {
                Some(Self { pulls: vec![force; 2], range, crossing: None })
            }
            Adhesion::Capillary { surface_tension, area, volume } => {
                let pair = Cylinders::new(radius, surface_tension)?;
                let range = pair.reach(area);
                if range > MOST_REACH * radius {
                    return Err(ContactError::Invalid {
                        what: "the area of the liquid between two fibres",
                        value: area,
                        why: "at most 20 squared radii: more is no film but drowns them (m^2)",
                    });
                }
                let gap = |i: usize| range * i as f64 / PIECES as f64;
                let pulls = (0..=PIECES).map(|i| pair.parallel_force(gap(i), area)).collect();
                Some(Self { pulls, range, crossing: Some((pair, volume)) })
            }
        })
    }

    /// Largest gap across which it pulls, m.
    pub(super) fn reach(&self) -> f64 {
        let crossing = self.crossing.as_ref().map_or(0.0, |(_, volume)| volume.cbrt());
        self.range.max(crossing)
    }

    /// Forces with which some contact points draw, N, where they have the given gaps, m. Along
    /// fibres side by side gap and pull are taken between neighbouring touches of a pair and shared
    /// by these. Sorted by pair and place.
    pub(super) fn forces(
        &self,
        assembly: &Assembly,
        points: &[ContactPoint],
        gaps: &[f64],
    ) -> Vec<f64> {
        let mut forces = vec![0.0; points.len()];
        let mut alone = vec![true; points.len()];
        for (i, pair) in points.windows(2).enumerate() {
            let [a, b] = [&pair[0], &pair[1]];
            let way = b.at()[0] - a.at()[0];
            let BodyRef::Fiber(fiber) = a.sides[0] else { continue };
            if a.sides != b.sides || way > NEIGHBORS {
                continue;
            }
            (alone[i], alone[i + 1]) = (false, false);
            let fiber = &assembly.fibers()[fiber as usize];
            let length = way * fiber.length() / fiber.segments() as f64;
            let shares = self.between([gaps[i], gaps[i + 1]]);
            forces[i] += length * shares[0];
            forces[i + 1] += length * shares[1];
        }
        if let Some((pair, volume)) = &self.crossing {
            for (i, point) in points.iter().enumerate().filter(|(i, _)| alone[*i]) {
                if let [BodyRef::Fiber(fiber), BodyRef::Fiber(_)] = point.sides {
                    let fiber = &assembly.fibers()[fiber as usize];
                    let most = self.at(gaps[i]) * fiber.length() / fiber.segments() as f64;
                    forces[i] = pair.crossed_force(gaps[i], *volume, point.turn()).min(most);
                }
            }
        }
        forces
    }

    /// The parts of two neighbours a unit of length apart in what is pulled between them, N/m.
    fn between(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        // The part of the way where the gap is within the range.
        let rim = (self.range - from) / (to - from);
        let (start, end) = match (from <= self.range, to <= self.range) {
            (true, true) => (0.0, 1.0),
            (true, false) => (0.0, rim),
            (false, true) => (rim, 1.0),
            (false, false) => return [0.0; 2],
        };
        let mut shares = [0.0; 2];
        for (place, weight) in RULE {
            let x = start + (end - start) * place;
            let pull = weight * (end - start) * self.at(from + x * (to - from));
            shares[0] += pull * (1.0 - x);
            shares[1] += pull * x;
        }
        shares
    }

    /// The pull per length at a gap, N/m; below zero it is that at zero.
    fn at(&self, gap: f64) -> f64 {
        let pieces = self.pulls.len() - 1;
        let x = (gap / self.range).max(0.0) * pieces as f64;
        if x > pieces as f64 {
            return 0.0;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "few pieces")]
        let i = (x as usize).min(pieces - 1);
        let t = x - i as f64;
        self.pulls[i] * (1.0 - t) + self.pulls[i + 1] * t
    }
}
