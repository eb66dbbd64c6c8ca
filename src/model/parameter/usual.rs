//! Usual range of a parameter's values, and the probable unit of a value outside it.

use super::range::{Fault, Numbers, short};

/// Numbers between which a value usually lies.
///
/// The ranges are wide: values outside are possible, but more likely a wrong unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Usual {
    /// Least of them.
    pub low: f64,
    /// Largest of them.
    pub high: f64,
    /// Unit of the parameter.
    pub unit: &'static str,
}

/// A unit that is taken for another one.
struct Other {
    name: &'static str,
    /// One of it in the parameter's unit.
    factor: f64,
    /// Offset of the conversion.
    offset: f64,
}

const fn other(name: &'static str, factor: f64) -> Other {
    Other { name, factor, offset: 0.0 }
}

/// Zero degrees Celsius in K.
const CELSIUS_K: f64 = 273.15;

/// Units that are taken for a parameter's own, the likeliest first.
fn others(unit: &str) -> &'static [Other] {
    match unit {
        "m" => const { &[other("mm", 1e-3), other("cm", 1e-2), other("um", 1e-6)] },
        "m2" => const { &[other("mm2", 1e-6), other("cm2", 1e-4)] },
        "m3" => const { &[other("mm3", 1e-9), other("cm3", 1e-6), other("litres", 1e-3)] },
        "m/s" => const { &[other("mm/s", 1e-3)] },
        "m/s2" => const { &[other("mm/s2", 1e-3)] },
        "kg" => const { &[other("g", 1e-3), other("t", 1e3)] },
        "kg m2" => const { &[other("kg mm2", 1e-6), other("kg cm2", 1e-4), other("g mm2", 1e-9)] },
        "s" => const { &[other("ms", 1e-3), other("us", 1e-6)] },
        "bar" => const { &[other("Pa", 1e-5), other("psi", 0.068_947_57), other("kPa", 1e-2), other("MPa", 10.0)] },
        "Pa" => const { &[other("bar", 1e5), other("hPa", 1e2), other("kPa", 1e3), other("MPa", 1e6)] },
        "N" => const { &[other("kN", 1e3)] },
        "N/m" => const { &[other("N/mm", 1e3), other("kN/mm", 1e6)] },
        "N s/m" => const { &[other("N s/mm", 1e3)] },
        "K" => const { &[Other { name: "degrees Celsius", factor: 1.0, offset: CELSIUS_K }] },
        "J/(kg K)" => const { &[other("kJ/(kg K)", 1e3)] },
        _ => &[],
    }
}

impl Usual {
    /// Whether a number lies between them.
    fn holds(&self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }

    /// Adds a remark for each number of a value outside the range. Numbers that are not finite are reported elsewhere.
    pub fn look(&self, value: &impl Numbers, at: &str, remarks: &mut Vec<Fault>) {
        value.visit(&mut |number| {
            if number.is_finite() && !self.holds(number) {
                remarks.push(Fault { path: at.to_owned(), message: self.remark(number) });
            }
        });
    }

    /// Remark on a number outside the usual range.
    fn remark(&self, number: f64) -> String {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        // Where a value went through other units, as pressures do, its last digits are rounding.
        let [number_text, low, high] = [rounded(number, 12), self.low, self.high].map(short);
        let words = format!("{number_text}{unit} is unusual, expected {low} to {high}{unit}");
        let converted = |other: &'static Other| (other, number * other.factor + other.offset);
        match others(self.unit).iter().map(converted).find(|(_, value)| self.holds(*value)) {
            Some((other, value)) => format!("{words}: is it in {} ({}{unit})?", other.name, short(rounded(value, 4))),
            None => words,
        }
    }
}

/// A number to some significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.0$e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remarks(value: &impl Numbers, (low, high, unit): (f64, f64, &'static str)) -> Vec<String> {
        let mut found = Vec::new();
        Usual { low, high, unit }.look(value, "x", &mut found);
        found.into_iter().map(|Fault { message, .. }| message).collect()
    }

    #[test]
    fn unusual_numbers_get_the_unit_in_which_they_are_usual() {
        let bar = (0.5, 16.0, "bar");
        assert_eq!(remarks(&4.0, bar), [""; 0]);
        assert_eq!(remarks(&4e5, bar), ["400000 bar is unusual, expected 0.5 to 16 bar: is it in Pa (4 bar)?"]);
        assert_eq!(remarks(&87.0, bar), ["87 bar is unusual, expected 0.5 to 16 bar: is it in psi (5.998 bar)?"]);
        assert_eq!(remarks(&1e308, bar), ["1e308 bar is unusual, expected 0.5 to 16 bar"]);
        let kilograms = (0.05, 500.0, "kg");
        assert_eq!(remarks(&3e3, kilograms), ["3000 kg is unusual, expected 0.05 to 500 kg: is it in g (3 kg)?"]);
        // Nobody states a casting in mg: nothing is suggested.
        assert_eq!(remarks(&3e6, kilograms), ["3000000 kg is unusual, expected 0.05 to 500 kg"]);
        let kelvin = (200.0, 450.0, "K");
        assert!(remarks(&20.0, kelvin)[0].ends_with("is it in degrees Celsius (293.1 K)?"));
        assert_eq!(remarks(&[0.3, 250.0], (0.01, 10.0, "m")).len(), 1);
        assert_eq!(remarks(&7.0, (1.0, 3.0, "1")), ["7 is unusual, expected 1 to 3"]);
        assert_eq!(remarks(&f64::NAN, kelvin), [""; 0], "no finite number has its fault elsewhere");
    }
}
