//! Figures of the paper. Its curves have no numbers, so only its tables and sentences can be compared.

/// Publication.
pub const CITATION: &str = "Mariadass, Binder, Ettemeyer, Volk, Günther, Appl. Mech. 2023, 4, 1206-1226";

/// A row of Table 3: a natural frequency of the machine with the hammer's housing.
#[derive(Debug, Clone, Copy)]
pub(super) struct NaturalFrequency {
    pub measured_hz: f64,
    pub calculated_hz: f64,
}

const fn row(measured_hz: f64, calculated_hz: f64) -> NaturalFrequency {
    NaturalFrequency { measured_hz, calculated_hz }
}

/// Table 3.
pub(super) const NATURAL_FREQUENCIES: [NaturalFrequency; 12] = [
    row(16.0, 16.29),
    row(18.0, 18.61),
    row(21.0, 19.93),
    row(44.0, 44.69),
    row(79.0, 81.55),
    row(85.0, 84.81),
    row(90.0, 91.53),
    row(118.0, 117.35),
    row(148.0, 144.0),
    row(208.0, 212.0),
    row(231.0, 231.85),
    row(271.0, 278.61),
];
/// Measured natural frequencies in Hz that its calculation does not have (Section 4.1).
pub(super) const NOT_CALCULATED_HZ: [f64; 3] = [25.0, 32.0, 54.0];
/// Highest frequency in Hz of the isolators' modes (Section 4.1).
pub(super) const ISOLATORS_HZ: f64 = 10.0;
/// Energy of the first impact from rest, J (Section 5).
pub(super) const FIRST_IMPACT_J: f64 = 70.0;
/// Mean energy of the later impacts, J (Section 5).
pub(super) const LATER_IMPACTS_J: f64 = 12.2;
/// Frequency of the periodic impacts, Hz, calculated and measured, both "around" (Section 4.2).
pub(super) const IMPACT_FREQUENCY_HZ: [f64; 2] = [22.0, 20.5];
/// RMS velocity of the hammer arm during the extension, m/s, calculated and measured (Section 4.2).
pub(super) const ARM_EXTENSION_M_S: [f64; 2] = [0.0216, 0.0209];
/// RMS velocity of the hammer arm during hammering, m/s, calculated and measured (Section 4.2).
pub(super) const ARM_HAMMERING_M_S: [f64; 2] = [0.0254, 0.0137];
/// Frequency in Hz that dominates the arm during hammering, calculated and measured (Section 4.2).
pub(super) const ARM_DOMINANT_HZ: [f64; 2] = [44.0, 81.0];
/// Below this frequency in Hz the paper sets the shifted lines apart (Section 4.2).
pub(super) const SHIFTED_BELOW_HZ: f64 = 15.0;
/// Difference of calculation and measurement in the frequency of impacts, % (Section 5).
pub(super) const FREQUENCY_DIFFERENCE_PERCENT: f64 = 6.5;
/// The same of the arm's RMS velocity during hammering, % (Section 5).
pub(super) const HAMMERING_DIFFERENCE_PERCENT: f64 = 85.0;
/// The same of the chisel's impact velocity on average, % (Section 5).
pub(super) const CHISEL_DIFFERENCE_PERCENT: f64 = -6.56;
/// The same of the casting's velocity on average, % (Section 5).
pub(super) const CASTING_DIFFERENCE_PERCENT: f64 = 48.32;
/// Difference of the casting's second peak, without a unit (Section 4.2).
pub(super) const SECOND_PEAK_DIFFERENCE: f64 = 3.85;
