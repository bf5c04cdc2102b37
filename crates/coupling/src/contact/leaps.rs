use super::system::CoupledSystem;
use crate::CouplingError;
use crate::TimeInterval;
use crate::pair::{ObjectPair, pairs};

/// Refuses a step of `dt`, s, in which an object would jump over fibres or another object.
pub(super) fn refuse_leaps(system: &CoupledSystem, dt: f64) -> Result<(), CouplingError> {
    let segments =
        system.fibers.assembly().fibers().iter().map(|f| f.length() / f.segments() as f64);
    let (segment, time) = (segments.fold(f64::INFINITY, f64::min), system.start);
    let step = TimeInterval { start: time, length: dt };
    let gravity = system.environment.gravity_at(time + 0.5 * dt);
    let poses = system.objects.iter().map(|object| object.free_poses(step, &gravity));
    let poses = poses.collect::<Result<Vec<_>, _>>()?;
    let refuse = |object, way, most| {
        if way > most {
            return Err(CouplingError::Leap { object, time, way, most, dt: dt * most / way });
        }
        Ok(())
    };
    for (object, one) in system.objects.iter().enumerate() {
        refuse(object, one.way(&poses[object]), one.size.min(segment))?;
    }
    for numbers in pairs(system.objects) {
        let (pair, [a, b]) =
            (ObjectPair::new(system.objects, numbers), numbers.map(|i| i as usize));
        let way = pair.way(&[poses[a], poses[b]]);
        if !pair.is_apart([&poses[a][0], &poses[b][0]], way) {
            refuse(a, way, pair.most_way())?;
        }
    }
    Ok(())
}
