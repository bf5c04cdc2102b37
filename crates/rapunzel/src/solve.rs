use crate::arguments::SolveOptions;
use crate::failure::{Failure, UNRESOLVED};
use crate::words::{complain, say};
use rapunzel_sim::statics::{
    Case, CaseAnswer, CaseBranch, CaseContact, CaseEquilibrium, Ended, Stability, TouchedBy, Wished,
};
use rapunzel_sim::{read_text, statics};
use std::path::Path;
use std::process::ExitCode;

/// Solves a case for rods at rest, into a folder.
pub(crate) fn solve(options: &SolveOptions, json: bool) -> Result<ExitCode, Failure> {
    let path = &options.case;
    let text = read_text(path).map_err(Failure::of(path))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let case = Case::from_ron(&text).map_err(Failure::of(path))?.seen_from(folder);
    let answer = statics::solve(&case).map_err(Failure::of(path))?;
    let folder = options
        .out
        .clone()
        .unwrap_or_else(|| Path::new("runs").join(path.file_stem().unwrap_or_default()));
    answer.save(&folder, &case).map_err(Failure::of(path))?;
    // Along a branch unstable ones are what is asked for.
    let stable = answer.branch.is_some() || answer.holds();
    if json {
        say(&serde_json::json!({ "folder": folder, "answer": answer, "stable": stable })
            .to_string())?;
    } else {
        say(&report(&case, &answer))?;
        say(&format!("  results     {}", folder.display()))?;
    }
    if stable {
        return Ok(ExitCode::SUCCESS);
    }
    complain("warning: no stable equilibrium was found; a rod does not rest in an unstable one");
    Ok(ExitCode::from(UNRESOLVED))
}

fn report(case: &Case, answer: &CaseAnswer) -> String {
    let title = if answer.name.is_empty() { "the case is solved" } else { &answer.name };
    let mut lines = vec![title.to_owned(), format!("  length      {:.6} m", answer.length)];
    if let (Some(wish), Some(found)) = (case.wish, answer.wish) {
        let (what, unit) = match wish.so_that {
            Wished::Curvature(_) => ("curvature is nowhere above", "1/m"),
            Wished::Sag(_) => ("sag is", "m"),
            Wished::ClampForce(_) => ("force on the clamp is", "N"),
            Wished::ClampMoment(_) => ("moment on the clamp is", "N m"),
        };
        lines.push(format!("  found       the shortest whose {what} {:.6} {unit}", found.reached));
    }
    lines.extend(answer.branch.iter().flat_map(along));
    for (i, found) in answer.equilibria.iter().enumerate() {
        if answer.equilibria.len() > 1 {
            let what = if answer.contact.is_some() { "rod" } else { "equilibrium" };
            lines.push(format!("{what} {i}"));
        }
        lines.extend(one(found));
    }
    lines.extend(answer.contact.iter().flat_map(touching));
    lines.join("\n")
}

/// What is told of contacts.
fn touching(contact: &CaseContact) -> Vec<String> {
    let mut lines = vec![format!("  contacts    {}", contact.touches.len())];
    // By what pushes what, in the order in which that is met.
    let mut pairs: Vec<(String, usize, [f64; 3], f64)> = Vec::new();
    for touch in &contact.touches {
        let by = match touch.by {
            TouchedBy::Object(object) => format!("object {object} on rod {}", touch.rod),
            TouchedBy::Rod(rod, _) => format!("rod {rod} on rod {}", touch.rod),
        };
        let at = pairs.iter().position(|pair| pair.0 == by).unwrap_or_else(|| {
            pairs.push((by, 0, [0.0; 3], 0.0));
            pairs.len() - 1
        });
        let (_, count, sum, largest) = &mut pairs[at];
        *count += 1;
        *largest = largest.max(touch.force);
        (0..3).for_each(|k| sum[k] += touch.force * touch.normal[k]);
    }
    for (by, count, sum, largest) in pairs {
        let [x, y, z] = sum;
        lines.push(format!(
            "    {by}: {count}, together ({x:.6e}, {y:.6e}, {z:.6e}) N, the largest {largest:.6e} N"
        ));
    }
    lines.push(format!(
        "  holds to    {:.1e} m of a gap, {:.1e} N m of force times gap, {:.1e} N m of a moment",
        contact.penetration, contact.slackness, contact.unbalanced
    ));
    lines
}

/// What is told of a branch.
fn along(branch: &CaseBranch) -> Vec<String> {
    let unit = if branch.unit.is_empty() { String::new() } else { format!(" {}", branch.unit) };
    let [first, last] = [0, branch.points.len() - 1].map(|i| branch.points[i].parameter);
    let ended = match branch.ended {
        Ended::Reached => "where the range ends",
        Ended::Returned => "past a fold, back where the range begins",
        Ended::Lost => "where it has lost its stability",
        Ended::Long => "after twenty times the steps: it goes on",
        Ended::Stuck => "where no equilibrium was found beyond",
    };
    let count = branch.points.len();
    let mut lines =
        vec![format!("  branch      {count} equilibria from {first} to {last:.9}{unit}, {ended}")];
    if let Some(first) = branch.switched {
        lines.push(format!("  switched    to the other branch before its equilibrium {first}"));
    }
    for limit in &branch.limits {
        let kind = if limit.is_fold { "fold       " } else { "bifurcation" };
        let [before, behind] = limit.ways_down;
        let value = limit.parameter;
        lines.push(format!(
            "  {kind} at {value:.9}{unit}: {before} ways down before, {behind} behind"
        ));
    }
    lines
}

fn one(found: &CaseEquilibrium) -> Vec<String> {
    let stability = match found.stability {
        Stability::Stable => "stable".to_owned(),
        Stability::Unstable(1) => "unstable: one way leads down".to_owned(),
        Stability::Unstable(ways) => format!("unstable: {ways} ways lead down"),
        Stability::Unknown => "not told: a force follows the rod".to_owned(),
    };
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let vector = |v: [f64; 3]| format!("({:.6e}, {:.6e}, {:.6e})", v[0], v[1], v[2]);
    let carried = |name: &str, force: [f64; 3], moment: [f64; 3]| {
        vec![
            format!("  {name} force {:.6e} N = {}", size(force), vector(force)),
            format!("  {name} moment {:.6e} N m = {}", size(moment), vector(moment)),
        ]
    };
    let sharpest = found.sharpest;
    let mut lines = vec![
        format!("  stability   {stability}"),
        format!(
            "  energy      {:.6e} J: elastic {:.6e}, of the loads {:.6e}",
            found.elastic_energy + found.load_energy,
            found.elastic_energy,
            found.load_energy
        ),
        format!("  sharpest    {:.6e} 1/m at {:.6} m", sharpest.curvature, sharpest.at),
        format!("  sag         {:.6} m", found.sag),
    ];
    lines.extend(carried("on clamp   ", found.clamp_force, found.clamp_moment));
    lines.extend(carried("on the end ", found.end_force, found.end_moment));
    for (i, force) in found.place_forces.iter().enumerate() {
        lines.push(format!("  at place {i}  force {:.6e} N = {}", size(*force), vector(*force)));
    }
    lines
}
