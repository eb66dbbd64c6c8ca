//! Settings of a comparison.

/// Settings of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonSettings {
    /// Columns of the table of runs to compare; empty (default): all main outputs.
    pub outputs: Vec<String>,
    /// Relative difference from which on numbers without a measured scatter differ. Default 1e-4: between the settings of a solver
    /// that converges, outputs of periodic percussion move by less.
    pub relative: f64,
    /// Rows that are listed at most, of each kind; all are counted. Default 20.
    pub most: usize,
}

impl Default for ComparisonSettings {
    fn default() -> Self {
        Self { outputs: Vec::new(), relative: 1e-4, most: 20 }
    }
}
