//! Statements of the paper on the process: energies, frequency, vibration of the arm, velocities.

use super::compared::{Evidence, EvidenceRow, FigureGroup, Printed, Tolerance};
use super::error::PaperError;
use super::lines::ArmLines;
use super::quoted::{
    ARM_DOMINANT_HZ, ARM_EXTENSION_M_S, ARM_HAMMERING_M_S, CASTING_DIFFERENCE_PERCENT, CHISEL_DIFFERENCE_PERCENT,
    FIRST_IMPACT_J, FREQUENCY_DIFFERENCE_PERCENT, HAMMERING_DIFFERENCE_PERCENT, IMPACT_FREQUENCY_HZ, LATER_IMPACTS_J,
    NATURAL_FREQUENCIES, NaturalFrequency, SECOND_PEAK_DIFFERENCE, SHIFTED_BELOW_HZ,
};
use super::rig::{DECAYED_S, Impact, Ours, Peaks, RmsVelocity, Supplied, Varied};
use decore_model::metrics::HammerMetrics;
use decore_statistics::signal::relative_difference;

/// Precision of "about 22 Hz" and 70 J in print.
const ENERGY_TOLERANCE: Tolerance = Tolerance::Share { of_calculation: 0.02, of_measurement: 0.05 };
/// Of vibrations.
const ARM_TOLERANCE: Tolerance = Tolerance::Share { of_calculation: 0.1, of_measurement: 0.1 };
const DIFFERENCE_TOLERANCE: Tolerance = Tolerance::PercentagePoints { most: 5.0 };

/// Compares energies, arm, velocities and quoted differences of the paper with ours.
///
/// # Errors
/// [`PaperError::Missing`] for an output that a run of the rig has.
pub(super) fn groups(ours: &Ours) -> Result<Vec<FigureGroup>, PaperError> {
    Ok(vec![blows(ours)?, arm(ours)?, velocities(ours)?, differences(ours)?])
}

/// An output that a run of the rig has.
fn known(value: Option<f64>, name: &'static str) -> Result<f64, PaperError> {
    value.ok_or(PaperError::Missing(name))
}

fn frequency_hz(hammer: &HammerMetrics) -> Result<f64, PaperError> {
    known(hammer.hit_frequency_hz, "frequency of blows")
}

fn blows(ours: &Ours) -> Result<FigureGroup, PaperError> {
    let hammer = ours.hammer()?;
    let figures = [
        Printed::calculated(
            "energy of the first impact",
            "J",
            FIRST_IMPACT_J,
            known(hammer.first_impact_energy_j, "first impact")?,
        ),
        Printed::calculated(
            "mean energy of later blows",
            "J",
            LATER_IMPACTS_J,
            known(hammer.periodic_energy_mean_j, "periodic blows")?,
        ),
        Printed::both("frequency of blows", "Hz", IMPACT_FREQUENCY_HZ, frequency_hz(hammer)?),
    ];
    let [_, measured_hz] = IMPACT_FREQUENCY_HZ;
    let supply = match supply_bar(&ours.supplies, measured_hz)? {
        Some(bar) => format!(
            "decore strikes at the measured {measured_hz} Hz if the hammer gets {bar:.2} bar. A pressure loss before the hammer would \
             explain this. The paper assumes 5 bar without fluctuations, and prints no pressure at the hammer."
        ),
        None => format!("At none of these supply pressures does decore reach the measured {measured_hz} Hz."),
    };
    Ok(FigureGroup {
        name: "Blows",
        source: "Sections 4.2 and 5",
        tolerance: ENERGY_TOLERANCE,
        figures: figures.map(|figure| ENERGY_TOLERANCE.judge(figure)).into(),
        remarks: vec![
            supply,
            resonance_remark(ours),
            constancy_remark(ours),
            "What the paper leaves open of the hammer (bores, ports, volumes) was calibrated to its 70 J, 12.2 J and 22 Hz: that these \
             agree shows that the model can, not that the values are those of the real hammer."
                .to_owned(),
        ],
        evidence: supply_evidence(ours),
    })
}

