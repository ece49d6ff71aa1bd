//! The report as one page of HTML that needs nothing else: its plots are inline SVG, it runs no scripts.

use super::plot::{MEASURES, Measure, over, sweep};
use super::svg::{escaped, number};
use super::{Figures, Outcome, Report, Row, Series};
use crate::voxelize::{METHODS, Promise};
use std::fmt::Write as _;

/// Which stations a part of the page is about.
type IsOf = fn(Series) -> bool;

const STYLE: &str = "\
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2329; background: #fbfaf8; max-width: 1120px; margin: 2.5rem auto; padding: 0 1.5rem; }
h1 { font-weight: 600; letter-spacing: -0.01em; margin-bottom: 0.2rem; } h2 { margin-top: 2.6rem; font-weight: 600; } h3 { margin: 1.6rem 0 0.4rem; font-weight: 600; }
p.about { color: #59636e; margin-top: 0; } code, pre { font: 13px/1.5 ui-monospace, monospace; } pre { background: #f0eee9; padding: 0.7rem 1rem; border-radius: 6px; overflow-x: auto; }
.plots { display: grid; grid-template-columns: 1fr 1fr; gap: 0.8rem 1.2rem; } @media (max-width: 820px) { .plots { grid-template-columns: 1fr; } }
svg { width: 100%; background: #fff; border: 1px solid #e6e2da; border-radius: 8px; }
svg .title { font: 600 13px system-ui, sans-serif; fill: #1d2329; } svg .tick { font: 11px system-ui, sans-serif; fill: #6b7580; } svg .name { font: 11px system-ui, sans-serif; }
svg .rule { stroke: #eeebe5; } svg .axis, svg .mark { stroke: #9aa3ab; } svg .line { fill: none; stroke-width: 1.7; } svg .leader { stroke-width: 0.6; opacity: 0.6; }
table { border-collapse: collapse; font-size: 13px; margin: 0.6rem 0; } th, td { text-align: right; padding: 0.16rem 0.7rem; border-bottom: 1px solid #eeebe5; } th { color: #59636e; font-weight: 500; }
th:first-child, td:first-child, td.text, th.text { text-align: left; } td.good { color: #007a55; } td.bad { color: #b3261e; } tr:hover td { background: #f4f1eb; }
details { margin: 0.8rem 0; } summary { cursor: pointer; color: #59636e; } .note { border-left: 3px solid #d55e00; padding-left: 0.8rem; }
";

/// The whole page.
#[must_use]
pub fn page(report: &Report) -> String {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>Voxelizers, measured</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>Voxelizers, measured</h1>\n"
    );
    head(report, &mut html);
    for (subject, body) in report.bodies.iter().enumerate() {
        // Writing to a string can't fail.
        let _ = writeln!(html, "<h2>{}</h2>\n<p class=\"about\">{} triangles</p>", escaped(&body.name), body.triangles);
        let is_grid: IsOf = |series| series == Series::Grid;
        plots(report, subject, is_grid, MEASURES, &mut html);
        table(report, subject, is_grid, "all figures, by grid", &mut html);
        let further: [(&str, IsOf); 2] = [
            ("Seen from elsewhere", |series| matches!(series, Series::Angle(..))),
            ("Grids of other shapes", |series| series == Series::Aspect),
        ];
        for (title, series) in further {
            if report.rows.iter().any(|row| row.subject == subject && series(row.station.series)) {
                let _ = writeln!(html, "<h3>{title}</h3>");
                plots(report, subject, series, &[MEASURES[0], MEASURES[2]], &mut html);
                table(report, subject, series, "all figures", &mut html);
            }
        }
    }
    growth(report, &mut html);
    if !report.sweep.1.is_empty() {
        cutoff(report, &mut html);
    }
    left_out(report, &mut html);
    methods(&mut html);
    html.push_str("</body>\n</html>\n");
    html
}

fn head(report: &Report, html: &mut String) {
    let (done, of) = report.steps;
    let _ = writeln!(
        html,
        "<p class=\"about\">on {}, {}; murrine {}</p>",
        escaped(&report.adapter),
        escaped(report.driver.trim()),
        env!("CARGO_PKG_VERSION")
    );
    if done < of {
        let _ = writeln!(
            html,
            "<p class=\"note\">The run was stopped after {done} of {of} steps: this is what there was.</p>"
        );
    }
    html.push_str(
        "<p>Each method marks the same grid over a body's bounding cube and is held against separating axes in f64 \
         (Akenine-Möller 2001), as in chapter 3 of Tripiana 2009. A voxel that the surface touches or not by less than \
         ±1e-6 of the grid's size is a tie, and no fault. An interior that a method makes is held against the parity \
         fill. Times are medians of up to five rounds after one that compiles; memory is the words that a method \
         writes and what it keeps. Solid lines: no option; dashed: the conservative option with the fewest faults.</p>\n",
    );
    let _ = writeln!(html, "<p>To measure it again:</p>\n<pre>{}</pre>", escaped(&report.command));
}

fn plots(report: &Report, subject: usize, series: IsOf, measures: &[Measure], html: &mut String) {
    html.push_str("<div class=\"plots\">\n");
    for measure in measures {
        html.push_str(&over(report, subject, series, *measure).svg());
    }
    html.push_str("</div>\n");
}

fn table(report: &Report, subject: usize, series: IsOf, title: &str, html: &mut String) {
    let _ = writeln!(
        html,
        "<details><summary>{title}</summary>\n<table>\n<tr><th>method<th>grid<th>ms<th>least<th>most<th>found<th>missing<th>spurious<th>ties<th>interior<th>missing<th>spurious<th>MiB</tr>"
    );
    for row in report.rows.iter().filter(|row| row.subject == subject && series(row.station.series)) {
        let _ = write!(html, "<tr><td>{}<td>{}", row.way.name(), row.station.name());
        match &row.outcome {
            Outcome::Measured(figures) => cells(row, figures, html),
            Outcome::LeftOut(why) => {
                let _ = writeln!(html, "<td class=\"text\" colspan=\"11\">{}</tr>", escaped(why));
            }
        }
    }
    html.push_str("</table></details>\n");
}

fn cells(row: &Row, figures: &Figures, html: &mut String) {
    let Figures { ms, faults, solid, bytes, .. } = figures;
    let solid = solid
        .map_or("<td>–<td>–<td>–".to_owned(), |s| format!("<td>{}<td>{}<td>{}", s.found, s.missing, s.spurious));
    let fault = |n: u64| {
        let exact = row.way.method.promise == Promise::Exact;
        let class = if n == 0 {
            " class=\"good\""
        } else if exact {
            " class=\"bad\""
        } else {
            ""
        };
        format!("<td{class}>{n}")
    };
    #[expect(clippy::cast_precision_loss, reason = "shown with one decimal")]
    let mib = bytes.map_or("–".to_owned(), |bytes| format!("{:.1}", bytes as f64 / f64::from(1 << 20)));
    let _ = writeln!(
        html,
        "<td>{:.2}<td>{:.2}<td>{:.2}<td>{}{}{}<td>{}{solid}<td>{mib}</tr>",
        ms.median,
        ms.min,
        ms.max,
        faults.found,
        fault(faults.missing),
        fault(faults.spurious),
        faults.ties
    );
}

/// How times grow from the coarsest grid to the finest (CL Table 1).
fn growth(report: &Report, html: &mut String) {
    let grids = report.rows.iter().filter(|row| row.station.series == Series::Grid).map(|row| row.station.cells.x);
    let (Some(least), Some(most)) = (grids.clone().min(), grids.max()) else { return };
    if least == most {
        return;
    }
    let _ = writeln!(
        html,
        "<h2>From {least}³ to {most}³</h2>\n<p class=\"about\">how many times longer each method takes (Chang &amp; Lai 2011, Table 1: slices by slices up to 240 times from 128³ to 512³, amplified slices 1.9 to 6.6)</p>\n<table>\n<tr><th>method"
    );
    for body in &report.bodies {
        let _ = write!(html, "<th>{}", escaped(&body.name));
    }
    html.push_str("</tr>\n");
    for method in METHODS {
        let ms = |subject: usize, cells: u32| {
            report.rows.iter().find_map(|row| match &row.outcome {
                Outcome::Measured(figures)
                    if row.subject == subject
                        && row.station.series == Series::Grid
                        && row.station.cells.x == cells
                        && row.way.is_plain()
                        && row.way.method.name == method.name =>
                {
                    Some(figures.ms.median)
                }
                _ => None,
            })
        };
        let ratios: Vec<Option<f64>> =
            (0..report.bodies.len()).map(|body| Some(ms(body, most)? / ms(body, least)?)).collect();
        if ratios.iter().any(Option::is_some) {
            let _ = write!(html, "<tr><td>{}", method.name);
            for ratio in ratios {
                let _ = write!(html, "<td>{}", ratio.map_or("–".to_owned(), |r| format!("{r:.1}×")));
            }
            html.push_str("</tr>\n");
        }
    }
    html.push_str("</table>\n");
}

fn cutoff(report: &Report, html: &mut String) {
    html.push_str("<h2>Hybrid's cut-off</h2>\n<p class=\"about\">Rauwendaal &amp; Bailey 2013, Figs. 13 and 14: triangles that cover more than this go to fragments</p>\n<div class=\"plots\">\n");
    html.push_str(&sweep(report).svg());
    html.push_str("<div><table>\n<tr><th>body<th>best, ms<th>at cells²<th>the device’s own choice, ms</tr>\n");
    for (subject, body) in report.bodies.iter().enumerate() {
        let points = || report.sweep.1.iter().filter(|p| p.subject == subject);
        let best = points().filter(|p| p.cutoff_cells2.is_some()).min_by(|a, b| a.ms.median.total_cmp(&b.ms.median));
        let own = points().find(|p| p.cutoff_cells2.is_none());
        if let (Some(best), Some(own)) = (best, own) {
            let at = best.cutoff_cells2.map_or(0.0, f64::from);
            let _ = writeln!(
                html,
                "<tr><td>{}<td>{:.2}<td>{}<td>{:.2}</tr>",
                escaped(&body.name),
                best.ms.median,
                number(at),
                own.ms.median
            );
        }
    }
    html.push_str("</table></div></div>\n");
}

fn left_out(report: &Report, html: &mut String) {
    let mut lines = Vec::new();
    for row in &report.rows {
        if let Outcome::LeftOut(why) = &row.outcome {
            let body = &report.bodies[row.subject].name;
            lines.push(format!(
                "<li>{}, {}, {}: {}</li>\n",
                escaped(body),
                row.station.name(),
                row.way.name(),
                escaped(why)
            ));
        }
    }
    if !lines.is_empty() {
        let _ = writeln!(
            html,
            "<h2>Left out</h2>\n<details><summary>{} measurements</summary><ul>\n{}</ul></details>",
            lines.len(),
            lines.concat()
        );
    }
}

fn methods(html: &mut String) {
    html.push_str("<h2>The methods</h2>\n<table>\n<tr><th>name<th class=\"text\">source<th class=\"text\">idea<th class=\"text\">promise</tr>\n");
    for method in METHODS {
        let promise = if method.promise == Promise::Exact { "exact" } else { "approximate" };
        let _ = writeln!(
            html,
            "<tr><td>{}<td class=\"text\">{}<td class=\"text\">{}<td class=\"text\">{promise}</tr>",
            method.name,
            escaped(method.paper.short),
            escaped(method.summary)
        );
    }
    html.push_str("</table>\n");
}
