//! The guide: help pages, printed by `decore help TOPIC`.

/// A help page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topic {
    /// Name of the topic, as in `decore help NAME`.
    pub name: &'static str,
    /// Summary in a few words.
    pub about: &'static str,
    /// Text in Markdown. A line such as `{DesignKind}` is replaced by table rows: the values of this definition in the study's schema,
    /// `{Units}` by a table of units.
    pub text: &'static str,
}

/// All topics, in the order of `decore help`.
pub const TOPICS: [Topic; 25] = [
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
        about: "the best values for your goal, and how certain they are",
        text: include_str!("best.md"),
    },
    Topic {
        name: "machine",
        about: "your own finite element matrices: formats, superelements, reduction, how many modes",
        text: include_str!("machine.md"),
    },
    Topic {
        name: "castings",
        about: "elastic castings: finite element models, points, core points, cut-off",
        text: include_str!("castings.md"),
    },
    Topic {
        name: "cores",
        about: "shock at the sand cores: spectra, doses, time until a core is out",
        text: include_str!("cores.md"),
    },
    Topic {
        name: "clamps",
        about: "castings on pads with clamps: lift-off, clamping force, materials of pads",
        text: include_str!("clamps.md"),
    },
    Topic {
        name: "directions",
        about: "strikes, fixtures and gravity that are not vertical",
        text: include_str!("directions.md"),
    },
    Topic {
        name: "outputs",
        about: "tables and columns, ranking, standard errors, signals of a sweep",
        text: include_str!("outputs.md"),
    },
    Topic {
        name: "measured",
        about: "compare your measurement with a row: offset, low-pass, spikes, differences",
        text: include_str!("measured.md"),
    },
    Topic {
        name: "reading",
        about: "read the tables in pandas, polars, DuckDB and pyarrow; JSON output",
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
        about: "stop and resume, repair, shards, Slurm, HyperQueue, exit codes",
        text: include_str!("sweeps.md"),
    },
    Topic {
        name: "sensitivity",
        about: "rank factors by their influence: Sobol' indices, elementary effects, Shapley effects",
        text: include_str!("sensitivity.md"),
    },
    Topic {
        name: "surrogate",
        about: "predict results without running them: models, their errors, predictions",
        text: include_str!("surrogate.md"),
    },
    Topic {
        name: "features",
        about: "a flat table to train predictors: figures per casting, dictionary, groups and splits",
        text: include_str!("features.md"),
    },
    Topic {
        name: "refine",
        about: "add rows where they help most: learn, optimise within limits, find boundaries and failures",
        text: include_str!("refine.md"),
    },
    Topic {
        name: "accuracy",
        about: "presets and their errors, numerical error of a row, methods, growth of time",
        text: include_str!("accuracy.md"),
    },
    Topic {
        name: "theory",
        about: "the model, equation by equation; the definition of each output",
        text: include_str!("theory.md"),
    },
    Topic {
        name: "processors",
        about: "processors: equal bytes, nodes with many cores, GPUs",
        text: include_str!("processors.md"),
    },
    Topic {
        name: "paper",
        about: "compare decore with the results of the paper: figures, differences, causes",
        text: include_str!("paper.md"),
    },
    Topic { name: "limits", about: "limits of the model and the program", text: include_str!("limits.md") },
    Topic { name: "glossary", about: "definitions of the words that decore uses", text: include_str!("glossary.md") },
];
