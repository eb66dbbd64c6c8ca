//! Figures of a casting in a run: declared once, each with its source columns in the dataset.

use super::column::Role;
use super::struck::Struck;
use decore_model::metrics::{Aggregates, CastingMetrics, HammerMetrics, RunTotals};
use decore_model::run::RowOutcome;
use decore_quantity::Kind;

/// Combination of the values of several hammers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Combine {
    /// Sum; hammers without a value are left out.
    Sum,
    /// Mean of the hammers that have a value.
    Mean,
    /// The least.
    Least,
    /// The largest.
    Largest,
    /// Standard error of the mean of independent values: the root of the sum of squares over their number.
    ErrorOfMean,
}

impl Combine {
    /// The values of the hammers as one; `None` without any, but for sums.
    pub fn of(self, values: impl Iterator<Item = f64>) -> Option<f64> {
        let values: Vec<f64> = values.collect();
        let count = values.len() as f64;
        let sum = || values.iter().fold(0.0, |sum, value| sum + value);
        match self {
            Self::Sum => Some(sum()),
            _ if values.is_empty() => None,
            Self::Mean => Some(sum() / count),
            Self::Least => values.into_iter().reduce(f64::min),
            Self::Largest => values.into_iter().reduce(f64::max),
            Self::ErrorOfMean => Some(values.iter().map(|value| value * value).sum::<f64>().sqrt() / count),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Sum => "sum",
            Self::Mean => "mean",
            Self::Least => "least",
            Self::Largest => "largest",
            Self::ErrorOfMean => "root of the sum of squares over the number",
        }
    }
}

/// Source of a figure.
#[derive(Clone, Copy)]
pub(super) enum Origin<'a> {
    /// A column of `runs` that is about the run.
    Run(&'a str),
    /// A column of `runs` of the casting, by the name of its quantity.
    Casting(&'a str),
    /// Columns of `runs` of the hammers that strike the casting, by the name of their quantity.
    Hammers(&'a str, Combine),
    /// Number of hammers that strike the casting.
    HammerCount,
    /// Real number of the blows on the casting.
    Blows(fn(&Struck) -> Option<f64>, &'static str),
    /// Number of blows on the casting.
    BlowCount(fn(&Struck) -> u64, &'static str),
}

impl<'a> Origin<'a> {
    /// The quantity of hammers or castings that it is made from.
    pub fn quantity(self) -> Option<&'a str> {
        match self {
            Self::Casting(quantity) | Self::Hammers(quantity, _) => Some(quantity),
            _ => None,
        }
    }
}

/// A figure of a casting in a run.
#[derive(Clone, Copy)]
pub(super) struct CastingFigure<'a> {
    /// Name of its column.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Description in words.
    pub description: &'static str,
    /// Source of the figure.
    pub origin: Origin<'a>,
    /// Role of the column.
    pub role: Role,
    /// Least value that can be right.
    pub least: Option<f64>,
    /// Combination of the scatters of several hammers; `None` if the figure has no scatter.
    pub scatter: Option<Combine>,
    /// Name of the hammers' standard errors, where the figure is their mean.
    pub error: Option<&'static str>,
    /// Columns that it follows from where every blow that reaches the casting is in the dose.
    pub without_threshold: &'static [&'static str],
}

/// A target that cannot be negative, without scatter.
const fn target(
    name: &'static str,
    unit: &'static str,
    origin: Origin<'static>,
    description: &'static str,
) -> CastingFigure<'static> {
    CastingFigure {
        name,
        unit,
        description,
        origin,
        role: Role::Target,
        least: Some(0.0),
        scatter: None,
        error: None,
        without_threshold: &[],
    }
}

impl<'a> CastingFigure<'a> {
    /// Adds its uncertainty, from another source.
    pub fn sureness(self, origin: Origin<'a>) -> Self {
        Self { origin, role: Role::Scatter, least: Some(0.0), without_threshold: &[], ..self }
    }

    /// With a scatter.
    const fn scattering(self, combine: Combine) -> Self {
        Self { scatter: Some(combine), ..self }
    }

    /// With a standard error.
    const fn erring(self, error: &'static str) -> Self {
        Self { error: Some(error), ..self }
    }

