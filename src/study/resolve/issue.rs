//! Problems that prevent a scene.

/// Something that keeps a study from being a scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Issue {
    /// Path of the offending quantity.
    pub path: String,
    pub message: String,
    pub nearest: Option<String>,
    /// Whether only this row has the fault (a hammer that misses its casting), not the study.
    pub row_only: bool,
}

impl Issue {
    pub fn new(path: String, message: impl Into<String>) -> Self {
        Self { path, message: message.into(), nearest: None, row_only: false }
    }
}