/// Blows and arm by supply.
fn supply_evidence(ours: &Ours) -> Vec<Evidence> {
    let of = |one: &Supplied, values: [Option<f64>; 3]| EvidenceRow::new(format!("{} bar", one.supply_bar), &values);
    let blows = |one: &Supplied| {
        let hammer = &one.hammer;
        of(one, [hammer.hit_frequency_hz, hammer.periodic_energy_mean_j, hammer.first_impact_energy_j])
    };
    let steadiness = |one: &Supplied| {
        of(one, [one.hammer.hit_frequency_hz, Some(100.0 * one.interval_spread), Some(one.steady_m_s())])
    };
    vec![
        Evidence::new(
            "Supply pressure at the hammer",
            &["blows (Hz)", "later (J)", "first (J)"],
            ours.supplies.iter().map(blows).collect(),
        ),
        Evidence::new(
            "Intervals of blows, and the arm once the first impact has decayed",
            &["blows (Hz)", "interval +- (%)", "arm RMS (m/s)"],
            ours.supplies.iter().map(steadiness).collect(),
        ),
    ]
}

/// The arm at the supplies that would explain the measured frequency.
fn resonance_remark(ours: &Ours) -> String {
    let Some((full, lower)) = ours.supplies.split_last() else { return String::new() };
    let ratios = || lower.iter().map(|one| one.steady_m_s() / full.steady_m_s());
    let (least, largest) = (ratios().fold(f64::INFINITY, f64::min), ratios().fold(0.0, f64::max));
    let distance = |mode: &&NaturalFrequency| (mode.calculated_hz - IMPACT_FREQUENCY_HZ[1]).abs();
    let nearest = NATURAL_FREQUENCIES.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let [calculated_hz, measured_hz] = nearest.map_or([f64::NAN; 2], |mode| [mode.calculated_hz, mode.measured_hz]);
    format!(
        "Contradiction: at these pressures the blows come near the machine's mode at {calculated_hz} Hz (measured {measured_hz} Hz). From \
         {DECAYED_S} s on, the arm's RMS is {least:.1} to {largest:.1} times the RMS at {} bar. The paper measured less vibration than it \
         calculated. So a lower pressure explains its frequency, but not its arm.",
        full.supply_bar
    )
}

/// The paper's words on how constant the frequency is.
fn constancy_remark(ours: &Ours) -> String {
    let largest = ours.supplies.iter().map(|one| one.interval_spread).fold(0.0, f64::max);
    format!(
        "Contradiction: the paper finds that the frequency is not constant, neither calculated nor measured. In decore the intervals of \
         blows differ by {:.2} % at most (standard deviation over mean), because supply and contacts are the same at every blow. The paper \
         prints no figure that shows the variation in its calculation.",
        100.0 * largest
    )
}

/// The supply in bar at which the blows come at a frequency, linear between those tried; `None` outside of them.
fn supply_bar(supplies: &[Supplied], wanted_hz: f64) -> Result<Option<f64>, PaperError> {
    for pair in supplies.windows(2) {
        let [below, above] = pair else { continue };
        let [low_hz, high_hz] = [frequency_hz(&below.hammer)?, frequency_hz(&above.hammer)?];
        if (low_hz..=high_hz).contains(&wanted_hz) {
            let share = (wanted_hz - low_hz) / (high_hz - low_hz);
            return Ok(Some(below.supply_bar + share * (above.supply_bar - below.supply_bar)));
        }
    }
    Ok(None)
}

