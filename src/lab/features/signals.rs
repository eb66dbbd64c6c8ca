//! Figures from the stored means of a casting's heave velocity, run by run.

use std::collections::HashMap;

use super::column::{FeatureColumn, Role};
use super::error::FeaturesError;
use super::octaves::{BANDS, HIGHEST, LEAST_LINES, Octave};
use decore_dataset::{DatasetReader, RowRecord, SignalColumn, TableName};
use decore_model::metrics::{CastingNames, CastingSignals, Instant, Signal, SignalOf, signal_list};
use decore_quantity::{Cell, CellColumn, Kind, Value};
use decore_statistics::signal::Spectrum;

/// Figures without the bands.
const PLAIN: usize = 3;

/// Figures of a casting's heave velocity in a run, in the order of [`SignalRows::columns`].
pub(super) type HeaveFigures = [Option<f64>; PLAIN + BANDS];

/// The means of a run.
struct Means {
    row: u64,
    /// Interval in s; `None` until the second instant, which is that much after 0.
    interval_s: Option<f64>,
    /// Heave velocity in m/s of the castings that have it, instant by instant.
    velocities: Vec<Vec<f64>>,
}

impl Means {
    fn push(&mut self, time_s: f64, velocities: &[Cell<'_>]) {
        if self.velocities.first().is_some_and(|first| first.len() == 1) {
            self.interval_s = Some(time_s);
        }
        let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).unwrap_or(f64::NAN);
        self.velocities.iter_mut().zip(velocities).for_each(|(values, cell)| values.push(number(cell)));
    }
}

/// The figures of all runs whose signals are kept.
#[derive(Default)]
pub(super) struct SignalRows {
    /// Interval of the means in s; `None`: there are none.
    pub interval_s: Option<f64>,
    /// Places of the castings with a stored heave velocity.
    castings: Vec<usize>,
    /// Figures of these castings in each row.
    rows: HashMap<u64, Vec<HeaveFigures>>,
}

impl SignalRows {
    /// Reads the table of signals; needs memory for the means of one run.
    ///
    /// # Errors
    /// Those of reading.
    pub fn read(reader: &DatasetReader) -> Result<Self, FeaturesError> {
        let (castings, columns): (Vec<usize>, Vec<&str>) = velocities(reader).into_iter().unzip();
        let mut found = Self { castings, ..Self::default() };
        if columns.is_empty() {
            return Ok(found);
        }
        let names = [&[RowRecord::row.name, Instant::time_s.name][..], &columns].concat();
        let (mut run, mut fault): (Option<Means>, _) = (None, None);
        reader.visit(TableName::Signals, &names, |cells| {
            let [Some(Value::Count(row)), Some(Value::Real(time_s)), velocities @ ..] = cells else { return };
            if run.as_ref().is_none_or(|run| run.row != *row) {
                let next = Means { row: *row, interval_s: None, velocities: vec![Vec::new(); columns.len()] };
                // The rows of a run follow each other.
                fault = fault.take().or(run.replace(next).and_then(|ended| found.take(&ended).err()));
            }
            run.iter_mut().for_each(|run| run.push(*time_s, velocities));
        })?;
        match fault.or(run.and_then(|ended| found.take(&ended).err())) {
            Some(error) => Err(error),
            None => Ok(found),
        }
    }

    fn take(&mut self, run: &Means) -> Result<(), FeaturesError> {
        // A run of one instant carries no information.
        let Some(interval_s) = run.interval_s else { return Ok(()) };
        let figures = run.velocities.iter().map(|values| figures(values, interval_s)).collect();
        self.rows.insert(run.row, figures);
        self.interval_s = Some(interval_s);
        Ok(())
    }

    /// The figures of a casting, by its place, in a row; `None` if its signals are not kept.
    pub fn of(&self, row: u64, casting: usize) -> Option<&HeaveFigures> {
        let place = self.castings.iter().position(|kept| *kept == casting)?;
        self.rows.get(&row)?.get(place)
    }

    /// The columns of the figures that some run has, without values, each with its place among them.
    pub fn columns(&self) -> Vec<(usize, FeatureColumn)> {
        let Some(interval_s) = self.interval_s else { return Vec::new() };
        let bands = Octave::all().into_iter().map(|band| in_band(band, interval_s));
        let is_there = |place: usize| self.rows.values().flatten().any(|figures| figures[place].is_some());
        plain(interval_s).into_iter().chain(bands).enumerate().filter(|(place, _)| is_there(*place)).collect()
    }
}

/// The castings, by their places, whose heave velocity is in the table of signals, with its column.
fn velocities(reader: &DatasetReader) -> Vec<(usize, &str)> {
    let info = &reader.manifest().study;
    let castings: Vec<CastingNames<'_>> =
        info.castings.iter().map(|name| CastingNames { name, fixtures: Vec::new(), cores: Vec::new() }).collect();
    let column = |signal: &Signal| {
        let SignalOf::Casting(casting) = signal.of else { return None };
        let name = SignalColumn::of(signal, 0.0).name;
        let kept = info.signals.iter().find(|kept| kept.name == name)?;
        (signal.quantity == CastingSignals::heave_velocity_m_s.name).then_some((casting, kept.name.as_str()))
    };
    signal_list(&[], &castings, &[]).iter().filter_map(column).collect()
}

