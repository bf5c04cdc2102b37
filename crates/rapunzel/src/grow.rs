use crate::arguments::GrowOptions;
use crate::failure::Failure;
use crate::words::{complain, growth_stage, say, spinner};
use rapunzel_sim::style::{self, GrowthStage, StyleReport};
use std::path::Path;
use std::process::ExitCode;

/// Grows a style into a folder.
pub(crate) fn grow(options: &GrowOptions, json: bool) -> Result<ExitCode, Failure> {
    let path = &options.style;
    let spec = style::read(path).map_err(Failure::of(path))?;
    let folder = options
        .out
        .clone()
        .unwrap_or_else(|| Path::new("runs").join(path.file_stem().unwrap_or_default()));
    let bar = spinner(json);
    let at = |stage: GrowthStage| bar.set_message(growth_stage(stage));
    let beside = path.parent().unwrap_or(Path::new("."));
    let grown = style::grow(&spec, beside, &at);
    bar.set_message("files");
    let saved = grown.and_then(|grown| style::save(&grown, &folder).map(|()| grown.report));
    bar.finish_and_clear();
    let report = saved.map_err(Failure::of(path))?;
    if json {
        say(&serde_json::json!({ "folder": folder, "report": numbers(&report) }).to_string())?;
    } else {
        say(&format!("{report}\n  results     {}", folder.display()))?;
    }
    if !report.guides_without_place.is_empty() {
        let count = report.guides_without_place.len();
        complain(&format!(
            "warning: {count} guides found no place between head and hair; their pores grow along \
             their neighbors"
        ));
    }
    Ok(ExitCode::SUCCESS)
}

fn numbers(report: &StyleReport) -> serde_json::Value {
    let mended =
        report.mended.iter().map(|(what, done)| (what.to_string(), done.to_string().into()));
    serde_json::json!({
        "scalp_area": report.scalp_area,
        "scalp_off": report.scalp_off,
        "scalp_bare": report.bare,
        "hairs": report.count,
        "hairs_without_place": report.hairs.without_place,
        "length_asked": report.asked,
        "length": report.hairs.length,
        "segments": report.hairs.segments,
        "segments_in_head": report.hairs.in_head,
        "length_outside": report.hairs.outside,
        "pre_guides": report.pre_guides,
        "pre_guides_without_place": report.pre_guides_without_place,
        "guides": report.guides,
        "guides_without_place": report.guides_without_place,
        "equilibria": report.equilibria,
        "histogram": report.histogram.voxels,
        "gini": report.histogram.gini(),
        "fit": report.fit.as_ref().map(ToString::to_string),
        "mended": mended.collect::<serde_json::Map<_, _>>(),
        "crossed": report.crossed.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
