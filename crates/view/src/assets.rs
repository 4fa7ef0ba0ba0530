//! Files of the web page, built from `view/src` by `view/build.sh` and embedded in the program.

/// A file of the web page.
pub struct Asset {
    pub path: &'static str,
    pub kind: &'static str,
    pub content: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
pub const TEXT: &str = "text/plain; charset=utf-8";

macro_rules! built {
    ($path:literal, $file:literal, $kind:ident) => {
        Asset { path: $path, kind: $kind, content: include_bytes!(concat!("../../../view/dist/", $file)) }
    };
}

pub const ASSETS: [Asset; 4] = [
    built!("/", "index.html", HTML),
    built!("/view.js", "view.js", SCRIPT),
    built!("/view.css", "view.css", STYLE),
    built!("/licences.txt", "licences.txt", TEXT),
];