fn arm(ours: &Ours) -> Result<FigureGroup, PaperError> {
    let hammer = ours.hammer()?;
    let extension_m_s = known(hammer.arm_rms_extension_m_s, "extension")?;
    let hammering_m_s = known(hammer.arm_rms_hammering_m_s, "hammering")?;
    let figures = [
        Printed::both("RMS during the extension", "m/s", ARM_EXTENSION_M_S, extension_m_s),
        Printed::both("RMS during hammering", "m/s", ARM_HAMMERING_M_S, hammering_m_s),
        Printed::both("strongest line, hammering", "Hz", ARM_DOMINANT_HZ, ours.arm_lines[0].strongest_hz),
        Printed::both("line by a Hann window", "Hz", ARM_DOMINANT_HZ, ours.arm_lines[1].strongest_hz),
        Printed::both("line in steady hammering", "Hz", ARM_DOMINANT_HZ, ours.arm_lines[2].strongest_hz),
    ];
    let remarks =
        vec![averaging_remark(ours), places_remark(ours, extension_m_s), damping_remark(ours), lines_remark(ours)];
    Ok(FigureGroup {
        name: "Velocity of the hammer arm",
        source: "Section 4.2, Figures 15 and 18",
        tolerance: ARM_TOLERANCE,
        figures: figures.map(|figure| ARM_TOLERANCE.judge(figure)).into(),
        remarks,
        evidence: arm_evidence(ours),
    })
}

/// The RMS figures of hammering, which no one averaging time explains.
fn averaging_remark(ours: &Ours) -> String {
    let [calculated, measured] = ARM_HAMMERING_M_S.map(|value| {
        let time =
            ours.averaging_time_s(value).map_or("no time".to_owned(), |time_s| format!("the first {time_s:.2} s"));
        format!("{value} m/s over {time}")
    });
    let steady_m_s = ours.supplies.last().map_or(f64::NAN, Supplied::steady_m_s);
    format!(
        "Unexplained: the paper treats both signals alike, so it averages over the same time. Its calculation is {:.2} times its \
         measurement. The RMS of decore falls with the time, because the first impact's transient decays. It is {calculated}, as the paper \
         calculates, and {measured}, as it measures. At most one of these times can be the paper's, which it does not print. Over the \
         whole run, and in steady hammering ({steady_m_s:.4} m/s from {DECAYED_S} s on), decore is below both.",
        ARM_HAMMERING_M_S[0] / ARM_HAMMERING_M_S[1]
    )
}

/// The strongest line by window and span.
fn lines_remark(ours: &Ours) -> String {
    let [rectangular, others @ ..] = &ours.arm_lines;
    let ratios = || others.iter().map(ArmLines::ratio);
    let (least, largest) = (ratios().fold(f64::INFINITY, f64::min), ratios().fold(0.0, f64::max));
    let [from_s, to_s] = rectangular.span_s;
    let [dominant_hz, measured_hz] = ARM_DOMINANT_HZ;
    format!(
        "Contradiction: in the paper's calculation, {dominant_hz} Hz is dominant and the line of the blows is underrepresented. In decore \
         {dominant_hz} Hz is the strongest line above {SHIFTED_BELOW_HZ} Hz only with a rectangular window over {:.2} s from the first \
         contact, where the first impact rings ({:.2} times the line of the blows). With a Hann window over the same time, and with either \
         window from {DECAYED_S} s on, the line of the blows is {least:.1} to {largest:.1} times as high. The paper states neither window \
         nor span. The measured {measured_hz} Hz differs in the paper too. The paper attributes this to its one damping ratio for all \
         modes.",
        to_s - from_s,
        1.0 / rectangular.ratio()
    )
}

