//! Figures, their checks and what is not run as one page.

use crate::report::{Criterion, Figure, FigureEntry};

/// What a program leaves out of what could be asked of it.
pub struct NotRun {
    /// What it is.
    pub title: &'static str,
    /// Why it is not run.
    pub why: &'static str,
}

const STYLE: &str = "body{font:15px/1.4 sans-serif;max-width:60em;margin:2em auto;color:#222}\
table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.2em .6em;\
text-align:left}img{max-width:100%}.FAIL{color:#b00;font-weight:bold}";

/// The page of figures, whose drawings lie beside it.
pub(crate) fn page<D>(figures: &[(&FigureEntry<D>, Figure)], not_run: &[NotRun]) -> String {
    let checks = || figures.iter().flat_map(|(_, figure)| &figure.checks);
    let failed = checks().filter(|check| !check.holds()).count();
    let count = checks().count();
    let verdict = if failed == 0 {
        format!("All {count} checks hold.")
    } else {
        format!("{failed} of {count} checks fail.")
    };
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>What was compared</title>\n\
         <style>{STYLE}</style>\n<h1>What was compared</h1>\n<p>{verdict}</p>\n"
    );
    for (entry, figure) in figures {
        text += &format!(
            "<h2>{}</h2>\n<p>{}; {}.</p>\n<table>\n<tr><th>compared<th>obtained<th>criterion\
             <th>by<th></tr>\n",
            escaped(entry.title),
            escaped(figure.scene),
            escaped(figure.parameters)
        );
        for check in &figure.checks {
            let verdict = match (check.holds(), check.criterion) {
                (false, _) => "FAIL",
                (true, Criterion::Told) => "told",
                (true, _) => "pass",
            };
            text += &format!(
                "<tr><td>{}<td>{} {}<td>{}<td>{}<td class=\"{verdict}\">{verdict}</tr>\n",
                escaped(&check.compared),
                check.told(),
                escaped(check.unit),
                escaped(&check.criterion.to_string()),
                escaped(check.thesis)
            );
        }
        text += &format!("</table>\n<p><img src=\"{0}.svg\" alt=\"{0}\"></p>\n", entry.number);
    }
    if !not_run.is_empty() {
        text += "<h2>What is not run</h2>\n<ul>\n";
        for one in not_run {
            text += &format!("<li>{}: not run; {}.</li>\n", escaped(one.title), escaped(one.why));
        }
        text += "</ul>\n";
    }
    text + "</html>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check;

    #[test]
    fn a_page_tells_what_fails_and_what_is_not_run() {
        let entry = FigureEntry { number: "1", title: "a < b", draw: () };
        let checks = vec![check("c", 3.0, "m", Criterion::AtMost(2.0), "d")];
        let figure = Figure { scene: "s", parameters: "p", drawings: Vec::new(), checks };
        let not_run = [NotRun { title: "e", why: "f" }];
        let page = page(&[(&entry, figure)], &not_run);
        for words in
            ["1 of 1 checks fail", "a &lt; b", "&lt;= 2", "FAIL", "1.svg", "e: not run; f."]
        {
            assert!(page.contains(words), "{words} in {page}");
        }
    }
}
