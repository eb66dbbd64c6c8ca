//! Self-contained pages of tables and pictures, without scripts.

const STYLE: &str = "body{font:14px/1.45 system-ui,sans-serif;color:#1c2430;margin:2rem auto;max-width:64rem;padding:0 1rem;overflow-wrap:break-word}\
h1{font-size:1.5rem;margin-bottom:.2rem;overflow-wrap:anywhere}h2{font-size:1.1rem;margin-top:2rem}p{max-width:46rem}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:.15rem .7rem;text-align:right;border-bottom:1px solid #e3e7ec}\
th{font-weight:600;background:#f5f7f9}td:first-child,th:first-child{text-align:left}.scroll{overflow-x:auto}\
.curves{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(30rem,100%),1fr));gap:.5rem}\
.plot{overflow-x:auto}svg{width:100%;min-width:28rem;height:auto}summary{cursor:pointer;margin:.5rem 0}\
.figure{font-size:1.3rem;font-weight:600}.figures{display:flex;flex-wrap:wrap;gap:2rem}.figures span{display:block;color:#5a6675}";

/// A page of this title, which is also its first heading, with `body` below it.
pub fn document(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><title>{title}</title><style>{STYLE}</style></head><body>\n\
         <h1>{title}</h1>\n{body}</body></html>\n"
    )
}

/// Text as a page shows it.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