/// Remark on the effect of the place on the arm.
fn places_remark(ours: &Ours, mount_m_s: f64) -> String {
    let [calculated, _] = ARM_EXTENSION_M_S;
    let distance = |place: &RmsVelocity| (place.extension_m_s - calculated).abs();
    let velocities = || ours.places.iter().map(|place| place.extension_m_s);
    let (least, largest) = (velocities().fold(f64::INFINITY, f64::min), velocities().fold(0.0, f64::max));
    let nearest = ours.places.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let nearest = nearest
        .map_or(String::new(), |place| format!(", {:.4} at {}, the nearest to it", place.extension_m_s, place.point));
    format!(
        "Extension: the figure depends on the place on the arm, which the paper shows in a picture only. decore has {mount_m_s:.4} m/s at \
         the mount, and {least:.4} to {largest:.4} m/s at the points below{nearest}."
    )
}

/// Remark on the effect of the damping.
fn damping_remark(ours: &Ours) -> String {
    let tried = ours.dampings.iter().filter_map(|varied| {
        Some(format!("{:.4} m/s at a ratio of {}", varied.hammer.arm_rms_hammering_m_s?, varied.value))
    });
    format!(
        "Damping: over the whole run, the RMS during hammering is {}. The paper's ratio is 0.02. No ratio reaches the paper's calculation. \
         The station has the machine's frequencies, not its geometry.",
        tried.collect::<Vec<_>>().join(", ")
    )
}

fn arm_evidence(ours: &Ours) -> Vec<Evidence> {
    let averaged = ours.averaged().map(|one| EvidenceRow::new(format!("{:.3} s", one.time_s), &[Some(one.rms_m_s)]));
    let place =
        |place: &RmsVelocity| EvidenceRow::new(place.point, &[Some(place.extension_m_s), Some(place.hammering_m_s)]);
    let rms = |label: String, hammer: &HammerMetrics| {
        EvidenceRow::new(label, &[hammer.arm_rms_extension_m_s, hammer.arm_rms_hammering_m_s])
    };
    let damping = |varied: &Varied| rms(format!("damping ratio {}", varied.value), &varied.hammer);
    let line = |lines: &ArmLines| {
        let [from_s, to_s] = lines.span_s;
        EvidenceRow::new(
            format!("{}, {from_s:.2} to {to_s:.1} s", lines.window.name()),
            &[Some(lines.strongest_hz), Some(lines.at_blows_m_s), Some(lines.at_dominant_m_s)],
        )
    };
    let columns = ["extension (m/s)", "hammering (m/s)"];
    vec![
        Evidence::new(
            "Lines of the mount's velocity by window and span",
            &["strongest (Hz)", "blows' (m/s)", "44 Hz (m/s)"],
            ours.arm_lines.iter().map(line).collect(),
        ),
        Evidence::new("Time after the first contact that is averaged over", &["RMS (m/s)"], averaged.collect()),
        Evidence::new("RMS at other points of arm and rail", &columns, ours.places.iter().map(place).collect()),
        Evidence::new("RMS at the mount by damping", &columns, ours.dampings.iter().map(damping).collect()),
    ]
}

/// The first impact and the blows after it.
fn first_and_later(ours: &Ours) -> Result<(&Impact, &[Impact]), PaperError> {
    ours.impacts.split_first().filter(|(_, later)| !later.is_empty()).ok_or(PaperError::Missing("later blows"))
}

fn mean(impacts: &[Impact], value: impl Fn(&Impact) -> f64) -> f64 {
    impacts.iter().map(value).sum::<f64>() / impacts.len() as f64
}

