//! The frame of a page, and data in it: JSON and binary columns in base64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

const STYLE: &str = include_str!("../assets/pages/page.css");
/// Script that all pages share.
const SHARED: &str = include_str!("../assets/pages/page.js");
/// Scripts of the page of a dataset, in the order in which they stand in it.
const DATASET: [&str; 13] = [
    include_str!("../assets/pages/table.js"),
    include_str!("../assets/pages/linked.js"),
    include_str!("../assets/pages/effects.js"),
    include_str!("../assets/pages/knowing.js"),
    include_str!("../assets/pages/model.js"),
    include_str!("../assets/pages/explore.js"),
    include_str!("../assets/pages/plan.js"),
    include_str!("../assets/pages/contours.js"),
    include_str!("../assets/pages/compare.js"),
    include_str!("../assets/pages/answer.js"),
    include_str!("../assets/pages/shock.js"),
    include_str!("../assets/pages/shocks.js"),
    include_str!("../assets/pages/report.js"),
];
/// Scripts of the page of a row.
const SCENE: [&str; 8] = [
    include_str!("../assets/pages/signals.js"),
    include_str!("../assets/pages/shock.js"),
    include_str!("../assets/pages/traces.js"),
    include_str!("../assets/pages/plan.js"),
    include_str!("../assets/pages/places.js"),
    include_str!("../assets/pages/mechanism.js"),
    include_str!("../assets/pages/side.js"),
    include_str!("../assets/pages/scene.js"),
];

/// Kind of page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scripts {
    /// Page of a dataset.
    Dataset,
    /// Page of a row.
    Scene,
}

/// Builds a page: title, metadata and data.
///
/// # Errors
/// Those of writing `meta` as JSON.
pub fn page(title: &str, scripts: Scripts, meta: &impl Serialize, data: &[u8]) -> Result<String, serde_json::Error> {
    // In JSON `<` stands in strings alone: no text can end the script's element or begin a comment.
    let meta = serde_json::to_string(meta)?.replace('<', "\\u003c");
    let title = escape(title);
    let own: &[&str] = match scripts {
        Scripts::Dataset => &DATASET,
        Scripts::Scene => &SCENE,
    };
    let scripts = format!("{SHARED}\n{}", own.join("\n"));
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<main id=\"page\"><noscript>This page draws its figures with a script; let it run to see them.</noscript></main>\n\
         <script type=\"application/json\" id=\"meta\">{meta}</script>\n\
         <script type=\"application/octet-stream\" id=\"data\">{}</script>\n\
         <script>\n'use strict';\n{scripts}</script>\n</body>\n</html>\n",
        STANDARD.encode(data)
    ))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::{Scripts, page};

    #[test]
    fn names_end_no_element() {
        let name = "</script><script>alert(\"Ü\")</script><!--";
        let page = page(name, Scripts::Scene, &[name], b"").expect("JSON");
        assert!(!page.contains("alert(\"Ü\")"), "a quote of a name stands as it is");
        assert_eq!(page.matches("<script>").count(), 1);
        assert!(page.contains("&lt;/script&gt;") && page.contains("\\u003c/script>"));
        assert!(!page.contains("<!--"));
    }
}
