//! The guide: pages for people who use the program, as `decore help TOPIC` prints them.

/// One page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topic {
    /// What it is asked for by.
    pub name: &'static str,
    /// What it tells, in a few words.
    pub about: &'static str,
    /// The page, as Markdown; a line `{DesignKind}` stands for the rows of a table of what the study's schema declares by that name, a
    /// line `{Units}` for the rows of a table of units.
    pub text: &'static str,
}

/// All pages.
pub const TOPICS: [Topic; 24] = [
    Topic {
        name: "study",
        about: "every key of a study file: unit, default, description",
        text: include_str!("study.md"),
    },
    Topic {
        name: "units",
        about: "units of keys and factors, and which units are converted",
        text: include_str!("units.md"),
    },
    Topic {
        name: "best",
        about: "the best values for your goal, and how sure they are",
        text: include_str!("best.md"),
    },
    Topic {
        name: "machine",
        about: "your own finite element matrices: formats, superelements, reduction, how many modes",
        text: include_str!("machine.md"),
    },
    Topic {
        name: "castings",
        about: "castings that bend: finite element models, points, core points, cut-off",
        text: include_str!("castings.md"),
    },
    Topic {
        name: "cores",
        about: "what reaches the sand cores: shock spectra, doses, when a core is out",
        text: include_str!("cores.md"),
    },
    Topic {
        name: "clamps",
        about: "castings that lie on pads and are pressed down: lift-off, clamping force, materials of pads",
        text: include_str!("clamps.md"),
    },
    Topic {
        name: "outputs",
        about: "what each name of the tables means, column by column",
        text: include_str!("outputs.md"),
    },
    Topic {
        name: "measured",
        about: "a measurement beside a row's signals: offset, low-pass, spikes, differences",
        text: include_str!("measured.md"),
    },
    Topic {
        name: "reading",
        about: "the tables in pandas, polars, DuckDB and pyarrow",
        text: include_str!("reading.md"),
    },
    Topic {
        name: "python",
        about: "studies, sweeps, tables and functions over arrays from Python",
        text: include_str!("python.md"),
    },
    Topic { name: "scatter", about: "which differences between rows are real", text: include_str!("scatter.md") },
    Topic {
        name: "designs",
        about: "kinds of design, factors, constraints, growing a sweep",
        text: include_str!("designs.md"),
    },
    Topic {
        name: "sweeps",
        about: "stopping and going on, shards, Slurm, HyperQueue, exit codes",
        text: include_str!("sweeps.md"),
    },
    Topic {
        name: "sensitivity",
        about: "which factor matters: Sobol' indices, elementary effects, Shapley effects",
        text: include_str!("sensitivity.md"),
    },
    Topic {
        name: "surrogate",
        about: "what a row not run would give: models, their errors, predictions",
        text: include_str!("surrogate.md"),
    },
    Topic {
        name: "features",
        about: "a flat table for predictors: figures per casting, dictionary, groups and splits",
        text: include_str!("features.md"),
    },
    Topic {
        name: "refine",
        about: "which row to run next: models that learn, optima under limits, boundaries of limits and of failures",
        text: include_str!("refine.md"),
    },
    Topic {
        name: "accuracy",
        about: "presets and what they promise, methods, how time grows",
        text: include_str!("accuracy.md"),
    },
    Topic {
        name: "theory",
        about: "the model, equation by equation; the definition of each output",
        text: include_str!("theory.md"),
    },
    Topic {
        name: "processors",
        about: "which bytes are the same where; what GPUs and nodes of many cores would need",
        text: include_str!("processors.md"),
    },
    Topic {
        name: "paper",
        about: "the publication of the model beside decore: figures, differences, why",
        text: include_str!("paper.md"),
    },
    Topic { name: "limits", about: "what decore does not do", text: include_str!("limits.md") },
    Topic { name: "glossary", about: "terms, one word for one thing", text: include_str!("glossary.md") },
];