fn velocities(ours: &Ours) -> Result<FigureGroup, PaperError> {
    let (first, later) = first_and_later(ours)?;
    let row = |label: &str, value: fn(&Impact) -> f64| {
        EvidenceRow::new(label, &[Some(value(first)), later.first().map(value), Some(mean(later, value))])
    };
    let rows = vec![
        EvidenceRow::new("chisel at first contact (m/s)", &[Some(first.chisel_start_m_s), None, None]),
        row("chisel, peak (m/s)", |impact| impact.chisel.whole_m_s),
        row("  through the low-pass (m/s)", |impact| impact.chisel.low_passed_m_s),
        row("  whole over low-passed (%)", |impact| impact.chisel.excess_percent()),
        row("casting, peak (m/s)", |impact| impact.casting.whole_m_s),
        row("  through the low-pass (m/s)", |impact| impact.casting.low_passed_m_s),
        row("  whole over low-passed (%)", |impact| impact.casting.excess_percent()),
    ];
    let second = later.first().map_or(f64::NAN, |impact| impact.casting.whole_m_s);
    Ok(FigureGroup {
        name: "Velocities of chisel and casting",
        source: "Figures 16 and 17",
        tolerance: ENERGY_TOLERANCE,
        figures: Vec::new(),
        remarks: vec![
            "The paper prints curves without figures, so only its quoted differences (below) can be compared. It measured through a \
             low-pass of 4 kHz. These peaks of decore show the effect of such a filter (order 4, forwards and backwards; the paper names \
             no order)."
                .to_owned(),
            format!(
                "The paper's difference of {SECOND_PEAK_DIFFERENCE} at the casting's second peak has no unit. The whole second peak of \
                 decore is {second:.2} m/s."
            ),
        ],
        evidence: vec![Evidence::new(
            "Peaks within a blow's window",
            &["first impact", "second", "later, mean"],
            rows,
        )],
    })
}

fn differences(ours: &Ours) -> Result<FigureGroup, PaperError> {
    let hammer = ours.hammer()?;
    let percent = |ours: f64, [_, measured]: [f64; 2]| 100.0 * relative_difference(ours, measured);
    let printed = |[calculated, measured]: [f64; 2]| 100.0 * relative_difference(calculated, measured);
    let all = |of: fn(&Impact) -> &Peaks| mean(&ours.impacts, |impact| of(impact).excess_percent());
    let frequency = percent(frequency_hz(hammer)?, IMPACT_FREQUENCY_HZ);
    let hammering = percent(known(hammer.arm_rms_hammering_m_s, "hammering")?, ARM_HAMMERING_M_S);
    let (casting, chisel) = (all(|impact| &impact.casting), all(|impact| &impact.chisel));
    let figures = [
        Printed::difference("frequency of blows", FREQUENCY_DIFFERENCE_PERCENT, frequency),
        Printed::difference("arm, RMS during hammering", HAMMERING_DIFFERENCE_PERCENT, hammering),
        Printed::difference("casting velocity, low-pass", CASTING_DIFFERENCE_PERCENT, casting),
        Printed::difference("chisel velocity, low-pass", CHISEL_DIFFERENCE_PERCENT, chisel),
    ];
    let remarks = vec![
        format!(
            "Frequency and RMS: decore compared with the paper's measurement. The paper's own figures give {:.1} % for the frequency, \
             {:.1} % for the RMS during hammering and {:.1} % for the RMS during the extension.",
            printed(IMPACT_FREQUENCY_HZ),
            printed(ARM_HAMMERING_M_S),
            printed(ARM_EXTENSION_M_S)
        ),
        format!(
            "Casting: the paper prints no measured velocities. So the figure of decore is the effect of the low-pass alone, the mean of {} \
             blows: {casting:.0} of the quoted {CASTING_DIFFERENCE_PERCENT} %, if the paper's calculated curve was not filtered. The rest \
             is open: the paper measures at the casting's underside, while the casting of decore is a rigid body.",
            ours.impacts.len()
        ),
        format!(
            "Chisel: the same comparison gives {chisel:+.0} %, and the paper quotes {CHISEL_DIFFERENCE_PERCENT} %. Either its calculated \
             curve was filtered too, or other differences outweigh the filter. The paper does not state which velocity it took."
        ),
    ];
    Ok(FigureGroup {
        name: "Differences of calculation and measurement",
        source: "Section 5",
        tolerance: DIFFERENCE_TOLERANCE,
        figures: figures.map(|figure| DIFFERENCE_TOLERANCE.judge(figure)).into(),
        remarks,
        evidence: Vec::new(),
    })
}