/// The figures of means over `interval_s`, one every `interval_s`; none of a velocity with a gap.
fn figures(means: &[f64], interval_s: f64) -> HeaveFigures {
    let mut found: HeaveFigures = [None; PLAIN + BANDS];
    if !means.iter().all(|value| value.is_finite()) {
        return found;
    }
    // The first and the last mean are over a part of the interval.
    let whole = means.get(1..means.len().saturating_sub(1)).unwrap_or(&[]);
    let accelerations: Vec<f64> = whole.windows(2).map(|pair| (pair[1] - pair[0]) / interval_s).collect();
    found[0] = rms(means);
    found[1] = accelerations.iter().map(|value| value.abs()).reduce(f64::max);
    found[2] = rms(&accelerations);
    let spectrum = Spectrum::of(means, interval_s);
    for (place, band) in found.iter_mut().skip(PLAIN).zip(Octave::all()) {
        *place = band.rms(&spectrum, interval_s);
    }
    found
}

/// Root mean square; `None` of nothing.
fn rms(values: &[f64]) -> Option<f64> {
    let mean = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
    (!values.is_empty()).then(|| mean.sqrt())
}

/// A target that cannot be negative.
pub(super) fn not_negative(name: String, unit: &str, (description, formula): (String, String)) -> FeatureColumn {
    FeatureColumn {
        name,
        unit: unit.to_owned(),
        role: Role::Target,
        description,
        formula,
        valid: [Some(0.0), None],
        derived_from: Vec::new(),
        values: CellColumn::new(Kind::Real),
    }
}

/// The columns without the bands.
fn plain(interval_s: f64) -> [FeatureColumn; PLAIN] {
    let velocity = "signals.CASTING_heave_velocity_m_s";
    let differences = format!(
        "of (v(t + T) - v(t)) / T over the run's values v of {velocity} but the first and the last, T = {interval_s} s"
    );
    let about = format!(
        "differences of successive means of the casting's heave velocity over T = {interval_s} s, by T: its acceleration averaged \
         over 2 T with a triangle as weight"
    );
    [
        not_negative(
            "heave_velocity_rms_m_s".to_owned(),
            "m/s",
            (
                format!(
                    "Root mean square of the means of the casting's heave velocity over {interval_s} s, over the whole \
                     run, at all frequencies and without correction: it cannot be computed from the values in \
                     bands."
                ),
                format!("root of the mean of the squares of the run's values of {velocity}"),
            ),
        ),
        not_negative(
            "heave_acceleration_peak_m_s2".to_owned(),
            "m/s2",
            (format!("Largest absolute value of the {about}."), format!("largest absolute value {differences}")),
        ),
        not_negative(
            "heave_acceleration_rms_m_s2".to_owned(),
            "m/s2",
            (format!("Root mean square of the {about}."), format!("root of the mean of the squares {differences}")),
        ),
    ]
}

/// The column of a band.
fn in_band(band: Octave, interval_s: f64) -> FeatureColumn {
    let ([low, high], [low_hz, high_hz]) = (band.edges, band.edges_hz());
    let nominal = band.nominal_hz;
    not_negative(
        format!("heave_velocity_rms_{}_hz_m_s", nominal.to_string().replace('.', "_")),
        "m/s",
        (
            format!(
                "Root mean square of the casting's heave velocity in the octave band around {nominal} Hz (IEC 61260-1: {low_hz:.1} to \
                 {high_hz:.1} Hz), over the whole run; from means over {interval_s} s, corrected for their gain. Bands end at {HIGHEST} of \
                 half the sampling rate; null for fewer than {LEAST_LINES} spectral lines."
            ),
            format!(
                "root of the sum of 2 |X_k|^2 / (n g(f_k))^2 over the lines f_k = k / (n T) from 1000 G^{low} to 1000 G^{high} Hz, \
                 G = 10^0.3; X: discrete Fourier transform of the run's n values of signals.CASTING_heave_velocity_m_s (less their mean, \
                 which is in no band), g(f) = sin(pi f T) / (pi f T): the gain of means over T = {interval_s} s"
            ),
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a quarter of the sampling rate all differences of a cosine have its amplitude; differences of a ramp have its slope.
    #[test]
    fn analytic_accelerations() {
        let interval_s = 0.25;
        let cosine: Vec<f64> = (0..40).map(|k| [3.0, 0.0, -3.0, 0.0][k % 4]).collect();
        let found = figures(&cosine, interval_s);
        let expected = [4.5_f64.sqrt(), 12.0, 12.0].map(Some);
        assert_eq!(found[..PLAIN], expected);
        // The halves of the interval at both ends are left out.
        let ramp: Vec<f64> = [100.0].into_iter().chain((0..9).map(f64::from)).chain([-100.0]).collect();
        assert_eq!(figures(&ramp, interval_s)[1..PLAIN], [Some(4.0), Some(4.0)]);
        // 2 Hz is half the sampling rate: no band.
        assert_eq!(found[PLAIN..], [None; BANDS]);
    }

    #[test]
    fn nothing_is_not_zero() {
        assert_eq!(figures(&[1.0, f64::NAN, 2.0], 0.25), [None; PLAIN + BANDS]);
        assert_eq!(figures(&[3.0, 4.0, 5.0], 0.25)[1..], [None; PLAIN + BANDS - 1]);
    }

    #[test]
    fn names_are_those_of_the_nominal_frequencies() {
        let names = Octave::all().map(|band| in_band(band, 1e-3).name);
        assert_eq!(
            [0, 1, 9].map(|place| names[place].as_str()),
            ["heave_velocity_rms_31_5_hz_m_s", "heave_velocity_rms_63_hz_m_s", "heave_velocity_rms_16000_hz_m_s"]
        );
    }
}