    /// A part of the dose, which without a threshold follows from other columns.
    const fn of_dose(self, without_threshold: &'static [&'static str]) -> Self {
        Self { without_threshold, ..self }
    }

    /// A target that may be negative.
    const fn signed(self) -> Self {
        Self { least: None, ..self }
    }

    const fn status(self) -> Self {
        Self { role: Role::Status, ..self }
    }

    /// Type of its values, if no column of `runs` gives it.
    pub fn kind(&self) -> Kind {
        match self.origin {
            Origin::HammerCount | Origin::BlowCount(..) => Kind::Count,
            _ => Kind::Real,
        }
    }

    /// Formula from the tables of the dataset, in words.
    pub fn formula(&self) -> String {
        match self.origin {
            Origin::Run(column) => format!("runs.{column}"),
            Origin::Casting(quantity) => format!("runs.CASTING_{quantity}"),
            Origin::Hammers(quantity, combine) => {
                format!("{} of runs.HAMMER_{quantity} over the hammers on the casting", combine.words())
            }
            Origin::HammerCount => "number of hammers on the casting".to_owned(),
            Origin::Blows(_, formula) | Origin::BlowCount(_, formula) => formula.to_owned(),
        }
    }
}

use Combine::{Largest, Least, Mean, Sum};
use Origin::{BlowCount, Blows, Casting, HammerCount, Hammers, Run};

/// All figures, in the order of their columns.
pub(super) const FIGURES: &[CastingFigure<'static>] = &[
    target("hammers", "1", HammerCount, "Number of hammers that strike the casting."),
    target(
        "work_j",
        "J",
        Hammers(HammerMetrics::delivered_work_j.name, Sum),
        "Work delivered to the casting over the whole run.",
    )
    .signed()
    .scattering(Sum),
    target(
        "impulse_n_s",
        "N s",
        Hammers(HammerMetrics::delivered_impulse_n_s.name, Sum),
        "Impulse of the forces between chisels and casting over the whole run.",
    )
    .scattering(Sum),
    target(
        "strike_energy_j",
        "J",
        Casting(CastingMetrics::strike_energy_j.name),
        "Energy given to the casting by the strikes of all blows on it.",
    )
    .scattering(Sum),
    target(
        "work_in_windows_j",
        "J",
        Blows(|struck| Some(struck.work_j), "sum of blows.work_j"),
        "Work delivered to the casting within the windows of its blows, without the time between blows.",
    )
    .signed(),
    target(
        STRUCK_BLOWS,
        "1",
        BlowCount(|struck| struck.blows, "number of blows whose kind is not blank"),
        "Number of blows that reached the casting, impacts of strokes and settling ones included.",
    ),
    target(
        "blank_blows",
        "1",
        BlowCount(|struck| struck.blank, "number of blows whose kind is blank"),
        "Number of blows that did not reach the casting.",
    ),
    target(
        BLOW_ENERGY_MEAN,
        "J",
        Blows(|struck| struck.energy.mean(), "mean of blows.energy_j, blank ones left out"),
        "Mean energy of the blows that reached the casting.",
    ),
    target(
        "blow_energy_max_j",
        "J",
        Blows(|struck| struck.energy.largest(), "largest of blows.energy_j, blank ones left out"),
        "Largest energy of the blows that reached the casting.",
    ),
    target(
        "blow_energy_std_j",
        "J",
        Blows(|struck| struck.energy.spread(), "standard deviation (n - 1) of blows.energy_j, blank ones left out"),
        "Spread of the energy of the blows that reached the casting; null for fewer than two.",
    ),
    target(
        "peak_force_mean_n",
        "N",
        Blows(|struck| struck.force.mean(), "mean of blows.peak_force_n, blank ones left out"),
        "Mean of the blows' largest forces on the casting.",
    ),
    target(
        "peak_force_max_n",
        "N",
        Blows(|struck| struck.force.largest(), "largest of blows.peak_force_n, blank ones left out"),
        "Largest force of a blow on the casting.",
    ),
    target(
        "peak_force_std_n",
        "N",
        Blows(|struck| struck.force.spread(), "standard deviation (n - 1) of blows.peak_force_n, blank ones left out"),
        "Spread of the blows' largest forces on the casting; null for fewer than two.",
    ),
    target(
        "dose_j",
        "J",
        Blows(
            |struck| Some(struck.dose_j),
            "sum of blows.energy_j where it is at least the threshold, blank ones left out",
        ),
        "Dose: energy of the blows that reached the casting with at least the threshold's energy.",
    )
    .of_dose(&[BLOW_ENERGY_MEAN, STRUCK_BLOWS]),
    target(
        "dose_blows",
        "1",
        BlowCount(
            |struck| struck.dose_blows,
            "number of blows whose energy_j is at least the threshold, blank ones left out",
        ),
        "Number of blows that reached the casting with at least the threshold's energy.",
    )
    .of_dose(&[STRUCK_BLOWS]),
    target(
        TIME_TO_WORK,
        "s",
        Blows(
            |struck| struck.reached_s,
            "blows.start_time_s of the first blow with which the sum of blows.work_j in the order of start reaches the work",
        ),
        "Time to reach the given work: start of the blow within whose window it is reached; null if it is not.",
    ),
    target(
        "first_impact_time_s",
        "s",
        Hammers(HammerMetrics::first_impact_time_s.name, Least),
        "Start of the earliest first impact on the casting.",
    )
    .scattering(Largest),
    target(
        "first_impact_energy_j",
        "J",
        Hammers(HammerMetrics::first_impact_energy_j.name, Sum),
        "Energy of the hammers' first impacts on the casting; a hammer without one adds nothing.",
    )
    .scattering(Sum),
    target(
        "hit_frequency_mean_hz",
        "Hz",
        Hammers(HammerMetrics::hit_frequency_hz.name, Mean),
        "Mean hit frequency of the hammers on the casting that have one.",
    )
    .scattering(Mean),
    target(
        "periodic_energy_mean_j",
        "J",
        Hammers(HammerMetrics::periodic_energy_mean_j.name, Mean),
        "Mean over the hammers on the casting of their mean energy of a periodic blow.",
    )
    .scattering(Mean)
    .erring(HammerMetrics::periodic_energy_mean_error_j.name),
    target(
        "periodic_work_mean_j",
        "J",
        Hammers(HammerMetrics::periodic_work_mean_j.name, Mean),
        "Mean over the hammers on the casting of their mean work of a periodic blow.",
    )
    .signed()
    .scattering(Mean)
    .erring(HammerMetrics::periodic_work_mean_error_j.name),
    target(
        "periodic_peak_force_mean_n",
        "N",
        Hammers(HammerMetrics::periodic_peak_force_mean_n.name, Mean),
        "Mean over the hammers on the casting of the mean largest force of a periodic blow.",
    )
    .scattering(Mean)
    .erring(HammerMetrics::periodic_peak_force_mean_error_n.name),
    target(
        "least_percussion",
        "",
        Run(Aggregates::least_percussion.name),
        "The least sound percussion of all hammers of the run.",
    ),
    target(
        "peak_velocity_m_s",
        "m/s",
        Casting(CastingMetrics::peak_velocity_m_s.name),
        "Largest absolute heave velocity of the casting.",
    )
    .scattering(Sum),
    target(
        "peak_point_velocity_m_s",
        "m/s",
        Casting(CastingMetrics::peak_point_velocity_m_s.name),
        "Largest absolute velocity of the casting's points struck, held or measured, rotations included.",
    )
    .scattering(Sum),
    target(
        "measuring_point_peak_velocity_m_s",
        "m/s",
        Casting(CastingMetrics::measuring_point_peak_velocity_m_s.name),
        "Largest absolute velocity at the casting's measuring point, where one is chosen.",
    ),
    target(
        "arm_rms_extension_max_m_s",
        "m/s",
        Hammers(HammerMetrics::arm_rms_extension_m_s.name, Largest),
        "Machine: largest root mean square of the velocity of the mounts over the casting, before the first impacts.",
    )
    .scattering(Largest),
    target(
        "arm_rms_hammering_max_m_s",
        "m/s",
        Hammers(HammerMetrics::arm_rms_hammering_m_s.name, Largest),
        "Machine: the same from the first impacts to the end of the run.",
    )
    .scattering(Largest),
    target(
        "arm_rms_steady_max_m_s",
        "m/s",
        Hammers(HammerMetrics::arm_rms_steady_m_s.name, Largest),
        "Machine: the same between periodic blows, once the impacts have decayed.",
    )
    .scattering(Largest),
    target("modes", "1", Run(RowOutcome::modes.name), "Machine: modes of the structure that were kept."),
    target(
        "air_used_nl",
        "NL",
        Hammers(HammerMetrics::air_used_nl.name, Sum),
        "Air drawn by the hammers on the casting, in standard litres.",
    ),
    target(
        "energy_residual",
        "1",
        Run(RunTotals::energy_residual.name),
        "Audit: error of the energy balance, over the supplied work.",
    )
    .signed()
    .status(),
    target(
        "chamber_residual",
        "1",
        Run(RunTotals::chamber_residual.name),
        "Audit: error of the balance of a chamber's gas, the largest over the chambers.",
    )
    .status(),
];

const STRUCK_BLOWS: &str = "struck_blows";
const BLOW_ENERGY_MEAN: &str = "blow_energy_mean_j";
/// Name of the column that exists only with `--work-j`.
pub(super) const TIME_TO_WORK: &str = "time_to_work_s";
